"""Simulated ring-downs as text: known lines in white noise, from a seed."""

import numpy as np

RATE, SAMPLES = 1000.0, 1024
FREQUENCY = np.array([40.3, 121.7, 260.4])  # Hz
DECAY = np.array([2.0, 4.0, 6.0])  # 1/s
AMPLITUDE = np.array([[1.0, 0.5, 0.2], [0.8, -0.6, 0.3]])  # by sensor and line
PHASE = np.array([0.4, -1.1, 2.2])
NOISE = 0.02


def ring_down(seed, samples=SAMPLES, noise=NOISE, times=None):
    """Times, and a row for each sensor."""
    dice = np.random.default_rng(seed)
    time = np.arange(samples) / RATE if times is None else times
    motion = np.exp(-np.outer(DECAY, time)) * np.cos(2 * np.pi * np.outer(FREQUENCY, time) + PHASE[:, None])
    return time, AMPLITUDE @ motion + noise * dice.standard_normal((2, time.size))


def as_text(time, values, head="time [s],mid [m/s2],tip [m/s2]"):
    """A table of comma-separated values."""
    rows = (",".join([f"{t:.9g}", *(f"{value:.7f}" for value in row)]) for t, row in zip(time, values.T))
    return "\n".join([head, *rows]) + "\n"


def text_of(seed, **options):
    """The table of a seed."""
    return as_text(*ring_down(seed, **options))
