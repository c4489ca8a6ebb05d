"""Writes load_steps.txt, one mode under a load that is constant, linear or harmonic in time, and half_sine_responses.txt, the paper's beam
under a force of half a sine at its tip."""

from mpmath import cos, cosh, mp, mpc, mpf, pi, sin, sinh, sqrt

from beam import root, use_digits
from table import write_table

# one mode: y'' + cy' + βy = e^(iΩs) from rest, its state after a time h
MODES = [(100.0, 0.0), (100.0, 0.25), (1e6, 0.0), (1e6, 20.0), (25.0, 10.0), (25.0, 30.0), (0.0, 0.0), (0.0, 1.0), (-9.0, 0.5), (1e-8, 0.0)]
FREQUENCIES = (0.001, 0.5, 10.0, 10.000000001, 9.75, 1000.0, 999.0, 3e4)
TIMES = (1e-9, 0.0009765625, 0.125, 2.5)


def driven(square, damping, frequency, time):
    """State at `time` from rest: a particular motion less the free one that it starts from, with β moved by 10^-60, so that no two of
    their exponents are the same."""
    square, damping, time = mpf(square) + mpf(10) ** -60, mpf(damping), mpf(time)
    rate = mpc(0, frequency)
    steady = 1 / (rate**2 + damping * rate + square)
    split = sqrt(mpc(damping**2 / 4 - square))
    first, second = -damping / 2 + split, -damping / 2 - split
    # a e^(first t) + b e^(second t) begins as −steady does
    a = steady * (second - rate) / (first - second)
    b = -steady - a
    value = steady * mp.exp(rate * time) + a * mp.exp(first * time) + b * mp.exp(second * time)
    slope = steady * rate * mp.exp(rate * time) + a * first * mp.exp(first * time) + b * second * mp.exp(second * time)
    return value, slope


def write_steps():
    mp.dps = 200
    rows = []
    for square, damping in MODES:
        for frequency in FREQUENCIES:
            for time in TIMES:
                value, slope = driven(square, damping, frequency, time)
                rows.append((square, damping, frequency, time, value.real, value.imag, slope.real, slope.imag))
    write_table("load_steps.txt", """
y'' + c y' + beta_squared y = e^(i frequency s), y = y' = 0 at s = 0: y and y' at s = time
""", ["beta_squared", "c", "frequency", "time", "y_real", "y_imag", "v_real", "v_imag"], rows)  # fmt: skip


# The paper's beam, SI
COUNT, FORCE, DURATION, RECORD, SAMPLES = 40, 100.0, 1e-3, 0.05, 4096
SHOWN = (0, 1, 17, 40, 81, 82, 100, 1000, 2222, 4095)
PLACES = (0.0, 0.5, 1.0)


def shapes(alpha, xi):
    """Eq. 7 and its derivatives with respect to ξ: value, second, third."""
    a, x = alpha, alpha * xi
    sigma = (cos(a) + cosh(a)) / (sin(a) + sinh(a))
    return (
        cos(x) - cosh(x) - sigma * (sin(x) - sinh(x)),
        a**2 * (-cos(x) - cosh(x) - sigma * (-sin(x) - sinh(x))),
        a**3 * (sin(x) - sinh(x) - sigma * (-cos(x) - cosh(x))),
    )


def half_sine(beta, time):
    """q and q' of q'' + β²q = sin(πt/T) until T, then 0, by Duhamel's integral."""
    rate, end = pi / mpf(DURATION), mpf(DURATION)
    within = min(time, end)
    q = (sin(rate * within) - rate / beta * sin(beta * within)) / (beta**2 - rate**2)
    v = rate * (cos(rate * within) - cos(beta * within)) / (beta**2 - rate**2)
    later = time - within
    return q * cos(beta * later) + v / beta * sin(beta * later), -q * beta * sin(beta * later) + v * cos(beta * later)


def write_half_sine():
    use_digits(220)
    length, diameter, density, modulus = mpf(1.0), mpf(0.037), mpf(7870.0), mpf(2e11)
    bending, mass = modulus * pi * diameter**4 / 64, density * pi * diameter**2 / 4 * length
    rate = pi / mpf(DURATION)
    alphas = [root(k, 0.0) for k in range(1, COUNT + 1)]
    betas = [sqrt(bending / mass / length**3) * alpha**2 for alpha in alphas]
    rows = []
    for sample in SHOWN:
        time = mpf(RECORD) * sample / SAMPLES
        acting = [sin(rate * time), rate * cos(rate * time), -(rate**2) * sin(rate * time)]  # the force and its derivatives
        if time >= DURATION:
            acting = [mpf(0)] * 3
        for xi in map(mpf, PLACES):
            # what all modes do at once: a cantilever under a force at its tip, less that of the modes that are summed
            static = [length**3 * xi**2 * (3 - xi) / (6 * bending), length * (1 - xi), mpf(1)]
            moved = [mpf(0)] * 5
            for alpha, beta in zip(alphas, betas):
                tip = shapes(alpha, mpf(1))[0]
                value, second, third = shapes(alpha, xi)
                seen = [value, bending / length**2 * second, -bending / length**3 * third]
                static = [whole - part * tip / (mass * beta**2) for whole, part in zip(static, seen)]
                q, v = (tip / mass * part for part in half_sine(beta, time))
                a = tip / mass * acting[0] - beta**2 * q
                moved = [m + part for m, part in zip(moved, (q * value, v * value, a * value, q * seen[1], q * seen[2]))]
            at_once = [static[0] * part for part in acting] + [static[1] * acting[0], static[2] * acting[0]]
            rows.append((sample, float(xi), *(FORCE * (m + part) for m, part in zip(moved, at_once))))
    write_table("half_sine_responses.txt", f"""
The paper's beam, 1 m long, under a force of {FORCE} N sin(pi t/{DURATION} s) at its tip until {DURATION} s, by {COUNT} modes and what all
others do at once, at t = sample {RECORD} s/{SAMPLES}. SI
""", ["sample", "xi", "displacement", "velocity", "acceleration", "bending_moment", "shear_force"], rows)  # fmt: skip


write_steps()
write_half_sine()
