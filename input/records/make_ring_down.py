"""Write ring_down_1.csv and ring_down_2.csv: what two accelerometers see of a cantilever that was struck twice.

    python3 input/records/make_ring_down.py

An aluminium beam, 0.6 m long and 6 mm thick, is struck near its tip with a hammer. Its clamped-free modes ring down with
0.3 to 0.8 % of critical damping. Both sensors have white noise of 0.05 m/s² and 12 bits over ±200 m/s². Only the seed and
where the hammer hits differ between the two files, so that they are repeats of one measurement.
"""

from pathlib import Path

import numpy as np

SEED = 18
LENGTH, THICKNESS, DENSITY, MODULUS = 0.6, 0.006, 2700.0, 70e9  # m, m, kg/m3, Pa
ALPHA = np.array([1.875104068711961, 4.694091132974174, 7.854757438237613, 10.99554073487547])
DAMPING = np.array([0.008, 0.004, 0.003, 0.003])  # of critical
RATE, SAMPLES = 2000.0, 1500  # Hz
SENSORS = np.array([0.5, 1.0])  # x/l
IMPULSE, NOISE, STEP = 0.02, 0.05, 400.0 / 4096  # m/s of a mode, m/s2, m/s2


def shapes(place):
    """Clamped-free shapes, by mode and place; 2 (−1)^(k+1) at the tip."""
    a, x = ALPHA[:, None], np.atleast_1d(place)[None, :] * ALPHA[:, None]
    ratio = (np.cosh(a) + np.cos(a)) / (np.sinh(a) + np.sin(a))
    return np.cosh(x) - np.cos(x) - ratio * (np.sinh(x) - np.sin(x))


def frequencies():
    """Undamped angular frequencies, rad/s."""
    return np.sqrt(MODULUS * THICKNESS**2 / 12 / DENSITY) * (ALPHA / LENGTH) ** 2


def accelerations(time, struck):
    """Acceleration in m/s2, by sensor and time, after a blow at `struck`."""
    beta = frequencies()
    pole = -DAMPING * beta + 1j * beta * np.sqrt(1 - DAMPING**2)
    motion = (pole**2 / pole.imag)[:, None] * np.exp(pole[:, None] * time)  # of a unit velocity: Im e^(pt)/β'', twice derived
    return (shapes(SENSORS) * IMPULSE * shapes(struck)).T @ motion.imag


def main():
    """Write both files beside this one."""
    dice = np.random.default_rng(SEED)
    time = np.arange(SAMPLES) / RATE
    for number, struck in ((1, 0.93), (2, 0.87)):
        seen = accelerations(time, struck) + NOISE * dice.standard_normal((SENSORS.size, SAMPLES))
        seen = STEP * np.round(seen / STEP)
        rows = [f"{t:.4f},{one:.3f},{two:.3f}\n" for t, one, two in zip(time, *seen)]
        text = "# a simulated ring-down: input/records/make_ring_down.py\nTime [s],mid [m/s2],tip [m/s2]\n" + "".join(rows)
        Path(__file__).with_name(f"ring_down_{number}.csv").write_text(text)


if __name__ == "__main__":
    main()
