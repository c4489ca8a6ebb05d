"""Writes slope_integrals.txt."""

from mpmath import mpf

from beam import Shape, use_digits
from table import write_table

MASS_RATIOS = [0.0, 1e-6, 0.2, 1.0, 10.0, 1e4, 1e6, 1e12]
NUMBERS = [1, 2, 3, 5, 10, 40, 237, 1000, 10**5]


def moment(shape, order, power):
    """∫₀¹ ξ^power of the square of the shape's derivative of that order, each exponential integrated by itself."""
    total = mpf(0)
    for c, a, end in shape.terms:
        for d, b, other_end in shape.terms:
            total += c * d * (a * b) ** order * weighted(a + b, end * other_end, power)
    return total.real


def weighted(rate, end, power):
    """∫₀¹ ξ^power exp(rate ξ) dξ, by parts; `end` is exp(rate)."""
    if rate == 0:
        return mpf(1) / (power + 1)
    value = (end - 1) / rate
    for n in range(1, power + 1):
        value = (end - n * value) / rate
    return value


def rows():
    for gamma in MASS_RATIOS:
        for k in NUMBERS:
            shape = Shape(k, gamma)
            yield (gamma, k, *(moment(shape, 1, power) for power in range(3)), moment(shape, 3, 0) / shape.alpha**4)


use_digits(400)
write_table("slope_integrals.txt", """
Of the shapes of Eqs 7 and 18: integrals over 0 <= xi <= 1 of the squared slope, of xi and xi^2 times that, and of the squared
third derivative over alpha^4
""", ["gamma", "k", "slope_0", "slope_1", "slope_2", "third"], rows())
