"""The paper's beam and mass with very many modes, by a route of its own: what a run is compared with.

The first modes have roots of the power series of Eq. 19 in λ = α⁴, in 60 decimal digits; all others the form that is left where
sech α is nothing, in numpy's extended precision. A release is the overlap of each mode with each, by the identity of two shapes
of v'''' = α⁴v, and moments of the modes far above. Lengths in l, times in l²/h, masses in m_i, velocities in the speed of
approach.
"""

from dataclasses import dataclass, replace
from decimal import Decimal, getcontext
from math import factorial

import numpy as np

getcontext().prec = 60
LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")
LOW = 14  # modes from the power series; e^(−α) of the next is 1e-18
TERMS = 90  # of the series: at α = 42 the last is 1e-150
BATCH = 2048  # modes held at a time
NEIGHBOURS = 20  # modes to each side whose overlap is taken from α and not from α⁴
MOMENTS = 8  # of modes more than twice above, in powers of 1/16
SERIES = [(Decimal((-4) ** m) / factorial(4 * m), Decimal(4 * (-4) ** m) / factorial(4 * m + 3)) for m in range(TERMS)]
FAR = 400_000  # modes with the mass that the moments count


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
    return LONG(str(value))


class Modes:
    """The first `count` modes of the beam with a mass γ at its tip; 0: alone."""

    def __init__(self, motion, gamma, count):
        squares = [low_root(k, Decimal(gamma)) for k in range(1, min(LOW, count) + 1)]
        low = np.array([long(square.sqrt().sqrt()) for square in squares])
        k = np.arange(len(low) + 1, count + 1).astype(LONG)
        self.gamma, self.count = gamma, count
        self.alpha = np.concatenate([low, far_roots(k, gamma)])
        self.number = np.arange(1, count + 1)
        self.tip, self.mass = tips_and_masses(self.alpha, gamma)
        # β² and c, from all digits of the first; √(β² − c²/4) squared
        omega, mass, stiffness = long(motion.omega), long(motion.mass), long(motion.stiffness)
        square = self.alpha**2
        self.beta_squared = (square - omega) * (square + omega)
        self.damping = mass + 2 * LONG(motion.ratio) * square + stiffness * square**2
        self.turning = self.beta_squared - self.damping**2 / 4
        self.slow = -self.damping / 2
        for i, exact in enumerate(squares):
            c = motion.mass + 2 * Decimal(motion.ratio) * exact.sqrt() + motion.stiffness * exact
            beta_squared = exact - motion.omega**2
            turning = beta_squared - c * c / 4
            self.beta_squared[i], self.damping[i], self.turning[i] = map(long, (beta_squared, c, turning))
            self.slow[i] = long(-c / 2 if turning > 0 else -beta_squared / ((-turning).sqrt() + c / 2) if turning else -c / 2)
        over = (self.turning <= 0) & (self.number > LOW)
        self.slow[over] = -self.beta_squared[over] / (np.sqrt(-self.turning[over]) + self.damping[over] / 2)

    def shapes(self, xi):
        """Φ(ξ), (modes)."""
        if xi in (0.0, 1.0):
            return xi * self.tip
        alpha, xi = self.alpha, LONG(xi)
        whole = np.sqrt(LONG(2)) * np.cos((alpha * xi + PI / 4) % (2 * PI)) - np.exp(-alpha * xi)
        values = whole + self.tip / 2 * np.exp(-alpha * (1 - xi))
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
        value, slope, power = Decimal(1), Decimal(0), Decimal(1)  # power: λ^m, and λ^(m−1) in the slope
        for m, (a, b) in enumerate(SERIES):
            if m:
                slope += m * a * power
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


def flow(modes, chosen, q, rate, time):
    """State of some modes at times ≥ 0, (modes, times) each, in extended precision."""
    t = np.asarray(time, LONG)[np.newaxis, :]
    turning = modes.turning[chosen][:, np.newaxis]
    c, slow, square = (values[chosen][:, np.newaxis] for values in (modes.damping, modes.slow, modes.beta_squared))
    root = np.sqrt(abs(turning))
    safe = np.where(root > 0, root, 1)
    phase = (root * t) % (2 * PI)
    faded = np.exp(np.maximum(slow * t, -11000))
    twice = np.exp(np.maximum(-2 * root * t, -11000))
    sine = np.where(turning > 0, np.sin(phase) / safe, np.where(root > 0, -np.expm1(-2 * root * t) / (2 * safe), t)) * faded
    cosine = np.where(turning > 0, np.cos(phase), (1 + twice) / 2) * faded
    q, rate = q[chosen][:, np.newaxis], rate[chosen][:, np.newaxis]
    return q * cosine + (rate + c / 2 * q) * sine, rate * cosine - (c / 2 * rate + square * q) * sine


def histories(modes, q, rate, points, first, step, samples):
    """Displacement and velocity at times first + j·step, (points, samples) each."""
    shapes = np.stack([modes.shapes(xi) for xi in points])
    longest = first + step * samples
    by_hand = (modes.turning <= 0) | (modes.turning * longest**2 < 40) | (modes.number <= LOW)
    total = np.zeros((2, len(points), samples))
    time = first + step * np.arange(samples).astype(LONG)
    slow = np.flatnonzero(by_hand)
    for i in range(0, len(slow), 64):
        k = slow[i : i + 64]
        for j in range(0, samples, 4096):
            part = slice(j, j + 4096)
            for value, motion in zip(total, flow(modes, k, q, rate, time[part])):
                value[:, part] += (shapes[:, k] @ motion).astype(float)
    fast = np.flatnonzero(~by_hand)
    length = max(1, int(np.sqrt(samples)))
    blocks = -(-samples // length)
    inner, outer = step * np.arange(length).astype(LONG), first + step * (length * np.arange(blocks)).astype(LONG)
    for i in range(0, len(fast), BATCH):
        k = fast[i : i + BATCH]
        frequency = np.sqrt(modes.turning[k])
        start = (q[k] - 1j * (rate[k] + modes.damping[k] / 2 * q[k]) / frequency).astype(complex)
        s = (-modes.damping[k] / 2).astype(float) + 1j * frequency.astype(float)
        within, begins = (exponentials(frequency, modes.damping[k], times) for times in (inner, outer))
        for value, amplitude in zip(total, (start, start * s)):
            weighted = amplitude[:, np.newaxis] * begins
            for p, history in enumerate(value):
                product = (shapes[p, k].astype(float)[:, np.newaxis] * weighted).T @ within
                history += product.real.ravel()[:samples]
    return total


def exponentials(frequency, damping, times):
    """e^(st), (modes, times), the phase reduced before it is rounded."""
    phase = np.multiply.outer(frequency, times)
    phase -= 2 * PI * np.rint(phase / (2 * PI))
    fading = np.maximum(np.multiply.outer(-damping / 2, times).astype(float), -700)
    return np.exp(fading + 1j * phase.astype(float))


def captured_start(motion, modes):
    """Modal velocities of the continuum: the beam at rest, and the mass with the tip's velocity."""
    return LONG(1 + motion.restitution) * LONG(motion.gamma) * modes.tip / modes.mass


def released_start(motion, free):
    """Displacement and velocity of each mode of the beam alone when the mass leaves: overlaps −γΦ̄_kᾱ_k⁴φ_i/(ᾱ_k⁴ − α_i⁴)."""
    near = 2 * free.count
    loaded = Modes(motion, motion.gamma, near if motion.damped else max(FAR, 2 * near))
    state = state_at(loaded, captured_start(motion, loaded), long(motion.release))
    weights = motion.gamma * loaded.tip * state
    square, own = loaded.alpha**2, free.alpha**2
    sums = overlaps(own.astype(float), square[:near].astype(float), weights[:, :near].astype(float))
    for apart in range(-NEIGHBOURS, NEIGHBOURS + 1):  # whose squares have digits in common
        i = np.arange(max(0, -apart), free.count)
        k = i + apart
        exact = square[k] ** 2 / ((free.alpha[i] - loaded.alpha[k]) * (free.alpha[i] + loaded.alpha[k]) * (own[i] + square[k]))
        sums[:, i] += (exact * weights[:, k]).astype(float)
    ratio, far = 1 / square[near:] ** 2, weights[:, near:]
    for m in range(MOMENTS):
        sums -= np.multiply.outer(far.sum(axis=1), own ** (2 * m)).astype(float)
        far = far * ratio
    return sums * free.tip


def state_at(modes, rate, time):
    """Displacement and velocity of all modes at one time, (2, modes)."""
    state, rest, here = np.empty((2, modes.count), LONG), np.zeros(modes.count), np.array([time])
    for i in range(0, modes.count, BATCH):
        part = np.arange(i, min(i + BATCH, modes.count))
        state[:, part] = np.array(flow(modes, part, rest, rate, here))[:, :, 0]
    return state


def overlaps(own, square, weights):
    """Sums over the modes that are no neighbours, of α² each."""
    sums = np.zeros((2, len(own)))
    for i in range(0, len(own), 256):
        below = own[i : i + 256, np.newaxis] ** 2 - square**2
        number = np.arange(i, i + len(below))[:, np.newaxis]
        apart = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
        row, column = np.broadcast_arrays(number - i, number + apart)
        inside = column >= 0
        below[row[inside], column[inside]] = np.inf
        sums[:, i : i + 256] = (weights * square**2) @ (1 / below).T
    return sums


def continuum(motion, points, step, samples, count):
    """Displacement and velocity of `count` modes at the times j·step, (points, samples) each; at t = 0 of all there are."""
    step = long(step)
    if motion.release is None:
        modes = Modes(motion, motion.gamma, count)
        found = histories(modes, np.zeros(count), captured_start(motion, modes), points, LONG(0), step, samples)
        found[0, :, 0] = 0.0
        found[1, :, 0] = [(1 + motion.restitution) * (xi == 1.0) for xi in points]
        return found
    released = long(motion.release)
    before = min(samples, int(np.ceil(released / step)))
    early = continuum(replace(motion, release=None), points, step, before, count)
    free = Modes(motion, 0.0, count)
    late = histories(free, *released_start(motion, free), points, step * before - released, step, samples - before)
    return np.concatenate([early, late], axis=2)
