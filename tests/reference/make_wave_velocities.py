"""Writes frequencies.txt and wave_velocities.txt: the paper's beam around the critical angular velocity of each mode."""

from math import inf, nextafter

from mpmath import mpf, sqrt

from beam import PaperBeam, root, use_digits
from table import write_table

MASS_RATIOS = [0.0, 1e-6, 0.2, 1.0, 1e6]
MODES = [1, 2, 3, 10]


def speeds(critical):
    """Angular velocities from 0 to beyond a mode's critical one, most of them close to it."""
    nearest = float(critical)
    offsets = [sign * mpf(10) ** -power for power in range(1, 16) for sign in (-1, 1)]
    around = [nextafter(nearest, 0.0), nearest, nextafter(nearest, inf)]
    return sorted({0.0, 50.0, 100.0, *around, *(float(critical * (1 + offset)) for offset in offsets)})


def cases(beam):
    for gamma in MASS_RATIOS:
        for k in MODES:
            for omega in speeds(beam.critical_speed(gamma, k)):
                yield gamma, k, omega


def frequencies(beam):
    for gamma, k, omega in cases(beam):
        square = beam.beta_squared(root(k, gamma), omega)
        yield gamma, k, omega, square, sqrt(abs(square))


def wave_velocities(beam):
    for gamma, k, omega in cases(beam):
        wavenumber = root(k, gamma)  # the length is 1
        square = beam.beta_squared(wavenumber, omega)
        if square > 0:
            beta = sqrt(square)
            yield gamma, k, omega, wavenumber, beta / wavenumber, 2 * beam.h**2 * wavenumber**3 / beta


use_digits(100)
paper_beam = PaperBeam()
write_table("frequencies.txt", """
Eq. 30 around the critical angular velocity of mode k: beta squared (rad2/s2), negative for an unstable mode,
and the root of its size (rad/s), the angular frequency or the growth rate
""", ["gamma", "k", "omega", "beta_squared", "beta"], frequencies(paper_beam))
write_table("wave_velocities.txt", """
Eqs 32 and 33 where the mode is stable: phase and group velocity (m/s)
""", ["gamma", "k", "omega", "wavenumber", "phase_velocity", "group_velocity"], wave_velocities(paper_beam))
