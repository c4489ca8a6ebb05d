"""Seeded records of struck beams, and of what else people record, with the truth and its Cramér–Rao bounds."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter
from scipy.stats import chi2

from .beams import Beam, log_uniform, random_beam
from .cells import coloured, whitened

FALSE_ALARM = 0.01
SURE = 3.0  # times the gain that noise alone reaches: such a line has to be found
LIFE = 3.0  # decay times, for which a line's drift is told


@dataclass
class Draw:
    """One record and the truth, lines in ascending order."""

    times: np.ndarray  # s, (samples)
    values: np.ndarray  # (samples, sensors)
    frequencies: np.ndarray  # Hz, (lines); of a drifting line at the first sample that it moves
    decays: np.ndarray  # 1/s
    ends: np.ndarray  # Hz; frequencies at the end of the lines' life
    steady: np.ndarray = field(default_factory=lambda: np.zeros((2, 0)))  # frequency and decay without drift that are nearest
    bounds: np.ndarray = field(default_factory=lambda: np.zeros((2, 0)))  # of frequencies (Hz) and decays (1/s): (2, lines)
    gains: np.ndarray = field(default_factory=lambda: np.zeros(0))  # fall of −2 ln L by each line that the others cannot explain
    least: float = 0.0  # such a fall that noise alone reaches somewhere with the probability FALSE_ALARM

    def needed(self) -> np.ndarray:
        """Which lines have to be found."""
        return self.gains > SURE * self.least

    def resolution(self) -> float:
        """Hz."""
        return 1 / (self.times[-1] - self.times[0])


@dataclass(frozen=True)
class Struck:
    """A kind of ring-down of random cantilevers."""

    words: str
    quiet: float = 0.0  # part of the record before the blow, at most; 0: the record begins anywhere behind it
    blows: int = 1  # at most
    clipped: float = 0.0  # part of the samples of a sensor
    missing: float = 0.0  # part of the rows
    drift: float = 0.0  # of a frequency, at most
    tone: bool = False  # a fan's, beside
    ratios: tuple[float, float] = (0.001, 0.03)
    decibels: tuple[float, float] = (20, 60)
    sensors: tuple[int, int] = (2, 6)
    colour: float = 0.0  # φ of AR(1) noise, at most

    def draw(self, number: int) -> Draw:
        """The draw of that number."""
        random = np.random.default_rng([number, *self.words.encode()])
        rate, duration = log_uniform(random, 2000, 10000), log_uniform(random, 1, 8)
        beam = random_beam(random, rate, duration, self.ratios)
        lines = Lines(beam, np.arange(int(rate * duration)) / rate, random, self)
        sigma = log_uniform(random, 0.7, 1.4, lines.sensors) * 10 ** (-random.uniform(*self.decibels) / 20) / np.sqrt(2)
        sigma *= np.sqrt((np.abs(lines.amplitudes[0]) ** 2).mean(axis=1)).max()
        phi = random.uniform(0, self.colour)
        values = lines.samples() + sigma * coloured(random.standard_normal((len(lines.times), lines.sensors)), phi)
        valid = np.ones(values.shape, bool)
        if self.clipped:
            limit = np.quantile(np.abs(values), 1 - self.clipped, axis=0)
            valid, values = np.abs(values) < limit, np.clip(values, -limit, limit)
        if self.missing:
            valid &= present(random, len(values), self.missing)[:, None]
        kept = valid.any(axis=1) if self.missing else np.ones(len(values), bool)
        drawn = Draw(lines.times[kept], values[kept], lines.starts, lines.decays, lines.ends, lines.steady())
        judge(drawn, lines, sigma, phi, valid)
        return drawn


class Lines:
    """The exponentials of a record: for each stretch between blows, one wave for each line."""

    def __init__(self, beam: Beam, times: np.ndarray, random: np.random.Generator, kind: Struck) -> None:
        self.times, self.sensors = times, int(random.integers(kind.sensors[0], kind.sensors[1] + 1))
        blows = random.integers(2, kind.blows + 1) if kind.blows > 1 else 1
        ages = blow_times(random, times[-1], kind.quiet, blows)
        poles, self.drift, self.rate = beam.poles(), np.zeros(len(beam.frequencies)), np.ones(len(beam.frequencies))
        if kind.drift:
            self.drift = random.choice([-1, 1], len(poles)) * log_uniform(random, kind.drift / 40, kind.drift, len(poles))
            by_amplitude = random.random(len(poles)) < 0.8
            self.rate = np.where(by_amplitude, -2 * poles.real, 0.5 / times[-1])
        self.poles = poles
        struck = blow_amplitudes(beam, random, self.sensors, blows)
        self.edges = [int(np.ceil(max(0.0, age) / times[1] - 1e-9)) for age in ages] + [len(times)]
        first = [max(0.0, -ages[0])] + [0.0] * (blows - 1)  # time since the stretch's own blow at its first sample
        self.origins = [times[edge] - since for edge, since in zip(self.edges, first)]
        if ages[0] > 0:
            self.origins[0] = ages[0]
        self.origins[1:] = ages[1:]
        self.amplitudes = [struck[0]]
        for blow in range(1, blows):  # the old motion goes on in the new one
            self.amplitudes.append(self.amplitudes[-1] * np.exp(poles * (ages[blow] - ages[blow - 1]))[:, None] + struck[blow])
        life = np.minimum(LIFE / -poles.real, times[-1] - times[self.edges[0]])
        base, since = poles.imag / (2 * np.pi), first[0]
        self.starts = base * (1 + self.drift * np.exp(-self.rate * since))
        self.ends = base * (1 + self.drift * np.exp(-self.rate * (since + life)))
        self.decays = -poles.real
        if kind.tone:
            self.add_tone(random)

    def add_tone(self, random: np.random.Generator) -> None:
        """A steady line away from the others, which is there before the blow too."""
        low, high = np.log(self.starts[[0, -1]])
        while True:
            tone = np.exp(random.uniform(low, high))
            if np.abs(np.log(tone / self.starts)).min() > 0.05:
                break
        size = np.abs(self.amplitudes[0]).max() * 10 ** (-random.uniform(0, 30) / 20)
        own = size * np.exp(2j * np.pi * random.random(self.sensors)) * random.uniform(0.3, 1, self.sensors)
        self.tone, self.tone_amplitude = tone, own

    def wave(self, mode: int, blow: int) -> tuple[slice, np.ndarray, np.ndarray]:
        """Where a stretch is, the time since its origin, and a line's exponential there."""
        place = slice(self.edges[blow], self.edges[blow + 1])
        since = self.times[place] - self.origins[blow]
        bent = 1j * self.poles[mode].imag * self.drift[mode] * -np.expm1(-self.rate[mode] * since) / self.rate[mode]
        return place, since, np.exp(self.poles[mode] * since + bent)

    def steady(self) -> np.ndarray:
        """Frequencies and decays of the exponentials nearest to the lines, by Gauss and Newton: (2, lines)."""
        nearest = np.array([self.starts + self.ends, 2 * self.decays]) / 2
        for mode in range(len(self.poles)) if self.drift.any() else ():
            _, since, wave = self.wave(mode, 0)
            if not wave[0]:  # it was gone before the record began
                continue
            z = -self.decays[mode] + 2j * np.pi * np.average(
                [self.starts[mode], self.ends[mode]], weights=[0.3, 0.7]
            )
            for _ in range(30):
                own = np.exp(z * since)
                columns = np.column_stack([own, since * own])
                amplitude, slope = np.linalg.lstsq(columns, wave, rcond=None)[0]
                step = slope / amplitude
                z += step * min(1, 0.5 * max(-z.real, 1 / since[-1]) / abs(step))
            nearest[:, mode] = z.imag / (2 * np.pi), -z.real
        return nearest

    def samples(self) -> np.ndarray:
        """Without noise."""
        values = np.zeros((len(self.times), self.sensors))
        for blow, amplitudes in enumerate(self.amplitudes):
            for mode, amplitude in enumerate(amplitudes):
                place, _, wave = self.wave(mode, blow)
                values[place] += np.outer(wave, amplitude).real
        if hasattr(self, "tone"):
            values += np.outer(np.exp(2j * np.pi * self.tone * self.times), self.tone_amplitude).real
        return values

    def columns(self) -> np.ndarray:
        """Real columns: parts of each wave, the same times the time, by lines and blows (4 each); then of the tone, offset, slope."""
        count = len(self.times)
        columns = []
        for mode in range(len(self.poles)):
            for blow in range(len(self.amplitudes)):
                place, since, wave = self.wave(mode, blow)
                part = np.zeros((count, 4))
                part[place] = np.column_stack([wave.real, wave.imag, since * wave.real, since * wave.imag])
                columns.append(part)
        if hasattr(self, "tone"):
            wave = np.exp(2j * np.pi * self.tone * self.times)
            columns.append(np.column_stack([wave.real, wave.imag, self.times * wave.real, self.times * wave.imag]))
        columns.append(np.column_stack([np.ones(count), np.linspace(-1, 1, count)]))
        return np.hstack(columns)

    def coefficients(self) -> list[list[np.ndarray]]:
        """Amplitudes by lines (the tone last) and blows, each (sensors)."""
        own = [[amplitudes[mode] for amplitudes in self.amplitudes] for mode in range(len(self.poles))]
        return own + ([[self.tone_amplitude]] if hasattr(self, "tone") else [])


def blow_times(random: np.random.Generator, duration: float, quiet: float, blows: int) -> np.ndarray:
    """When the beam is struck; before 0 where the record begins behind the blow."""
    first = random.uniform(0, quiet) * duration if quiet else -random.uniform(0, 0.3) * duration * random.integers(2)
    later = (np.arange(1, blows) + random.uniform(-0.3, 0.3, blows - 1)) / blows
    return np.append(first, max(first, 0) + (duration - max(first, 0)) * later)


def blow_amplitudes(beam: Beam, random: np.random.Generator, sensors: int, blows: int) -> list[np.ndarray]:
    """Complex amplitudes at each blow's instant of modes at sensors, each (modes, sensors)."""
    places = np.linspace(1, 0.25, sensors) - random.uniform(0, 0.08, sensors)
    seen = np.array([beam.at(place) for place in places]).T
    poles = beam.poles()
    power = random.integers(3)  # displacement, velocity or acceleration
    found = []
    for _ in range(blows):
        x = poles.imag * random.uniform(0.0001, 0.001) / np.pi  # the blow is half a sine in time
        force = np.abs(np.cos(np.pi * x / 2) / np.where(np.abs(1 - x * x) < 1e-6, 1e-6, 1 - x * x))
        hit = random.uniform(0.4, 1) * np.maximum(force, 0.02) * beam.at(random.uniform(0.3, 1))
        found.append((hit * poles**power / (1j * poles.imag))[:, None] * seen)
    return found


def present(random: np.random.Generator, samples: int, part: float) -> np.ndarray:
    """Rows that are there: half of the others are missing one by one, half in short gaps."""
    kept = np.ones(samples, bool)
    kept[random.choice(samples, int(samples * part / 2), replace=False)] = False
    for first in random.choice(samples, max(1, int(samples * part / 40))):
        kept[first : first + 20] = False
    kept[[0, -1]] = True
    return kept


def judge(drawn: Draw, lines: Lines, sigma: np.ndarray, phi: float, valid: np.ndarray) -> None:
    """Bounds of frequencies and decays, amplitudes, an offset and a slope of each sensor being unknown; what each line explains."""
    columns, parts = lines.columns(), lines.coefficients()
    count = len(parts)
    place = np.cumsum([0, *(4 * len(blows) for blows in parts)])
    amplitude = np.concatenate([np.arange(columns.shape[1] - 2) % 4 < 2, [True, True]])
    information, gains, gram, before = np.zeros((2 * count, 2 * count)), np.zeros(count), None, None
    for sensor, level in enumerate(sigma):
        if before is None or (valid[:, sensor] != before).any():
            before = valid[:, sensor]
            white = whitened(columns * before[:, None], phi)
            scale = 1 / np.maximum(np.linalg.norm(white, axis=0), 1e-300)
            gram = (white * scale).T @ (white * scale)
        slopes = np.zeros((len(scale), 2 * count))
        for line, blows in enumerate(parts):
            own = np.zeros(len(scale))
            for blow, c in enumerate(blows):
                at, a = place[line] + 4 * blow, c[sensor] / level
                own[at : at + 2] = np.array([a.real, -a.imag]) / scale[at : at + 2]
                slopes[at + 2 : at + 4, 2 * line] = np.array([a.real, -a.imag]) / scale[at + 2 : at + 4]
                slopes[at + 2 : at + 4, 2 * line + 1] = np.array([-a.imag, -a.real]) / scale[at + 2 : at + 4]
            others = np.ones(len(scale), bool)
            others[place[line] : place[line + 1]] = False
            gains[line] += quadratic(gram, own[:, None], others)[0, 0]
        information += quadratic(gram, slopes, amplitude)
    size = 1 / np.sqrt(np.maximum(np.diag(information), 1e-300))
    covariance = np.linalg.pinv(information * np.outer(size, size)) * np.outer(size, size)
    deviations = np.sqrt(np.diag(covariance))
    drawn.bounds = np.vstack([deviations[1::2] / (2 * np.pi), deviations[0::2]])
    drawn.gains = gains
    drawn.least = float(chi2.isf(FALSE_ALARM / len(valid), 2 * len(sigma) * len(lines.amplitudes)))
    if hasattr(lines, "tone"):
        drawn.frequencies, drawn.ends = np.append(drawn.frequencies, lines.tone), np.append(drawn.ends, lines.tone)
        drawn.decays = np.append(drawn.decays, 0.0)
        drawn.steady = np.column_stack([drawn.steady, [lines.tone, 0.0]])
    order = np.argsort(drawn.frequencies)
    drawn.frequencies, drawn.decays, drawn.ends = drawn.frequencies[order], drawn.decays[order], drawn.ends[order]
    drawn.steady = drawn.steady[:, order]
    drawn.bounds, drawn.gains = drawn.bounds[:, order], drawn.gains[order]


def quadratic(gram: np.ndarray, vectors: np.ndarray, taken: np.ndarray) -> np.ndarray:
    """Scalar products of sums of columns, without what the columns `taken` explain of them."""
    part = np.linalg.pinv(gram[np.ix_(taken, taken)], rcond=1e-13, hermitian=True)
    cross = gram[taken] @ vectors
    return vectors.T @ gram @ vectors - cross.T @ part @ cross


@dataclass(frozen=True)
class Shaken:
    """The same beams under forces that never end: no free decay is in such a record."""

    words: str
    sensors: tuple[int, int] = (1, 6)

    def draw(self, number: int) -> Draw:
        """White forces at three places, exact at the samples but for their history between these."""
        random = np.random.default_rng([number, *self.words.encode()])
        rate, duration = log_uniform(random, 2000, 10000), log_uniform(random, 1, 8)
        beam = random_beam(random, rate, duration, (0.001, 0.03))
        samples, before = int(rate * duration), int(rate * 2)
        sensors = int(random.integers(self.sensors[0], self.sensors[1] + 1))
        seen = np.array([beam.at(place) for place in np.linspace(1, 0.25, sensors) - random.uniform(0, 0.08, sensors)]).T
        forces = random.standard_normal((before + samples, 3)) @ np.array([beam.at(random.uniform(0.2, 1)) for _ in range(3)])
        power = random.integers(3)
        values = np.zeros((samples, sensors))
        for mode, z in enumerate(beam.poles() / rate):
            c = z**power / (1j * z.imag)
            steps = np.exp(z)
            history = lfilter([c], [1, -steps], forces[:, mode].astype(complex)).real
            values += np.outer(history[before:], seen[mode])
        values += 10 ** (-random.uniform(20, 60) / 20) * values.std() * random.standard_normal(values.shape)
        none = np.zeros(0)
        return Draw(np.arange(samples) / rate, values, none, none, none)
