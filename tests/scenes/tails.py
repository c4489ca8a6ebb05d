"""Random scenes of every class, run and compared with 30 times the modes: are tolerances kept, and errors within bounds and estimates?

`python -m errors` in bench/ draws many of them and prints a table.
"""

from __future__ import annotations

from decimal import Decimal
from typing import NamedTuple

import numpy as np
from continuum import Modes, Motion, continuum
from workplace import PAPER_BEAM

KINDS = ["undamped", "damped", "near critical", "growing", "released", "damped and released"]
RECORDS = ["ordinary", "short", "dense", "commensurable", "long"]
TIMES = 30  # as many modes
FEWEST = 2000  # but at least so many for a displacement
MORE = 16  # times as many again, where an estimate seems to be below the error
MANY = 16_000  # more are summed only if they are four times as many: those beyond are 3 % of a displacement's error
H = Decimal(PAPER_BEAM["diameter"]) / 4 * (Decimal(PAPER_BEAM["youngs_modulus"]) / Decimal(PAPER_BEAM["density"])).sqrt()
GROWTH = 30.0  # nepers, at most
SMALL = 0.1  # of the motion of a point: a larger error need not be known, but for its bound
ROUNDING = 2e-15  # of the comparison, over the peak


class Scene(NamedTuple):
    """A scene without its `&modes`, and what it means."""

    groups: dict
    motion: Motion

    @property
    def response(self):
        return self.groups["response"]


def log_between(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_record(rng, record, most):
    """Duration in l²/h, samples, points."""
    points = [float(rng.uniform(0.02, 1)), 0.5, 1.0]
    if record == "ordinary":
        return log_between(rng, 0.1, 100), int(rng.integers(50, 1000)), points
    if record == "short":
        points = [1 - log_between(rng, 1e-4, 1), float(rng.choice([0.9, 0.99, 0.999])), 1.0]
        return log_between(rng, 3e-6, 1), int(rng.integers(5, 1500)), points
    if record == "dense":
        points = [1 - log_between(rng, 1e-3, 1), float(rng.uniform(0.02, 1)), 1.0]
        return log_between(rng, 1e-3, 3), min(most, 2 ** int(rng.integers(9, 14))), points
    if record == "commensurable":
        samples = int(rng.integers(20, 1500))
        points = [float(rng.choice([0.25, 0.5, 0.75, rng.uniform(0.02, 1)])), float(rng.uniform(0.02, 1)), 1.0]
        return 4 / np.pi * 2.0 ** rng.integers(-12, 3) * rng.choice([1, 1, 1, 3, 5]) * samples, samples, points
    return log_between(rng, 100, 1e5), min(most, 2 ** int(rng.integers(8, 15))), points


def draw(rng, kind, record, most=2**14):
    """A scene of a class, with at most so many samples."""
    duration, samples, points = draw_record(rng, record, most)
    gamma = log_between(rng, 0.01, 10)
    restitution = float(rng.choice([0.0, rng.uniform(0, 1)]))
    motion = Motion(gamma, restitution=restitution)
    groups = {"beam": PAPER_BEAM, "impact": {"mass_ratio": gamma, "restitution": restitution}, "capture": {}}
    critical = Modes(motion, gamma, 1).alpha[0] ** 2
    part, duration = draw_speed(rng, kind, float(critical), duration)
    if kind.startswith("damped"):
        draw_damping(rng, motion, groups)
    seconds = float(Decimal(duration) / H)
    if record == "commensurable":  # to many digits, not to all
        seconds = float(f"{seconds:.{int(rng.integers(6, 17))}g}")
    if part:
        groups["rotation"] = {"angular_velocity": float(Decimal(str(critical)) * H * (1 + Decimal(part)))}
        motion.omega = Decimal(groups["rotation"]["angular_velocity"]) / H
    if kind.endswith("released"):
        when = float(rng.uniform(0, 1))
        if rng.random() < 0.3:
            when = int(when * samples) / samples
        groups["release"] = {"time": max(seconds * when, seconds * 1e-3)}
        motion.release = Decimal(groups["release"]["time"]) * H
    groups["response"] = {"duration": seconds, "samples": samples, "points": points, "velocity": True}
    return Scene(groups, motion)


def draw_speed(rng, kind, critical, duration):
    """Angular velocity over the critical one less 1, 0 where nothing turns, and a duration in which no mode grows too far."""
    if kind.endswith("released"):
        kind = str(rng.choice(["undamped", "near critical", "growing"]))
    if kind == "near critical":
        part = float(rng.choice([-1, 1])) * log_between(rng, 1e-12, 1e-2)
    elif kind == "growing":
        part = log_between(rng, 1e-3, 2)
    else:
        part = -float(rng.choice([0.0, rng.uniform(0.01, 1)]))
    if part > 0:
        duration = min(duration, GROWTH / (critical * np.sqrt(part * (2 + part))))
    return part, duration


def draw_damping(rng, motion, groups):
    """A ratio, or Rayleigh's constants, either of which may overdamp high modes."""
    if rng.random() < 0.6:
        motion.ratio = log_between(rng, 1e-6, 0.3)
        groups["damping"] = {"ratio": motion.ratio}
    else:
        mass, stiffness = log_between(rng, 1e-3, 10) * float(H), log_between(rng, 1e-9, 1e-2) / float(H)
        groups["damping"] = {"mass_proportional": mass, "stiffness_proportional": stiffness}
        motion.mass, motion.stiffness = Decimal(mass) / H, Decimal(stiffness) * H


def scenes(seed, kind, record, numbers, least=1e-8, most=2**14):
    """Scenes of a class with a tolerance, at least so fine, and counts."""
    for number in numbers:
        rng = np.random.default_rng([seed, KINDS.index(kind), RECORDS.index(record), number])
        scene = draw(rng, kind, record, most)
        tolerance = log_between(rng, max(least, 1e-8 if scene.motion.release is None else 1e-7), 1e-2)
        before, after = (int(log_between(rng, 2, 100)) for _ in range(2))
        yield number, scene, {"tolerance": tolerance}, {"before": before, "after": after}


def truth(scene, count):
    """Displacement in m and velocity in m/s of so many modes, (points, samples)."""
    response = scene.response
    step = Decimal(response["duration"]) * H / response["samples"]
    displacement, velocity = continuum(scene.motion, response["points"], step, response["samples"], count)
    return displacement / float(H), velocity


def truths(scene, used, more=1):
    """Displacement and velocity, what a run with so many modes is compared with; a motion that has grown may ask for more."""
    displacement, velocity = truth(scene, more * min(max(FEWEST, TIMES * used), max(MANY, 4 * used)))
    if TIMES * used < FEWEST:  # velocities have no bound where all phases meet
        velocity = truth(scene, more * TIMES * used)[1]
    return displacement, velocity


def compare(here, scene, modes):
    """Estimates over errors of displacement and velocity, and the largest error over what is allowed; None if it is not given."""
    here.scene("a", {**scene.groups, "modes": modes})
    (here.directory / "output/a.nc").unlink(missing_ok=True)  # of another build: that would be left as it is
    ended = here.beamwave("run", "a.nml", "--quiet")
    if ended.returncode:
        # out of reach, or missed and said so; or a history that its last octave of modes decides
        assert "tolerance: " in ended.stderr or "not converged: the" in ended.stderr, ended.stderr
        return None
    result = here.result("a")
    used = int(result["mode_count"]) if "tolerance" in modes else modes["after"]
    if "before" in modes and scene.motion.release is not None:
        used = max(modes.values())  # the modes before move after a release
    seen = ratios(result, truths(scene, used), modes.get("tolerance"))
    if not holds(*seen):  # the fault may be the comparison's: what a released motion grows from converges as n^(−5/2) only
        seen = ratios(result, truths(scene, used, MORE), modes.get("tolerance"))
    return used, *seen


def ratios(result, values, tolerance=None):
    """The largest error over what a tolerance allows, 0 without one, and estimates over errors of displacement and velocity."""
    found, missed = [], 0.0
    for name, value in zip(("displacement", "velocity"), values):
        error = np.abs(result[name] - value).max(axis=1)
        rounding = ROUNDING * np.abs(value).max()
        over = np.maximum(error - rounding, 0)
        found.append(shown(result, name, np.where(over > 9 * rounding, over, 0), np.abs(value).max(axis=1)).tolist())
        if name == "displacement" and tolerance:
            missed = over.max() / (tolerance * np.abs(value).max())
    return missed, *found


def shown(result, name, error, peak):
    """Estimates over errors at each point: infinite where nothing is off or an error is no small one, 0 where it is above its bound."""
    ratio = result[f"{name}_error"] / np.maximum(error, 1e-300)
    ratio = np.where((error > 0) & ((error < SMALL * peak) | (ratio >= 1)), ratio, np.inf)
    if name == "displacement":
        ratio = np.where(np.ma.filled(result["displacement_bound"], np.inf) < error, 0, ratio)
    return ratio


def holds(missed, displacement, velocity):
    """Whether the tolerance was kept and no error is above its estimate."""
    return missed <= 1 and min(displacement + velocity) >= 1
