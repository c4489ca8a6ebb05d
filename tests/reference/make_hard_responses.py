"""Writes critical_responses.txt, long_responses.txt and overflows.txt: the paper's beam after a capture, at the edges."""

from fractions import Fraction
from math import inf, nextafter
from sys import float_info

from mpmath import mpf, sqrt

from beam import PaperBeam, Shape, cosine_like, modal_velocity, sine_like, use_digits
from table import write_table

POSITIONS = [0.1, 0.5, 1.0]
GAMMA = 0.2


class Motion:
    """The paper's beam after it caught a mass at restitution 0 and 1 m/s, with `count` modes before and after."""

    def __init__(self, count):
        self.beam = PaperBeam()
        self.shapes = [Shape(k, GAMMA) for k in range(1, count + 1)]
        free = [Shape(i, 0.0) for i in range(1, count + 1)]
        self.speeds = [modal_velocity(shape, free) for shape in self.shapes]
        self.values = {xi: [shape.value(mpf(xi)) for shape in self.shapes] for xi in POSITIONS}

    def squares(self, omega):
        return [self.beam.beta_squared(shape.alpha, omega) for shape in self.shapes]

    def at(self, xi, time, squares):
        """Displacement and velocity."""
        parts = [q * v for q, v in zip(self.speeds, self.values[xi])]
        return (sum(p * sine_like(b, time) for p, b in zip(parts, squares)),
                sum(p * cosine_like(b, time) for p, b in zip(parts, squares)))

    def rows(self, omega, duration, samples, numbers):
        squares = self.squares(omega)
        for number in numbers:
            exact = Fraction(duration) * number / samples
            time = mpf(exact.numerator) / exact.denominator
            for xi in POSITIONS:
                yield omega, duration, samples, number, xi, *self.at(xi, time, squares)


def near_critical(motion):
    """ω_c (1 ± 10⁻ᵏ), and the binary64 numbers next to ω_c."""
    critical = motion.beam.critical_speed(GAMMA)
    nearest = float(critical)
    offsets = [sign * mpf(10) ** -power for power in range(3, 16) for sign in (-1, 1)]
    around = [nextafter(nearest, 0.0), nearest, nextafter(nearest, inf)]
    return sorted({*around, *(float(critical * (1 + offset)) for offset in offsets)})


def critical_responses(motion):
    for omega in near_critical(motion):
        yield from motion.rows(omega, 1.0, 64, (1, 20, 40, 63))


def long_responses(motion):
    for omega in (0.0, 50.0, 121.8):
        for duration in (1.0, 1e3, 1e6, 1e9):
            yield from motion.rows(omega, duration, 1000, (1, 500, 998, 999))


def last_finite(motion, omega, duration, samples):
    """The last sample at which every displacement, and every velocity as well, is within binary64."""
    squares = motion.squares(omega)
    finite = [0, 0]
    for number in range(samples):
        time = mpf(duration) * number / samples
        moves = [motion.at(xi, time, squares) for xi in POSITIONS]
        for n, sizes in enumerate(([u for u, _ in moves], [w for move in moves for w in move])):
            if max(abs(size) for size in sizes) <= float_info.max:
                finite[n] = number
    return finite


def overflows(motion):
    critical = float(motion.beam.critical_speed(GAMMA))
    for omega in (critical * 1.000001, critical * 1.001, 130.0, 170.0, 900.0, 5000.0):
        rate = sqrt(-min(motion.squares(omega)))
        duration, samples = float(920 / rate), 4000
        last, last_with_velocity = last_finite(motion, omega, duration, samples)
        numbers = [samples // 4, samples // 2, last_with_velocity - 1, last_with_velocity, last]
        for row in motion.rows(omega, duration, samples, sorted(set(numbers))):
            yield *row[:3], last, last_with_velocity, *row[3:]


use_digits(150)
columns = ["omega", "duration", "samples", "j", "xi", "displacement", "velocity"]
few = Motion(5)
write_table("critical_responses.txt", """
Displacement (m) and velocity (m/s) of the paper's beam (length 1, diameter 0.037, density 7870, Young's modulus
2e11) at xi = x/l and at the exact time j duration/samples, after it caught a mass of 0.2 of its own at restitution 0
and 1 m/s, 5 modes before and after: around the critical angular velocity
""", columns, critical_responses(few))
write_table("long_responses.txt", """
As critical_responses.txt, with 46 modes, over long times: the phase of the last mode reaches 1e15
""", columns, long_responses(Motion(46)))
write_table("overflows.txt", """
As critical_responses.txt, beyond the critical angular velocity, up to the end of binary64's range: `last` is the last
sample at which all displacements are finite in binary64, `last_with_velocity` that for displacements and velocities
""", [*columns[:3], "last", "last_with_velocity", *columns[3:]], overflows(few))
