"""Writes continuum.txt: the paper's beam after a capture, from infinitely many modes before it and very many after it.

Mode shapes, modal masses and projections have no part here: the displacement is the inverse Laplace transform of the
answer of beam and mass to the impulse that the mass brings, term by term the residues at the roots of the frequency
equation, -2 gamma N(xi, alpha)/f'(alpha) sin(beta t)/beta with
N = (cosh a xi - cos a xi)(sinh a + sin a) - (sinh a xi - sin a xi)(cosh a + cos a), multiplied out.
"""

import math
from fractions import Fraction

from mpmath import cos, exp, mpf, pi, sin, sqrt

from beam import PaperBeam, root, use_digits
from table import write_table

POSITIONS = [0.1, 0.5, 1.0]
PLAIN_ROOTS = 12  # found by bisection, from the definition
TERMS = 200_000  # the last half of them changes a value by `change`

# (gamma, omega, duration, samples, sample numbers)
CASES = [
    (0.2, 50.0, 1.0, 65536, (1, 777, 16384, 40001, 65535)),
    (1.0, 0.0, 0.25, 4096, (3, 1000, 2048, 4095)),
    (0.01, 100.0, 0.1, 1000, (1, 250, 501, 999)),
]


def far_root(k, gamma):
    """Newton's method in binary64 for the place between the multiples of pi, then once in full precision.

    Divided by cosh a, whose reciprocal is below 1e-15 from mode 12 on; the last step knows it again."""
    anchor = (k - 0.75) * math.pi
    delta = 0.0
    for _ in range(60):
        u = 1 / (gamma * (anchor + delta))
        delta -= (math.sin(delta) * (2 + u) - math.cos(delta) * u) / (math.cos(delta) * (2 + u) + math.sin(delta) * u)
    alpha = (k - mpf(3) / 4) * pi + mpf(delta)
    g = mpf(gamma)
    for _ in range(2):
        s, c, tiny = sin(alpha), cos(alpha), exp(-alpha)
        tanh, sech = (1 - tiny**2) / (1 + tiny**2), 2 * tiny / (1 + tiny**2)
        f = sech + c + alpha * g * (c * tanh - s)
        alpha -= f / ((1 + g) * (c * tanh - s) - 2 * alpha * g * s * tanh)
    return alpha


def residues(alpha, gamma):
    """-2 gamma N/f' at each position, both divided by exp(alpha)."""
    s, c, small = sin(alpha), cos(alpha), exp(-alpha)
    sh, ch = (1 - small**2) / 2, (1 + small**2) / 2
    slope = (1 + gamma) * (c * sh - s * ch) - 2 * alpha * gamma * s * sh
    for xi in map(mpf, POSITIONS):
        x, y = alpha * xi, alpha * (1 - xi)
        sx, cx = sin(x), cos(x)
        grow, decay = exp(-y), exp(-alpha - x)  # exp x and exp(-x), over exp(alpha)
        rest = (exp(-x) - exp(-alpha - y)) / 2  # sinh y over exp(alpha)
        n = rest + (grow + decay) / 2 * s - (grow - decay) / 2 * c - cx * sh + sx * ch + (sx * c - cx * s) * small
        yield -2 * gamma * n / slope


def responses(beam):
    for gamma, omega, duration, samples, numbers in CASES:
        g = mpf(gamma)
        exact = [Fraction(duration) * number / samples for number in numbers]
        times = [mpf(time.numerator) / time.denominator for time in exact]
        sums = [[mpf(0) for _ in POSITIONS] for _ in times]
        for k in range(1, TERMS + 1):
            alpha = root(k, gamma) if k <= PLAIN_ROOTS else far_root(k, gamma)
            beta = sqrt(beam.beta_squared(alpha, omega))
            parts = list(residues(alpha, g))
            for j, time in enumerate(times):
                turn = sin(beta * time) / beta
                for p, part in enumerate(parts):
                    sums[j][p] += part * turn
            if k == TERMS // 2:
                half = [list(row) for row in sums]
        for j, number in enumerate(numbers):
            for p, xi in enumerate(POSITIONS):
                yield gamma, omega, duration, samples, number, xi, sums[j][p], float(abs(sums[j][p] - half[j][p]))


if __name__ == "__main__":
    use_digits(45)
    write_table("continuum.txt", f"""
Displacement (m) of the paper's beam (length 1, diameter 0.037, density 7870, Young's modulus 2e11) at xi = x/l and
at the exact time j duration/samples, after it caught a mass at restitution 0 and 1 m/s, infinitely many modes
before: {TERMS} residues; the last half of them changed the value by `change`
""", ["gamma", "omega", "duration", "samples", "j", "xi", "displacement", "change"],
                responses(PaperBeam()))
