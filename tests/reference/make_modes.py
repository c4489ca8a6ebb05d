"""Writes roots.txt, shapes.txt, modal_quantities.txt and clamped_pinned.txt."""

from random import Random

from mpmath import mpf

from beam import MASS_RATIOS, Shape, clamped_pinned_root, product_integral, root, use_digits
from table import write_table

ROOT_NUMBERS = [*range(1, 31), 50, 100, 237, 300, 1000, 12345, 10**5, *range(318308, 318313), 10**6, 10**7, 54321098,
                10**8 - 1, 10**8]
SHAPE_NUMBERS = [1, 2, 3, 5, 10, 12, 20, 50, 100, 237, 300, 1000, 10**4, 10**6]
MODAL_NUMBERS = [1, 2, 3, 4, 5, 10, 12, 20, 50, 100, 237, 300, 1000, 12345, 10**5, 10**6, 10**7, 10**8]
POSITIONS = [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 1 / 3, 0.5, 0.7, 0.95, 0.999, 1 - 1e-4, 1 - 1e-6, 1 - 1e-9,
             1 - 1e-12, 1.0]
RANDOM_POSITIONS = 6  # for each shape, besides


def roots():
    for gamma in MASS_RATIOS:
        for k in ROOT_NUMBERS:
            alpha = root(k, gamma)
            yield gamma, k, alpha, root(k, 0.0) - alpha


def shapes():
    random = Random(2002)
    for gamma in MASS_RATIOS:
        for k in SHAPE_NUMBERS:
            shape = Shape(k, gamma)
            for xi in sorted([*POSITIONS, *(random.random() for _ in range(RANDOM_POSITIONS))]):
                value = shape.value(mpf(xi))
                if k <= 300:
                    assert abs(value - shape.plain_value(mpf(xi))) <= mpf(10) ** -60 * abs(value), (gamma, k, xi)
                yield gamma, k, xi, value


def modal_quantities():
    for gamma in MASS_RATIOS:
        for k in MODAL_NUMBERS:
            shape = Shape(k, gamma)
            yield (gamma, k, shape.sigma, shape.one_minus_sigma_scaled(), shape.tip, shape.tip_slope,
                   product_integral(shape, shape), shape.modal_mass())


def limits():
    for k in [*range(1, 31), 100, 1000, 10**5, 10**7]:
        yield k, clamped_pinned_root(k)


use_digits(1000)
write_table("roots.txt", """
Roots of Eq. 19 (Eq. 8 for gamma = 0): alpha, and drop = alpha(gamma = 0) - alpha(gamma) of the same k
""", ["gamma", "k", "alpha", "drop"], roots())
write_table("shapes.txt", """
Shapes of Eqs 7 and 18 at xi = x/l, not normalised further
""", ["gamma", "k", "xi", "shape"], shapes())
write_table("modal_quantities.txt", """
Of the shapes of Eqs 7 and 18: sigma, (1 - sigma) exp(alpha), the shape and its slope at xi = 1,
the integral of its square, and that plus gamma times the square of the tip value (modal mass over beam mass)
""", ["gamma", "k", "sigma", "one_minus_sigma_scaled", "tip", "tip_slope", "square_integral", "modal_mass"],
            modal_quantities())
write_table("clamped_pinned.txt", """
Roots of tan(alpha) = tanh(alpha): those that follow the first one as gamma grows without bound
""", ["k", "alpha"], limits())
