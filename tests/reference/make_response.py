"""Writes responses.txt: the paper's beam after a capture."""

from fractions import Fraction

from mpmath import mpf, sqrt

from beam import PaperBeam, Shape, cosine_like, modal_velocity, sine_like, use_digits
from table import write_table

POSITIONS = [0.1, 0.5, 1.0]
LARGEST_EXPONENT = 690  # sinh stays within binary64


def near_critical(beam, gamma):
    """Angular velocities around the critical one, the binary64 number nearest to it among them."""
    critical = beam.critical_speed(gamma)
    offsets = [sign * mpf(10) ** -power for power in (3, 6, 9, 12, 15) for sign in (-1, 1)]
    return sorted({float(critical * (1 + offset)) for offset in [mpf(0), *offsets]})


def cases(beam):
    """(gamma, omega, before, after, duration, samples, sample numbers)."""
    for omega in (0.0, 50.0, 100.0):
        yield 0.2, omega, 40, 40, 1.0, 65536, (1, 1000, 32768, 65535)
        yield 0.2, omega, 20, 30, 0.1, 3, (1, 2)
        for gamma in (1e-6, 1.0, 1e6):
            yield gamma, omega, 20, 20, 0.7, 7, (1, 6)
        for duration in (1e3, 1e6, 1e9):
            yield 0.2, omega, 20, 20, duration, 1000, (1, 999)
    for omega in near_critical(beam, 0.2):
        for duration in (1.0, 1e3, 1e6, 1e9):
            yield 0.2, omega, 5, 5, duration, 8, (1, 7)
    for omega in (130.0, 170.0):
        yield 0.2, omega, 5, 5, 6.0, 8, (1, 7)


def largest_exponent(beam, shapes, omega, time):
    return max(sqrt(max(0, -beam.beta_squared(shape.alpha, omega))) for shape in shapes) * time


def responses(beam):
    known = {}
    for gamma, omega, before, after, duration, samples, numbers in cases(beam):
        if (gamma, before, after) not in known:
            free = [Shape(i, 0.0) for i in range(1, before + 1)]
            shapes = [Shape(k, gamma) for k in range(1, after + 1)]
            known[gamma, before, after] = shapes, [modal_velocity(shape, free) for shape in shapes]
        shapes, speeds = known[gamma, before, after]
        squares = [beam.beta_squared(shape.alpha, omega) for shape in shapes]
        for number in numbers:
            exact = Fraction(duration) * number / samples
            time = mpf(exact.numerator) / exact.denominator
            if largest_exponent(beam, shapes, omega, time) > LARGEST_EXPONENT:
                continue
            for xi in POSITIONS:
                values = [shape.value(mpf(xi)) for shape in shapes]
                yield (gamma, omega, before, after, duration, samples, number, xi,
                       sum(q * v * sine_like(b, time) for q, v, b in zip(speeds, values, squares)),
                       sum(q * v * cosine_like(b, time) for q, v, b in zip(speeds, values, squares)))


use_digits(150)
write_table("responses.txt", """
Displacement (m) and velocity (m/s) of the paper's beam (length 1, diameter 0.037, density 7870, Young's modulus
2e11) at xi = x/l and at the exact time j duration/samples, after it caught a mass at restitution 0 and
1 m/s; `before` and `after` are the numbers of modes
""", ["gamma", "omega", "before", "after", "duration", "samples", "j", "xi", "displacement", "velocity"],
            responses(PaperBeam()))
