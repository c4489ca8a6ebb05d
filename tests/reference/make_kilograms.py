"""Writes kilograms.txt: beams that capture a mass given in kilograms, over long times.

The mass ratio m/(ρAl) is no binary64 number, and what a rounding of it does to a phase grows with time: to 1e-5 rad in 1e7 s.
"""

from fractions import Fraction

from mpmath import mpf, pi, sqrt

from beam import Shape, cosine_like, modal_velocity, sine_like, use_digits
from table import write_table

COUNT, OMEGA = 12, 50.0
BEAMS = [  # mass, length, diameter, area, second moment; the paper's material
    (1.7, 1.0, 0.037, 0.0, 0.0),
    (0.003, 1.3, 0.037, 0.0, 0.0),
    (25.0, 0.7, 0.0, 1.1e-3, 9.3e-8),
]
DENSITY, YOUNGS_MODULUS = 7870.0, 2e11
DURATIONS = [1.0, 1e3, 1e5, 1e7]
SAMPLES = 1000


def section(diameter, area, second_moment):
    """Area and √(I/A), from what is given."""
    if diameter:
        return pi * mpf(diameter) ** 2 / 4, mpf(diameter) / 4
    return mpf(area), sqrt(mpf(second_moment) / mpf(area))


def rows():
    free = [Shape(i, 0.0) for i in range(1, COUNT + 1)]
    for mass, length, *sizes in BEAMS:
        area, radius = section(*sizes)
        unit = radius * sqrt(mpf(YOUNGS_MODULUS) / mpf(DENSITY)) / mpf(length) ** 2
        shapes = [Shape(k, mpf(mass) / (mpf(DENSITY) * area * mpf(length))) for k in range(1, COUNT + 1)]
        speeds = [modal_velocity(shape, free) for shape in shapes]
        squares = [unit**2 * shape.alpha**4 - mpf(OMEGA) ** 2 for shape in shapes]
        for duration in DURATIONS:
            for number in (1, 500, 999):
                exact = Fraction(duration) * number / SAMPLES
                time = mpf(exact.numerator) / exact.denominator
                for xi in (0.5, 1.0):
                    values = [shape.value(mpf(xi)) for shape in shapes]
                    yield (mass, length, *sizes, OMEGA, COUNT, duration, SAMPLES, number, xi,
                           sum(q * v * sine_like(b, time) for q, v, b in zip(speeds, values, squares)),
                           sum(q * v * cosine_like(b, time) for q, v, b in zip(speeds, values, squares)))


use_digits(150)
write_table("kilograms.txt", f"""
Displacement (m) and velocity (m/s) at xi = x/l and the exact time j duration/samples of a beam of density {DENSITY} and Young's
modulus {YOUNGS_MODULUS:.0e} (SI; diameter, or area and second moment) after it caught a mass in kg at restitution 0 and 1 m/s;
`count` modes before and after
""", ["mass", "length", "diameter", "area", "second_moment", "omega", "count", "duration", "samples", "j", "xi",
              "displacement", "velocity"], rows())
