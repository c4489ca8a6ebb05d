"""Writes lines.txt: what a measurement should find in histories of the paper's beam after the capture."""

from mpmath import mpf, sqrt

from beam import PaperBeam, Shape, modal_velocity, use_digits
from table import write_table

GAMMA, OMEGA, MODES = 0.2, 50.0, 40


def lines(beam, free):
    """Per mode: Eqs 30, 32, 33 and the amplitudes of sin βt; no free modes stand for infinitely many."""
    for k in range(1, MODES + 1):
        shape = Shape(k, GAMMA)
        wavenumber = shape.alpha  # the length is 1
        beta = sqrt(beam.beta_squared(wavenumber, OMEGA))
        velocity = modal_velocity(shape, free) if free else shape.gamma * shape.tip / shape.modal_mass()
        yield (len(free), k, wavenumber, beta, beta / wavenumber, 2 * beam.h**2 * wavenumber**3 / beta,
               velocity * shape.tip / beta, velocity * shape.value(mpf(1) / 2) / beta)


use_digits(150)
free_modes = [Shape(i, 0.0) for i in range(1, MODES + 1)]
write_table("lines.txt", f"""
The lines of the paper's beam (1 m) at mass ratio {GAMMA} and {OMEGA} rad/s, struck at 1 m/s, restitution 0: wave number (1/m),
angular frequency (rad/s), phase and group velocity (m/s), amplitude (m) of sin(angular_frequency t) at tip and midpoint.
`before` is the number of modes before the capture (Eq. 26), 0 for the limit of infinitely many
""", ["before", "k", "wavenumber", "angular_frequency", "phase_velocity", "group_velocity", "tip", "midpoint"],
            [row for free in ([], free_modes) for row in lines(PaperBeam(), free)])
