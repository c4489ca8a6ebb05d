"""Random scenes whose waves are measured, what is true of them, and which of their modes a record can tell.

A mode can be told where it oscillates, its line lies two periods of the record or more from 0 and from half the sampling rate
and grows or decays by less than e^10, no other line that can be seen lies within two periods, and it is a hundred times as
strong as what can be seen. A record holds no more lines than an eighth of its samples: the strength of the next one is what can
be seen, and never less than 1e-9 of the record's peak. A wave number can be told where three modes or more can.
"""

import numpy as np
from closed_form import roots, shapes
from workplace import PAPER_BEAM

H = np.longdouble(0.037) / 4 * np.sqrt(np.longdouble(2e11) / np.longdouble(7870))  # m²/s
TWO_PI = 4 * np.arcsin(np.longdouble(1))
MOST_MODES = 1000  # of a record by tolerance: later ones are fainter than 1e-9
GAP = 2.0  # periods in the record
ROOM = 8  # samples for each line that a record holds
MARGIN = 100.0
FAINTEST = 1e-9
MOST_GROWTH = 10.0


def between(random, low, high):
    """A number with so many digits as people write, its logarithm even between these two."""
    return float(f"{10 ** random.uniform(np.log10(low), np.log10(high)):.4g}")


def captured(random):
    """A beam with its mass, in most scenes rotating, nearly up to the critical speed."""
    mass_ratio = between(random, 0.01, 10.0)
    scene = {"beam": dict(PAPER_BEAM), "impact": {"mass_ratio": mass_ratio}, "capture": {}, "spectrum": {"max_peaks": 1000}}
    if random.random() < 0.7:
        scene["rotation"] = {"angular_velocity": round(random.uniform(0.0, 0.95 * critical_speed(mass_ratio)), 3)}
    return scene


def critical_speed(mass_ratio):
    return float(H * roots(1, mass_ratio)[0] ** 2)


def recorded(scene, duration, samples):
    return {**scene, "response": {"duration": duration, "samples": int(samples), "points": [0.5, 1.0]}}


def up_to(scene, frequency, samples):
    """A record with that frequency (rad/s) at half its sampling rate."""
    return recorded(scene, float(f"{np.pi * samples / frequency:.4g}"), samples)


def few_samples(random, most=1000):
    """Of the thousands of modes that a tolerance takes nearly all are folded."""
    return recorded(captured(random), between(random, 0.05, 3.0), between(random, 48, most))


def few_modes(random):
    scene = captured(random)
    scene["modes"] = {"before": int(random.integers(1, 16)), "after": int(random.integers(1, 7))}
    near = roots(8, scene["impact"]["mass_ratio"])[random.integers(0, scene["modes"]["after"] + 1)]
    return up_to(scene, H * near**2 * random.uniform(0.4, 1.6), between(random, 64, 4000))


def folded(random):
    scene = captured(random)
    scene["modes"] = {"before": int(random.integers(10, 61)), "after": int(random.integers(10, 61))}
    near = roots(60, scene["impact"]["mass_ratio"])[random.integers(2, 2 + scene["modes"]["after"] // 2)]
    return up_to(scene, H * near**2 * random.uniform(0.6, 1.4), between(random, 250, 16000))


def damped(random, most=8000):
    scene = captured(random)
    if random.random() < 0.5:
        scene["damping"] = {"ratio": between(random, 1e-4, 0.3)}
    else:
        scene["damping"] = {
            "mass_proportional": between(random, 0.1, 100.0),
            "stiffness_proportional": between(random, 1e-7, 3e-4),
        }
    if random.random() < 0.75:
        scene["modes"] = {"before": int(random.integers(2, 41)), "after": int(random.integers(2, 41))}
    return recorded(scene, between(random, 0.05, 3.0), between(random, 64, most))


def growing(random, most=8000):
    scene = captured(random)
    critical = critical_speed(scene["impact"]["mass_ratio"])
    speed = float(f"{critical * (1 + between(random, 1e-4, 2.0)):.6g}")
    scene["rotation"] = {"angular_velocity": speed}
    if random.random() < 0.75:
        scene["modes"] = {"before": int(random.integers(2, 41)), "after": int(random.integers(2, 41))}
    duration = between(random, 0.05, 25.0) / np.sqrt(abs(speed**2 - critical**2))
    return recorded(scene, float(f"{min(max(duration, 0.02), 5.0):.4g}"), between(random, 64, most))


def galerkin(random):
    """Stiffening, stiffening with shear, shear, or a body that turns: modes without a closed form."""
    scene = captured(random)
    kind = random.integers(0, 4)
    if kind <= 1:
        scene["rotation"] = {"angular_velocity": round(random.uniform(1.0, 300.0), 3)}
        scene["stiffening"] = {"hub_radius": round(random.uniform(0.0, 1.0), 3)}
    if kind in (1, 2):
        scene["shear"] = {"poisson_ratio": 0.3}
    if kind == 3:
        scene["capture"] = {"rotary_inertia": between(random, 1e-4, 0.1)}
    if random.random() < 0.25:
        scene["damping"] = {"ratio": between(random, 1e-4, 0.1)}
    scene["modes"] = {"before": int(random.integers(3, 26)), "after": int(random.integers(3, 26))}
    return recorded(scene, between(random, 0.05, 2.0), between(random, 64, 10000))


class Waves:
    """True values of a scene in closed form, one for each mode; NaN where one does not exist. Eqs 19, 30, 32, 33."""

    def __init__(self, scene):
        count = scene.get("modes", {}).get("after", MOST_MODES)
        self.wavenumber = roots(count, np.longdouble(scene["impact"]["mass_ratio"]))
        speed = np.longdouble(scene.get("rotation", {}).get("angular_velocity", 0.0))
        bending = H * self.wavenumber**2
        damping = {name: np.longdouble(value) for name, value in scene.get("damping", {}).items()}
        if "ratio" in damping:
            rate = damping["ratio"] * bending
        else:
            rate = (damping.get("mass_proportional", 0) + damping.get("stiffness_proportional", 0) * bending**2) / 2
        self.rate = rate
        square = (bending - speed) * (bending + speed)
        with np.errstate(invalid="ignore"):
            self.angular_frequency = np.sqrt((np.sqrt(square) - rate) * (np.sqrt(square) + rate))
            self.phase_velocity = np.sqrt(square) / self.wavenumber
            self.group_velocity = 2 * H**2 * self.wavenumber**3 / np.sqrt(square)

    def amplitudes(self, scene, result):
        """Of each mode's displacement at midpoint and tip, (2, modes)."""
        shape = shapes(self.wavenumber, np.array([0.5, 1.0]))
        velocity = result["modal_velocity"][: len(self.wavenumber)]
        if "modes" not in scene:  # the continuum: (1 + e) m Φ(1)/M
            gamma = scene["impact"]["mass_ratio"]
            velocity = gamma * shape[1] / modal_masses(self.wavenumber, shape[1], gamma)
        return np.abs(shape * velocity) / np.abs(self.angular_frequency)


def modal_masses(alpha, tip, mass_ratio):
    """∫Φ² dξ + γΦ(1)² without quadrature, every exponential a decaying one."""
    decay = np.exp(-alpha)
    sine = (2 * np.sin(alpha) * decay + 1 - decay**2) / 2  # (sin α + sinh α) e^(−α)
    product = (2 * decay + np.cos(alpha) * (1 + decay**2)) * np.sin(alpha) * (1 - decay**2)
    return (1 + mass_ratio) * tip**2 / 4 + product / (2 * sine**2)


class Record:
    """Where the modes' lines are in a record, periods in it, and how strong, of the record's peak."""

    def __init__(self, scene, frequency, rate, amplitudes, peak):
        duration, self.samples = scene["response"]["duration"], scene["response"]["samples"]
        self.oscillates = ~np.isnan(frequency)
        self.position = np.where(self.oscillates, frequency, 0.0) * duration / TWO_PI
        self.image = np.abs(self.position - self.samples * np.rint(self.position / self.samples))
        self.growth = np.abs(rate) * duration
        self.strength = np.nan_to_num(np.hypot(*amplitudes)) / peak

    def can_be_told(self):
        """Which modes' frequencies can be told, by the definition above."""
        by_strength = np.sort(self.strength)[::-1]
        room = self.samples // ROOM
        seen = max(FAINTEST, by_strength[room] if room < len(by_strength) else 0.0)
        visible = self.strength >= seen
        apart = [np.count_nonzero(visible & (np.abs(self.image - image) <= GAP)) < 2 for image in self.image]
        inside = (self.position >= GAP) & (self.position <= self.samples / 2 - GAP)
        return self.oscillates & inside & apart & (self.growth < MOST_GROWTH) & (self.strength >= MARGIN * seen)
