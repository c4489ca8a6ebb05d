"""Write tap_1.csv and tap_2.csv: a hammer taps an aluminium strip in a vice, and two accelerometers record its ring-down.

    python3 input/tutorial/make_taps.py

The strip is 0.5 m long, 40 mm wide and 8 mm thick (70 GPa, 2700 kg/m³). The vice holds it against deflection and turns by 1 rad
under 2000 N m. Its five modes below half the sampling rate move under a bell of 0.25 ms standard deviation at 0.8 of the length, whose
spectrum ends there as that of a recorder with a filter does; all have 0.4 % of critical damping. Sensors at 0.6 and 1.0 have white noise of 0.5 m/s², the hammer one of 0.1 N. The files differ
in the seed and in how hard the hammer hits.
"""

from pathlib import Path

import numpy as np

LENGTH, WIDTH, HEIGHT, DENSITY, MODULUS = 0.5, 0.04, 0.008, 2700.0, 70e9  # m, m, m, kg/m3, Pa
CLAMP, DAMPING, MODES = 2000.0, 0.004, 5  # N m/rad, of critical
HAMMER, SENSORS = 0.8, np.array([0.6, 1.0])  # x/l
RATE, SAMPLES, BLOW, WIDTH_OF_BLOW = 4000.0, 3200, 0.051, 0.25e-3  # Hz, s, s
NOISE, FORCE_NOISE = 0.5, 0.1  # m/s2, N

STIFFNESS = MODULUS * WIDTH * HEIGHT**3 / 12
MASS = DENSITY * WIDTH * HEIGHT * LENGTH


def shape(alpha, place, derivative=0):
    """A row for each of cos − cosh, sin, sinh of αξ or a derivative of theirs by αξ: what is left of a shape with v(0) = 0."""
    x = alpha * np.asarray(place, float)
    turned = [np.cos(x + derivative * np.pi / 2), np.sin(x + derivative * np.pi / 2)]
    grown = [np.cosh(x), np.sinh(x)] if derivative % 2 == 0 else [np.sinh(x), np.cosh(x)]
    return np.array([turned[0] - grown[0], turned[1], grown[1]])


def conditions(alpha):
    """Rows: EI v'' = k v' at the root, no moment and no shear force at the tip."""
    spring = CLAMP * LENGTH / STIFFNESS
    root = alpha * shape(alpha, 0.0, 2) - spring * shape(alpha, 0.0, 1)
    return np.array([root, shape(alpha, 1.0, 2) / np.cosh(alpha), shape(alpha, 1.0, 3) / np.cosh(alpha)])


def wave_numbers():
    """The lowest roots α of the frequency equation."""
    grid = np.linspace(0.5, 20.0, 4000)
    sign = [np.linalg.det(conditions(alpha)) for alpha in grid]
    roots = []
    for low, high, first in [(a, b, s) for a, b, s, t in zip(grid, grid[1:], sign, sign[1:]) if s * t < 0][:MODES]:
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if np.linalg.det(conditions(middle)) * first > 0 else (low, middle)
        roots.append(low)
    return np.array(roots)


def modes():
    """Angular frequencies (rad/s), and by mode the shape at hammer and sensors over the root of the modal mass."""
    alphas = wave_numbers()
    point, weight = np.polynomial.legendre.leggauss(60)
    shapes = []
    for alpha in alphas:
        parts = np.linalg.svd(conditions(alpha))[2][-1]
        modal_mass = MASS * ((parts @ shape(alpha, (point + 1) / 2)) ** 2) @ weight / 2
        shapes.append(parts @ shape(alpha, np.append(HAMMER, SENSORS)) / np.sqrt(modal_mass))
    return np.sqrt(STIFFNESS * LENGTH / MASS) * (alphas / LENGTH) ** 2, np.array(shapes)


def force(time, peak):
    """The hammer's bell, N."""
    return peak * np.exp(-0.5 * ((time - BLOW) / WIDTH_OF_BLOW) ** 2)


def accelerations(time, peak):
    """Acceleration in m/s2 by sensor and time: of each mode f + Im(p² I)/β'' with the pole p and I(t) = ∫f(s) e^(p(t−s)) ds up to t."""
    frequency, shapes = modes()
    pole = frequency * (-DAMPING + 1j * np.sqrt(1 - DAMPING**2))
    reach = 8 * WIDTH_OF_BLOW  # beyond which the bell is below 1e-13
    whole = peak * WIDTH_OF_BLOW * np.sqrt(2 * np.pi) * np.exp((pole * WIDTH_OF_BLOW) ** 2 / 2)
    history = np.where(time > BLOW, whole[:, None] * np.exp(pole[:, None] * np.maximum(time - BLOW, 0.0)), 0.0)
    point, weight = np.polynomial.legendre.leggauss(200)
    for i in np.flatnonzero(np.abs(time - BLOW) <= reach):  # during the blow
        half = (time[i] - BLOW + reach) / 2
        passed = half * (1 - point)  # t − s
        history[:, i] = half * np.exp(pole[:, None] * passed) @ (weight * force(time[i] - passed, peak))
    moved = force(time, peak) + (pole[:, None] ** 2 * history).imag / pole.imag[:, None]
    return (shapes[:, 1:] * shapes[:, :1]).T @ moved


def main():
    """Write both files beside this one."""
    time = np.arange(SAMPLES) / RATE
    for number, peak in ((1, 42.0), (2, 55.0)):
        dice = np.random.default_rng(40 + number)
        seen = accelerations(time, peak) + NOISE * dice.standard_normal((SENSORS.size, SAMPLES))
        hit = force(time, peak) + FORCE_NOISE * dice.standard_normal(SAMPLES)
        rows = [f"{t:.5f},{f:.2f},{a:.2f},{b:.2f}\n" for t, f, a, b in zip(time, hit, *seen)]
        head = "# simulated by input/tutorial/make_taps.py\nTime [s],hammer [N],a06 [m/s2],tip [m/s2]\n"
        Path(__file__).with_name(f"tap_{number}.csv").write_text(head + "".join(rows))


if __name__ == "__main__":
    main()
