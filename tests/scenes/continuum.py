"""The paper's beam and mass with very many modes, by a route of its own: what a run is compared with.

The first modes have the roots of the power series of Eq. 19 in λ = α⁴, in 60 decimal digits; all others the form that is left
where sech α is nothing, in numpy's extended precision. A release is the overlap of each mode with each, by the identity of two
shapes of v'''' = α⁴v, and moments of the modes far above. Lengths in l, times in l²/h, masses in m_i, velocities in the speed
of approach.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from decimal import Decimal, getcontext
from math import factorial

import numpy as np

getcontext().prec = 60
LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
LOW = 14  # modes from the power series; of the next e^(−α) is 1e-18
TERMS = 90  # of the series: at α = 42 the last is 1e-150
SERIES = [(Decimal((-4) ** m) / factorial(4 * m), Decimal(4 * (-4) ** m) / factorial(4 * m + 3)) for m in range(TERMS)]
BATCH = 2048  # modes held at a time
ROWS = 32  # of a matrix of overlaps held at a time
NEIGHBOURS = 20  # modes to each side whose overlap is taken from α and not from α⁴
MOMENTS = 8  # of modes more than twice above, in powers of 1/16
FARTHEST = 400_000  # mode of beam and mass that the moments count


@dataclass
class Motion:
    """What is simulated: the numbers of a scene without units."""

    gamma: float
    omega: Decimal = Decimal(0)  # in plane
    restitution: float = 0.0
    mass: Decimal = Decimal(0)  # c = mass + 2·ratio·λ^½ + stiffness·λ
    ratio: float = 0.0
    stiffness: Decimal = Decimal(0)
    release: Decimal | None = None

    @property
    def damped(self):
        return self.mass > 0 or self.ratio > 0 or self.stiffness > 0


def long(value):
    """A decimal number in extended precision."""
    return LONG(str(value))


class Modes:
    """The first `count` modes of the beam with a mass γ at its tip; 0: alone."""

    def __init__(self, motion, gamma, count):
        squares = [low_root(k, Decimal(gamma)) for k in range(1, min(LOW, count) + 1)]
        low = np.array([long(square.sqrt().sqrt()) for square in squares])
        self.gamma, self.count, self.number = gamma, count, np.arange(1, count + 1)
        self.alpha = np.concatenate([low, far_roots(self.number[len(low) :].astype(LONG), gamma)])
        self.tip, self.mass = tips_and_masses(self.alpha, gamma)
        self.find_rates(motion, squares)

    def find_rates(self, motion, squares):
        """β², c, β² − c²/4 and the slower exponent, the first from all digits of λ."""
        omega, mass, stiffness = long(motion.omega), long(motion.mass), long(motion.stiffness)
        square = self.alpha**2
        self.beta_squared = (square - omega) * (square + omega)
        self.damping = mass + 2 * LONG(motion.ratio) * square + stiffness * square**2
        self.turning = self.beta_squared - self.damping**2 / 4
        for i, exact in enumerate(squares):
            c = motion.mass + 2 * Decimal(motion.ratio) * exact.sqrt() + motion.stiffness * exact
            beta_squared = exact - motion.omega**2
            self.beta_squared[i], self.damping[i], self.turning[i] = map(long, (beta_squared, c, beta_squared - c * c / 4))
        root = np.sqrt(np.maximum(-self.turning, 0))
        sum_of = np.where(root + self.damping > 0, root + self.damping / 2, 1)
        self.slow = np.where(self.turning > 0, -self.damping / 2, -self.beta_squared / sum_of)

    def shapes(self, xi):
        """Φ(ξ), (modes)."""
        if xi in (0.0, 1.0):
            return xi * self.tip
        alpha, xi = self.alpha, LONG(xi)
        values = np.sqrt(LONG(2)) * np.cos((alpha * xi + PI / 4) % (2 * PI)) - np.exp(-alpha * xi)
        values += self.tip / 2 * np.exp(-alpha * (1 - xi))
        values[:LOW] = low_shapes(alpha[:LOW], xi)
        return values


def low_root(k, gamma):
    """λ of root k, by Newton's method on the series of 1 + cos α cosh α + αγ (cos α sinh α − sin α cosh α) in α⁴."""
    if k == 1:
        root = Decimal(3) / (gamma + Decimal("0.2427"))
    else:
        guess = (k - 0.75) * np.pi
        root = Decimal(guess + np.arctan(1 / (1 + 2 * float(gamma) * guess))) ** 4
    for _ in range(12):
        value, slope, power = Decimal(1), Decimal(0), Decimal(1)
        for m, (a, b) in enumerate(SERIES):
            if m:
                slope += m * a * power  # λ^(m−1)
                power *= root
            slope -= (m + 1) * gamma * b * power
            value += power * (a - gamma * b * root)
        step = value / slope
        root -= step
        if abs(step) < root * Decimal("1e-45"):
            return root
    raise ArithmeticError(f"root {k} for {gamma}")


def far_roots(k, gamma):
    """Where sech α is nothing: tan δ = 1/(1 + 2γα), α = (k − ¾)π + δ."""
    anchor = (k - LONG("0.75")) * PI
    rest = np.zeros_like(anchor)
    for _ in range(5):  # of Newton's method, from 0.8 at most
        x = 1 + 2 * gamma * (anchor + rest)
        rest = rest - (rest - np.arctan(1 / x)) / (1 + 2 * gamma / (x**2 + 1))
    return anchor + rest


def tips_and_masses(alpha, gamma):
    """Φ(1) and ∫Φ² dξ + γΦ(1)², by parts: 4∫Φ² = Φ² + (3ΦΦ''' − 2Φ'Φ''')/α⁴ at the tip, Φ''' = −γα⁴Φ there."""
    low, far = alpha[:LOW], alpha[LOW:]
    s, c = np.sin(low), np.cos(low)
    below = s + np.sinh(low)
    tip = 2 * (c * np.sinh(low) - s * np.cosh(low)) / below
    slope = -2 * low * s * np.sinh(low) / below
    mass = ((1 + gamma) * tip**2 + 2 * gamma * tip * slope) / 4
    sine = 1 / np.sqrt(1 + (1 + 2 * gamma * far) ** 2)  # of the angle whose tangent is 1/(1 + 2γα)
    sign = np.where(np.arange(LOW, len(alpha)) % 2 == 1, 1, -1)  # (−1)^k of k = LOW + 1, …
    return np.concatenate([tip, sign * np.sqrt(LONG(8)) * sine]), np.concatenate([mass, 1 + 2 * gamma * sine**2])


def low_shapes(alpha, xi):
    """Eqs 7 and 18, with e^(αξ) joined to the small factor before it."""
    end = np.exp(-alpha)
    below = 2 * end * np.sin(alpha) + 1 - end**2
    joined = 2 * (np.sin(alpha) - np.cos(alpha) - end) / below
    sigma = (2 * end * np.cos(alpha) + 1 + end**2) / below
    fading = (1 + sigma) * np.exp(-alpha * xi) + joined * np.exp(alpha * (xi - 1))
    return np.cos(alpha * xi) - sigma * np.sin(alpha * xi) - fading / 2


def flow(modes, chosen, state, time, kind=LONG):
    """Displacement and velocity of some modes at times ≥ 0, (2, modes, times), in numbers of a kind."""
    t = np.asarray(time).astype(kind)[np.newaxis, :]
    q, rate, turning, c, slow, square = (
        values[chosen].astype(kind)[:, np.newaxis]
        for values in (*state, modes.turning, modes.damping, modes.slow, modes.beta_squared)
    )
    root = np.sqrt(abs(turning))
    safe = np.where(root > 0, root, 1)
    faded = np.exp(np.maximum(slow * t, -700))
    phase = (root * t) % kind(2 * PI)
    falling = np.where(root > 0, -np.expm1(np.maximum(-2 * root * t, -700)) / (2 * safe), t)  # sinh rt e^(−rt)/r
    sine = faded * np.where(turning > 0, np.sin(phase) / safe, falling)
    cosine = faded * np.where(turning > 0, np.cos(phase), 1 - root * falling)
    return np.array([q * cosine + (rate + c / 2 * q) * sine, rate * cosine - (c / 2 * rate + square * q) * sine])


def histories(modes, state, points, first, step, samples):
    """Displacement and velocity at times first + j·step, (2, points, samples)."""
    shapes = np.stack([modes.shapes(xi) for xi in points])
    total = np.zeros((2, len(points), samples))
    time = first + step * np.arange(samples).astype(LONG)
    one_by_one = (modes.turning * (first + step * samples) ** 2 < 40) | (modes.number <= LOW)
    chosen = np.flatnonzero(one_by_one)
    for i in range(0, len(chosen), LOW):
        k = chosen[i : i + LOW]
        for j in range(0, samples, 4096):
            part = slice(j, j + 4096)
            moved = flow(modes, k, state, time[part], LONG if i == 0 else float)
            total[:, :, part] += (shapes[:, k].astype(moved.dtype) @ moved).astype(float)
    add_turning(modes, np.flatnonzero(~one_by_one), state, shapes, first, step, total)
    return total


def add_turning(modes, chosen, state, shapes, first, step, total):
    """Modes that turn: e^(st) in blocks of time, of which each is that of the first times one factor."""
    q, rate = state
    samples = total.shape[2]
    length = max(1, int(np.sqrt(samples)))
    blocks = -(-samples // length)
    inner = step * np.arange(length).astype(LONG)
    outer = first + step * (length * np.arange(blocks)).astype(LONG)
    for i in range(0, len(chosen), BATCH):
        k = chosen[i : i + BATCH]
        frequency, damping = np.sqrt(modes.turning[k]), modes.damping[k]
        start = (q[k] - 1j * (rate[k] + damping / 2 * q[k]) / frequency).astype(complex)
        s = (-damping / 2).astype(float) + 1j * frequency.astype(float)
        within, begins = exponentials(frequency, damping, inner), exponentials(frequency, damping, outer)
        for values, amplitude in zip(total, (start, start * s)):
            weighted = amplitude[:, np.newaxis] * begins
            for history, shape in zip(values, shapes[:, k].astype(float)):
                history += ((shape[:, np.newaxis] * weighted).T @ within).real.ravel()[:samples]


def exponentials(frequency, damping, times):
    """e^(st), (modes, times), the phase reduced before it is rounded."""
    phase = np.multiply.outer(frequency, times)
    phase -= 2 * PI * np.rint(phase / (2 * PI))
    fading = np.maximum(np.multiply.outer(-damping / 2, times).astype(float), -700)
    return np.exp(fading + 1j * phase.astype(float))


def captured_start(motion, modes):
    """Of the continuum: the beam at rest, and the mass with the tip's velocity."""
    return np.zeros(modes.count), LONG(1 + motion.restitution) * LONG(motion.gamma) * modes.tip / modes.mass


def released_start(motion, free):
    """State of the beam alone when the mass leaves: overlaps −γΦ̄_kᾱ_k⁴φ_i/(ᾱ_k⁴ − α_i⁴)."""
    near = 2 * free.count
    enough = int(14 * (free.count / 30) ** (5 / 3))  # that n^(−3/2) of the tip's velocity is 1/50 of (count/30)^(−5/2)
    far = 0 if motion.damped else min(FARTHEST, enough)
    loaded = Modes(motion, motion.gamma, max(near, far))
    weights = motion.gamma * loaded.tip * state_at(loaded, captured_start(motion, loaded), long(motion.release))
    square, own = loaded.alpha**2, free.alpha**2
    sums = distant_sums(own.astype(float), square[:near].astype(float), weights[:, :near].astype(float))
    for apart in range(-NEIGHBOURS, NEIGHBOURS + 1):  # whose squares have digits in common
        i = np.arange(max(0, -apart), free.count)
        k = i + apart
        difference = (free.alpha[i] - loaded.alpha[k]) * (free.alpha[i] + loaded.alpha[k])
        sums[:, i] += (square[k] ** 2 / (difference * (own[i] + square[k])) * weights[:, k]).astype(float)
    ratio, beyond = 1 / square[near:] ** 2, weights[:, near:]
    for m in range(MOMENTS):
        sums -= np.multiply.outer(beyond.sum(axis=1), own ** (2 * m)).astype(float)
        beyond = beyond * ratio
    return sums * free.tip


def state_at(modes, start, time):
    """Displacement and velocity of all modes at one time, (2, modes)."""
    parts = [np.arange(i, min(i + BATCH, modes.count)) for i in range(0, modes.count, BATCH)]
    return np.concatenate([flow(modes, part, start, np.array([time]))[:, :, 0] for part in parts], axis=1)


def distant_sums(own, square, weights):
    """Sums over the modes that are no neighbours, (2, modes of the beam alone), of α² each."""
    sums = np.zeros((2, len(own)))
    apart = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    weighted, fourth = (weights * square**2).T, square**2
    for i in range(0, len(own), ROWS):
        below = own[i : i + ROWS, np.newaxis] ** 2 - fourth
        row = np.arange(len(below))[:, np.newaxis]
        row, column = np.broadcast_arrays(row, row + i + apart)
        inside = column >= 0
        below[row[inside], column[inside]] = np.inf
        sums[:, i : i + ROWS] = (np.reciprocal(below, out=below) @ weighted).T
    return sums


def continuum(motion, points, step, samples, count):
    """Displacement and velocity of `count` modes at the times j·step, (2, points, samples); at t = 0 of all there are."""
    step = long(step)
    if motion.release is None:
        modes = Modes(motion, motion.gamma, count)
        found = histories(modes, captured_start(motion, modes), points, LONG(0), step, samples)
        found[0, :, 0] = 0.0
        found[1, :, 0] = [(1 + motion.restitution) * (xi == 1.0) for xi in points]
        return found
    released = long(motion.release)
    before = min(samples, int(np.ceil(released / step)))
    early = continuum(replace(motion, release=None), points, step, before, count)
    free = Modes(motion, 0.0, count)
    late = histories(free, released_start(motion, free), points, step * before - released, step, samples - before)
    return np.concatenate([early, late], axis=2)
