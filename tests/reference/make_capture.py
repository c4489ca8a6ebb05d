"""Writes jumps.txt, cross_integrals.txt and modal_velocities.txt."""

from itertools import product

from beam import Jump, Shape, product_integral, use_digits, velocity_terms
from table import write_table

MASS_RATIOS = [1e-12, 1e-6, 0.2, 1.0, 10.0, 1e6, 1e12]
COUNTS = [(1, 1), (2, 2), (5, 5), (20, 20), (40, 40), (5, 20), (20, 5), (40, 60), (60, 40), (1, 200), (200, 200)]
LARGE_COUNTS = [(2000, 2000), (2000, 1), (500, 2000), (2000, 500)]
PAIRS = [(1, 1), (1, 2), (2, 1), (3, 3), (5, 7), (12, 12), (12, 13), (20, 20), (40, 41), (41, 40), (100, 100),
         (200, 3), (3, 200), (237, 237), (300, 299), (1000, 1000), (1000, 1001), (2000, 2000), (1, 2000), (2000, 1)]


def picked(before, after):
    """Some mode numbers after the capture: the first, those around the number before, the last."""
    numbers = [1, 2, 3, 4, 5, 7, 10, 20, 30, *range(before - 2, before + 4), after - 1, after]
    return sorted({k for k in numbers if 1 <= k <= after})


def jumps():
    for gamma in MASS_RATIOS:
        for count in [1, 2, 5, 10, 20, 40, 50, 200, 2000, 10**4]:
            for restitution in [0.0, 0.5, 1.0]:
                jump = Jump(gamma, count, restitution)
                yield gamma, count, restitution, jump.impulse, jump.mass_velocity, jump.tip_velocity


def cross_integrals():
    for gamma in MASS_RATIOS:
        for k, i in PAIRS:
            yield gamma, k, i, product_integral(Shape(k, gamma), Shape(i, 0.0))


def modal_velocities():
    free = [Shape(i, 0.0) for i in range(1, 2001)]
    for gamma, (before, after) in product(MASS_RATIOS, COUNTS + LARGE_COUNTS):
        for k in picked(before, after):
            terms = velocity_terms(Shape(k, gamma), free[:before])
            yield gamma, before, after, k, sum(terms), sum(abs(term) for term in terms)


use_digits(150)
write_table("jumps.txt", """
The impact on `count` clamped-free modes: impulse over beam mass times approach velocity, the velocity of the
mass and of the tip just after it over the approach velocity
""", ["gamma", "count", "restitution", "impulse", "mass_velocity", "tip_velocity"], jumps())
write_table("cross_integrals.txt", """
Integral from xi = 0 to 1 of shape k with the tip mass times shape i without
""", ["gamma", "k", "i", "integral"], cross_integrals())
write_table("modal_velocities.txt", """
Eq. 26 for restitution 0: modal velocity k after the capture over the approach velocity, the impact having
set `before` modes in motion; `after` is the number kept; and the sum of the magnitudes of its terms.
With restitution e all are 1 + e times as large.
""", ["gamma", "before", "after", "k", "modal_velocity", "magnitudes"], modal_velocities())
