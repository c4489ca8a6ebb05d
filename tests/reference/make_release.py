"""Writes released_motion.txt: the paper's beam after a captured mass has left it again, from very many modes (two minutes).

When the mass leaves, the modes without it start from what those with it do: ∫Φ̄_kφ_i dξ of each with each, by the identity
of two shapes of v'''' = α⁴v. The sum over k of such terms ends as TERMS^(−3/2), a part of 1e-9 of the largest displacement,
and that is what the table is good for: nothing is known here of what the modes far above add up to. Roots and phases are in
numpy's extended precision.
"""

import numpy as np

from beam import PaperBeam, use_digits
from table import write_table

TERMS, MODES, CHUNK = 1_000_000, 3000, 2000
GAMMA, OMEGA, LEAVES = 0.2, 50.0, 0.1
POSITIONS = [0.5, 1.0]
TIMES = [0.1, 0.10025, 0.15, 0.2, 0.24975]  # s
LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")


def roots(count, gamma):
    """Newton's method on the frequency equation over cosh α, from where high modes go."""
    k = np.arange(1, count + 1).astype(LONG)
    alpha = (k - LONG("0.75" if gamma else "0.5")) * PI
    alpha[:2] = [1.6164, 4.2671] if gamma else [1.8751, 4.6941]
    for _ in range(8):
        s, c, t, u = np.sin(alpha), np.cos(alpha), np.tanh(alpha), 1 / np.cosh(np.minimum(alpha, 40))
        f = u + c + alpha * gamma * (c * t - s)
        alpha = alpha - f / (-u * t - s + gamma * (c * t - s) - alpha * gamma * (s * t + c * t**2))
    return alpha


def shapes(alpha, xi):
    """Eqs 7 and 18, with e^(αξ) joined to the small factor before it."""
    end = np.exp(-alpha)
    below = 2 * end * np.sin(alpha) + 1 - end**2
    joined = 2 * (np.sin(alpha) - np.cos(alpha) - end) / below
    sigma = (2 * end * np.cos(alpha) + 1 + end**2) / below
    fading = (1 + sigma) * np.exp(-alpha * xi) + joined * np.exp(alpha * (xi - 1))
    return np.cos(alpha * xi) - sigma * np.sin(alpha * xi) - fading / 2


def modal_masses(alpha, gamma):
    """∫Φ² dξ + γΦ(1)², the integral by parts: 4∫Φ² = Φ² + (3ΦΦ''' − 2Φ'Φ''')/α⁴ at the tip, Φ''' = −γα⁴Φ there."""
    tip = shapes(alpha, LONG(1))
    return ((1 + gamma) * tip**2 + 2 * gamma * tip * tip_slopes(alpha)) / 4


def tip_slopes(alpha):
    """Φ'(1) = −2α sin α sinh α/(sin α + sinh α)."""
    s, end = np.sin(alpha), np.exp(-alpha)
    return -2 * alpha * s * (1 - end**2) / (2 * end * s + 1 - end**2)


def state(loaded, free, beta, time):
    """Displacement and velocity of each free mode when the mass leaves, both over the speed of approach."""
    tip = shapes(loaded, LONG(1))
    drive = GAMMA * tip / modal_masses(loaded, GAMMA)
    phase = (beta * time) % (2 * PI)
    weights = np.stack([GAMMA * tip * drive * np.sin(phase) / beta, GAMMA * tip * drive * np.cos(phase)], axis=1)
    sums = np.zeros((len(free), 2))
    low = free.astype(float)
    for first in range(0, len(loaded), CHUNK):
        part = slice(first, first + CHUNK)
        far = loaded[part].astype(float)
        apart = (low[:, None] - far) + ((free - low).astype(float)[:, None] - (loaded[part] - far).astype(float))
        overlap = far**4 / (apart * (low[:, None] + far) * (low[:, None] ** 2 + far**2))
        sums += overlap @ weights[part].astype(float)
    return sums * shapes(free, LONG(1)).astype(float)[:, None]


def motion():
    beam = PaperBeam()
    h = LONG(str(beam.h))
    loaded, free = roots(TERMS, GAMMA), roots(MODES, 0.0)
    beta = np.sqrt((h * loaded**2) ** 2 - LONG(OMEGA) ** 2)
    q, rate = state(loaded, free, beta, LONG(LEAVES)).T
    beta = np.sqrt((h * free**2) ** 2 - LONG(OMEGA) ** 2)
    for time in TIMES:
        phase = (beta * (LONG(time) - LONG(LEAVES))) % (2 * PI)
        modal = q * np.cos(phase) + rate / beta * np.sin(phase)
        for xi in POSITIONS:
            yield GAMMA, OMEGA, LEAVES, time, xi, float(f"{np.sum(modal * shapes(free, LONG(xi))):.10g}")


if __name__ == "__main__":
    use_digits(40)
    write_table("released_motion.txt", f"""
Displacement (m) of the paper's beam (length 1, diameter 0.037, density 7870, Young's modulus 2e11) at xi = x/l and the time
(s), after it caught a mass with restitution 0 at 1 m/s and let it go again at the time `leaves`, from {TERMS} modes with
the mass and {MODES} without it: to about 2e-9 of the largest value
""", ["gamma", "omega", "leaves", "time", "xi", "displacement"], motion())
