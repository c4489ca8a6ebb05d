"""Writes paper_effects.txt: what rotation, its tension and shear make of the paper's beam with its captured mass."""

from mpmath import findroot, mpf, sqrt

from beam import PaperBeam, root, use_digits
from effects_beam import Case, exponential_determinant, series_determinant
from table import write_table

GAMMA, OMEGA, POISSON = 0.2, 50.0, 0.3
TERMS = 120  # of the power series: mode 1 takes 40


def frequency(determinant, near, h):
    """rad/s, of the root of a determinant in β² near a value."""
    return h * sqrt(findroot(determinant, (near, near * mpf("1.01")), solver="secant"))


def rows():
    h = PaperBeam().h  # l = 1 m: h is the unit of frequency
    spin = mpf(OMEGA) / h
    rotary = (mpf(0.037) / 4) ** 2
    nu = mpf(POISSON)
    compliance = 2 * (1 + nu) * (7 + 6 * nu) / (6 * (1 + nu)) * rotary
    first, tenth = root(1, GAMMA) ** 4, root(10, GAMMA) ** 4
    turning = Case(omega=spin, hub=0.0, gamma=GAMMA)
    shearing = Case(omega=spin, gamma=GAMMA, compliance=compliance, rotary=rotary)
    yield 1, 0.0, 0, 0, h * sqrt(first)
    yield 1, OMEGA, 0, 0, h * sqrt(first - spin**2)
    yield 1, OMEGA, 1, 0, frequency(lambda b: series_determinant(turning, TERMS, b), first, h)
    yield 10, OMEGA, 0, 0, h * sqrt(tenth - spin**2)
    yield 10, OMEGA, 0, 1, frequency(lambda b: exponential_determinant(shearing, b), mpf("0.775") * tenth, h)


use_digits(60)
write_table("paper_effects.txt", f"""
Modes k of the paper's beam (1 m) with the captured mass at mass ratio {GAMMA}, rotating in plane at omega (rad/s): angular frequency
(rad/s), with the tension of the rotation (hub radius 0) where `tension` is 1, with shear (Poisson's ratio {POISSON}, Cowper's
coefficient) where `shear` is 1
""", ["k", "omega", "tension", "shear", "angular_frequency"], rows())
