"""Writes curvatures.txt."""

from random import Random

from mpmath import exp, mpf

from beam import MASS_RATIOS, Shape, use_digits
from table import write_table

NUMBERS = [1, 2, 3, 10, 50, 237, 1000, 10**6]
POSITIONS = [0.0, 1e-9, 1e-4, 0.01, 0.1, 1 / 3, 0.5, 0.95, 1 - 1e-4, 1 - 1e-9, 1.0]
RANDOM_POSITIONS = 3  # for each shape, besides


def scaled_curvature(shape, xi):
    """Φ''(ξ)/α²."""
    return sum((c * rate**2 * exp(rate * xi) for c, rate, _ in shape.terms), mpf(0)).real / shape.alpha**2


def curvatures():
    random = Random(2016)
    for gamma in MASS_RATIOS:
        for k in NUMBERS:
            shape = Shape(k, gamma)
            for xi in sorted([*POSITIONS, *(random.random() for _ in range(RANDOM_POSITIONS))]):
                value = scaled_curvature(shape, mpf(xi))
                yield gamma, k, xi, value if xi < 1 else mpf(0)


use_digits(1000)
write_table("curvatures.txt", """
Of the shapes of Eqs 7 and 18: their second derivative by xi over alpha^2
""", ["gamma", "k", "xi", "curvature"], curvatures())
