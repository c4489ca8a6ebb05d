"""The kinds of records that are tried, and their seeded draws."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

SPACED = (0.0531, 0.1237, 0.2106)  # periods per step; a draw adds less than one bin. harminv finds nothing above 0.25
GAP = 40  # steps
JITTER = 0.4  # steps from the earliest to the latest, 20 % either way


@dataclass(frozen=True)
class Cell:
    """Records of one kind. Amplitudes are 1, or 0.2 … 1.2 at random where there are several sensors; phases are random."""

    words: str
    decibels: float  # of an amplitude of 1: A²/(2σ²) at the first sample
    decays: tuple[float, ...] = (0.0, 1.0, 3.0)  # e-folds in the whole record
    near: float = 0.0  # distance of two undamped lines, bins; 0: `decays` says which lines there are
    samples: int = 512
    sensors: int = 1
    colour: float = 0.0  # φ of AR(1) noise
    kind: str = ""  # of noise that is none of AR(1): pink, or behind a filter
    share: float = 0.0  # of the noise's variance, that all sensors have in common
    bits: int = 0  # the record is rounded to so many over ±2; 0: not rounded
    uneven: bool = False
    draws: int = 10_000
    few: int = 200  # draws of tools that take long


@dataclass(frozen=True)
class Draw:
    """One record and the truth."""

    times: np.ndarray  # steps, (samples)
    values: np.ndarray  # (samples, sensors)
    frequencies: np.ndarray  # periods per step, ascending
    decays: np.ndarray  # per step
    bounds: np.ndarray  # Cramér–Rao standard deviations of frequencies, and of decays: (2, lines)
    sensible: bool  # the two lines of a pair can be told apart


CELLS = (
    *(Cell(f"three lines, {level} dB", level) for level in (60, 40, 20, 10, 0)),
    *(Cell(f"two lines half a bin apart, {level} dB", level, near=0.5) for level in (30, 20)),
    Cell("AR(1) noise, φ = 0.9, 30 dB", 30, colour=0.9),
    Cell("AR(1) noise and 12 bits, 30 dB", 30, colour=0.9, bits=12),
    *(Cell(f"one line, gone after 1/{2 * fold} of the record, 40 dB", 40, decays=(6.0 * fold,)) for fold in (1, 4, 16)),
    Cell("64 sensors, 0 dB", 0, sensors=64, draws=1000, few=20),
    Cell("8 sensors that share 0.8 of the noise, 20 dB", 20, sensors=8, share=0.8, few=20),
    Cell("uneven times with two gaps, 30 dB", 30, uneven=True),
)
NOISE = (
    Cell("white noise", 0, ()),
    Cell("white noise at uneven times with two gaps", 0, (), uneven=True),
    Cell("AR(1) noise, φ = 0.9", 0, (), colour=0.9),
    Cell("1/f noise", 0, (), kind="pink"),
    Cell("noise behind a low-pass filter of 101 coefficients", 0, (), kind="low pass"),
    Cell("noise behind a band-pass filter of 101 coefficients", 0, (), kind="band pass"),
    Cell("noise behind Hann's window of 31 samples", 0, (), kind="hann"),
    Cell("noise behind a Butterworth filter of order 4, there and back", 0, (), kind="there and back", draws=2000),
    Cell("8 sensors, white noise", 0, (), sensors=8),
    Cell("8 sensors that share 0.3 of white noise", 0, (), sensors=8, share=0.3),
    Cell("2 sensors that share 0.5 of white noise", 0, (), sensors=2, share=0.5),
)
SMALL_CELLS = (CELLS[2], CELLS[-1], NOISE[3], NOISE[-1])


def lines_of(cell: Cell) -> int:
    """How many lines there are."""
    return 2 if cell.near else len(cell.decays)


def draw(cell: Cell, number: int) -> Draw:
    """The draw of that number, the same for every tool."""
    random = np.random.default_rng([number, *cell.words.encode()])
    times = uneven_times(cell, random) if cell.uneven else np.arange(cell.samples, dtype=float)
    frequencies, decays = truth(cell, random)
    shape = (len(decays), cell.sensors)
    amplitudes = 0.2 + random.random(shape) if cell.sensors > 1 else np.ones(shape)
    turned = amplitudes * np.exp(2j * np.pi * random.random(shape))
    waves = np.exp(np.outer(times, -decays + 2j * np.pi * frequencies))
    sigma = np.sqrt(0.5) * 10 ** (-cell.decibels / 20)
    values = (waves @ turned).real + sigma * noise(cell, random)
    if cell.bits:
        step = 4.0 / 2**cell.bits
        values = step * np.round(values / step)
    if not cell.decays:
        return Draw(times, values, frequencies, decays, np.zeros((2, 0)), True)
    errors = bounds(times, waves, turned @ separation(cell), sigma, cell.colour)
    return Draw(times, values, frequencies, decays, errors[:2], bool(not cell.near or errors[2, 0] <= cell.near / cell.samples / 6))


def truth(cell: Cell, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies and decays."""
    if cell.near:
        first = SPACED[1] + random.random() / cell.samples
        return np.array([first, first + cell.near / cell.samples]), np.zeros(2)
    places = np.array(SPACED) if len(cell.decays) == len(SPACED) else np.array(SPACED[1:2])[: len(cell.decays)]
    return places + random.random(len(places)) / cell.samples, np.array(cell.decays) / cell.samples


def uneven_times(cell: Cell, random: np.random.Generator) -> np.ndarray:
    """Jittered times with gaps after a third and a half of the samples."""
    steps = np.arange(cell.samples)
    gaps = GAP * ((steps >= cell.samples // 3).astype(float) + (steps >= cell.samples // 2))
    times = steps + gaps + JITTER * (random.random(cell.samples) - 0.5)
    return times - times[0]


def noise(cell: Cell, random: np.random.Generator) -> np.ndarray:
    """Of standard deviation 1."""
    if cell.kind:
        return shaped(cell, random)
    white = random.standard_normal((cell.samples, cell.sensors))
    if cell.share:
        white = np.sqrt(1 - cell.share) * white + np.sqrt(cell.share) * random.standard_normal((cell.samples, 1))
    return coloured(white, cell.colour)


def coloured(white: np.ndarray, phi: float) -> np.ndarray:
    """AR(1) noise of deviation 1 from white noise."""
    scale = np.sqrt(1 - phi**2)
    return lfilter([scale], [1, -phi], np.vstack([white[:1] / scale, white[1:]]), axis=0)


def shaped(cell: Cell, random: np.random.Generator) -> np.ndarray:
    """Noise whose power falls as 1/f, or behind a filter that lets nothing through beyond its band."""
    if cell.kind == "pink":
        return tenth(cell, random, lambda frequency: 1 / np.sqrt(frequency))
    if cell.kind == "there and back":
        return tenth(cell, random, lambda frequency: 1 / (1 + (np.tan(np.pi * frequency) / np.tan(0.1 * np.pi)) ** 8))
    steps = np.arange(-50, 51)
    taps = {
        "low pass": np.sinc(0.4 * steps) * np.hamming(101),
        "band pass": np.sinc(0.2 * steps) * np.hamming(101) * np.cos(0.4 * np.pi * steps),
        "hann": np.sin(np.pi * np.arange(1, 32) / 32) ** 2,
    }[cell.kind]
    white = random.standard_normal((cell.samples + len(taps) - 1, cell.sensors))
    return np.column_stack([np.convolve(column, taps / np.linalg.norm(taps), "valid") for column in white.T])


def tenth(cell: Cell, random: np.random.Generator, gain: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The first tenth of noise with a gain over frequencies, in periods per step, and without its mean."""
    spectrum = np.fft.rfft(random.standard_normal((10 * cell.samples, cell.sensors)), axis=0)
    spectrum[0] = 0
    spectrum[1:] *= gain(np.arange(1, len(spectrum)) / (10 * cell.samples))[:, None]
    values = np.fft.irfft(spectrum, axis=0)[: cell.samples]
    return values / values.std()


def separation(cell: Cell) -> np.ndarray:
    """What makes sensors that share noise independent, times amplitudes from the left: (sensors, sensors)."""
    covariance = np.full((cell.sensors, cell.sensors), cell.share) + (1 - cell.share) * np.eye(cell.sensors)
    return np.linalg.inv(np.linalg.cholesky(covariance)).T


def bounds(times: np.ndarray, waves: np.ndarray, turned: np.ndarray, sigma: float, colour: float) -> np.ndarray:
    """Cramér–Rao deviations of frequencies and decays, and of the distance of the first two frequencies: (3, lines).

    Amplitudes and phases at each sensor, an offset and a slope are unknown too; what they can explain is taken off the slopes.
    """
    known = np.column_stack([waves.real, waves.imag, np.ones_like(times), times / times[-1]])
    basis = np.linalg.qr(whitened(known, colour))[0]
    lines = waves.shape[1]
    information = np.zeros((2 * lines, 2 * lines))
    for amplitude in turned.T:
        parts = times[:, None] * waves * amplitude
        slopes = whitened(np.column_stack([-2 * np.pi * parts.imag, -parts.real]), colour)
        slopes -= basis @ (basis.T @ slopes)
        information += slopes.T @ slopes / sigma**2
    scale = 1 / np.sqrt(np.diag(information))
    covariance = np.linalg.inv(information * np.outer(scale, scale)) * np.outer(scale, scale)
    deviations = np.sqrt(np.diag(covariance)).reshape(2, lines)
    distance = covariance[0, 0] + covariance[1, 1] - 2 * covariance[0, 1] if lines > 1 else 0.0
    return np.vstack([deviations, np.full(lines, np.sqrt(distance))])


def whitened(columns: np.ndarray, colour: float) -> np.ndarray:
    """What makes AR(1) noise white, done to the columns."""
    if not colour:
        return columns
    rest = (columns[1:] - colour * columns[:-1]) / np.sqrt(1 - colour**2)
    return np.vstack([columns[:1], rest])


def nearest_pairs(distance: np.ndarray) -> Iterator[tuple[int, int]]:
    """Places of drawn lines and of found ones that belong together, the nearest first; infinite distances never do."""
    distance = distance.copy()
    while np.isfinite(distance).any():
        line, place = np.unravel_index(np.argmin(distance), distance.shape)
        yield line, place
        distance[line], distance[:, place] = np.inf, np.inf
