"""Writes jumps.txt, cross_integrals.txt, modal_velocities.txt and many_velocities.txt."""

from itertools import product

from mpmath import digamma, mp, mpc, mpf, pi

from beam import Jump, Shape, product_integral, root, use_digits, velocity_terms
from table import write_table

MASS_RATIOS = [1e-12, 1e-6, 0.2, 1.0, 10.0, 1e6, 1e12]
COUNTS = [(1, 1), (2, 2), (5, 5), (20, 20), (40, 40), (5, 20), (20, 5), (40, 60), (60, 40), (1, 200), (200, 200)]
MANY_COUNTS = [(30_000, 30_000), (30_000, 3000), (3000, 30_000), (10**6, 10**6)]
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


def pole_sum(first, last, mu):
    """The sum of 1/(α_i⁴ − μ⁴) over free modes, by partial fractions: the first hundred as they are, the others, whose
    roots are (i − ½)π to 130 digits, by digamma functions."""
    near = sum((1 / (root(i, 0.0) ** 4 - mu**4) for i in range(first, min(last, 100) + 1)), mpf(0))
    first = max(first, 101)
    if first > last:
        return near

    def squares(m):  # sum of 1/((i − ½)²π² − m²π²)
        x = mpf(1) / 2
        ends = digamma(last + x - m) - digamma(first - x - m) - digamma(last + x + m) + digamma(first - x + m)
        return (ends / (2 * m)).real / pi**2

    return near + (squares(mu / pi) - squares(mpc(0, mu / pi))) / (2 * mu**2)


def many_terms(shape, k, before):
    """Sum of the terms of Eq. 26 and of their magnitudes: in the sum over i of 4α_i⁴/(α_i⁴ − ᾱ_k⁴), which the two-shape
    identity leaves, those with i < k are negative."""
    scale = Jump(shape.gamma, before, 0).impulse * shape.gamma * shape.tip / shape.modal_mass()
    parts = [(1, min(k - 1, before)), (k, before)]
    below, above = (4 * (last - first + 1 + shape.alpha**4 * pole_sum(first, last, shape.alpha)) if first <= last else 0
                    for first, last in parts)
    return scale * (below + above), abs(scale) * (above - below)


def many_velocities():
    for gamma in [1e-6, 0.2, 1e6]:
        terms = velocity_terms(Shape(180, gamma), [Shape(i, 0.0) for i in range(1, 201)])
        plain, magnitudes = many_terms(Shape(180, gamma), 180, 200)
        assert abs(plain - sum(terms)) < mpf(10) ** -60 * magnitudes
        assert abs(magnitudes - sum(abs(term) for term in terms)) < mpf(10) ** -60 * magnitudes
        for before, after in MANY_COUNTS:
            numbers = {1, 2, 3, 64, 65, 128, 1000, 3000, after // 2, *range(before - 2, before + 4), after - 1, after}
            for k in sorted(k for k in numbers if 1 <= k <= after):
                yield gamma, before, after, k, *many_terms(Shape(k, gamma), k, before)


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
write_table("many_velocities.txt", """
As modal_velocities.txt, of many modes: the sum over those before the capture by partial fractions and digamma functions.
""", ["gamma", "before", "after", "k", "modal_velocity", "magnitudes"], many_velocities())
