"""Random scenes of every class, run and compared with 30 times the modes: are tolerances kept, and errors within estimates?

By hand: python tests/scenes/tails.py [--draws 60] [--beamwave build/bin/beamwave]
"""

import argparse
import os
import tempfile
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import numpy as np
from continuum import Modes, Motion, continuum
from workplace import PAPER_BEAM, Workplace

KINDS = ["undamped", "damped", "near critical", "growing", "released", "damped and released"]
RECORDS = ["ordinary", "short", "dense", "commensurable", "long"]
TIMES = 30  # as many modes
H = (Decimal(PAPER_BEAM["diameter"]) / 4 * (Decimal(PAPER_BEAM["youngs_modulus"]) / Decimal(PAPER_BEAM["density"])).sqrt())
LARGEST = 30.0  # nepers of growth


def log_between(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


class Scene(NamedTuple):
    """A scene without its `&modes`, and what it means."""

    groups: dict
    motion: Motion
    record: dict


def draw_record(rng, record):
    """Duration in l²/h, samples, points."""
    points = [float(rng.uniform(0.02, 1)), 0.5, 1.0]
    if record == "ordinary":
        return log_between(rng, 0.1, 100), int(rng.integers(50, 1000)), points
    if record == "short":
        points = [1 - log_between(rng, 1e-4, 1), float(rng.choice([0.9, 0.99, 0.999])), 1.0]
        return log_between(rng, 3e-6, 1), int(rng.integers(5, 1500)), points
    if record == "dense":
        points = [1 - log_between(rng, 1e-3, 1), float(rng.uniform(0.02, 1)), 1.0]
        return log_between(rng, 1e-3, 3), 2 ** int(rng.integers(9, 14)), points
    if record == "commensurable":
        samples = int(rng.integers(20, 1500))
        points = [float(rng.choice([0.25, 0.5, 0.75, rng.uniform(0.02, 1)])), float(rng.uniform(0.02, 1)), 1.0]
        return 4 / np.pi * 2.0 ** rng.integers(-12, 3) * rng.choice([1, 1, 1, 3, 5]) * samples, samples, points
    return log_between(rng, 100, 1e5), 2 ** int(rng.integers(8, 15)), points


def draw(rng, kind, record):
    """A scene of a class."""
    duration, samples, points = draw_record(rng, record)
    gamma = log_between(rng, 0.01, 10)
    restitution = float(rng.choice([0.0, rng.uniform(0, 1)]))
    motion = Motion(gamma, restitution=restitution)
    first = Modes(motion, gamma, 1).alpha[0] ** 2
    groups = {"beam": PAPER_BEAM, "impact": {"mass_ratio": gamma, "restitution": restitution}, "capture": {}}
    omega, duration = draw_speed(rng, kind, float(first), duration)
    if kind.startswith("damped"):
        draw_damping(rng, motion, groups)
    seconds = float(Decimal(duration) / H)
    if record == "commensurable":  # to many digits, not to all
        seconds = float(f"{seconds:.{int(rng.integers(6, 17))}g}")
    speed = float(Decimal(omega) * H)
    if kind == "near critical":  # as near as the digits of a speed allow
        speed = float(Decimal(str(first)) * H * (1 + Decimal(str(omega / float(first) - 1))))
    if speed:
        groups["rotation"] = {"angular_velocity": speed}
    motion.omega = Decimal(speed) / H
    if kind.endswith("released"):
        when = float(rng.uniform(0, 1))
        if rng.random() < 0.3:
            when = int(when * samples) / samples
        groups["release"] = {"time": max(seconds * when, seconds * 1e-3)}
        motion.release = Decimal(groups["release"]["time"]) * H
    response = {"duration": seconds, "samples": samples, "points": points, "velocity": True}
    return Scene({**groups, "response": response}, motion, response)


def draw_speed(rng, kind, critical, duration):
    """Angular velocity in h/l², and a duration in which no mode grows too far."""
    if kind.endswith("released"):
        kind = str(rng.choice(["undamped", "near critical", "growing"]))
    if kind == "near critical":
        omega = critical * (1 + float(rng.choice([-1, 1])) * log_between(rng, 1e-12, 1e-2))
    elif kind == "growing":
        omega = critical * (1 + log_between(rng, 1e-3, 2))
    else:
        omega = float(rng.choice([0.0, rng.uniform(0, 0.99)])) * critical
    if omega > critical:
        duration = min(duration, LARGEST / np.sqrt(omega**2 - critical**2))
    return omega, duration


def draw_damping(rng, motion, groups):
    """A ratio, or Rayleigh's constants, either of which may overdamp high modes."""
    if rng.random() < 0.6:
        motion.ratio = log_between(rng, 1e-6, 0.3)
        groups["damping"] = {"ratio": motion.ratio}
    else:
        mass, stiffness = log_between(rng, 1e-3, 10) * float(H), log_between(rng, 1e-9, 1e-2) / float(H)
        groups["damping"] = {"mass_proportional": mass, "stiffness_proportional": stiffness}
        motion.mass, motion.stiffness = Decimal(mass) / H, Decimal(stiffness) * H


class Found(NamedTuple):
    """Of one run: estimates over errors, (points), and the error over what the tolerance allows; 0 without one."""

    displacement: np.ndarray
    velocity: np.ndarray
    missed: float
    modes: int


def compare(here, scene, modes):
    """One run; None where the tolerance is refused."""
    here.scene("a", {**scene.groups, "modes": modes})
    (here.directory / "output/a.nc").unlink(missing_ok=True)  # of another build: that would be left as it is
    ended = here.beamwave("run", "a.nml", "--quiet")
    if ended.returncode:
        assert "modes%tolerance" in ended.stderr, ended.stderr
        return None
    result = here.result("a")
    used = int(result["mode_count"]) if "tolerance" in modes else max(modes["before"], modes["after"])
    samples = scene.record["samples"]
    step = Decimal(scene.record["duration"]) * H / samples
    truth = continuum(scene.motion, scene.record["points"], step, samples, max(2000, TIMES * used))
    displacement, velocity = truth[0] / float(H), truth[1]
    ratios = []
    for name, value in (("displacement", displacement), ("velocity", velocity)):
        error = np.abs(result[name] - value).max(axis=1)
        rounding = 2e-15 * np.abs(value).max()  # of the comparison
        estimate = result[f"{name}_error"]
        ratios.append(np.where(error > 10 * rounding, estimate / np.maximum(error - rounding, 1e-300), np.inf))
        if name == "displacement":
            missed = max(0, error.max() - rounding) / (modes.get("tolerance", np.inf) * np.abs(value).max())
    return Found(*ratios, missed, used)


def draws(seed, count, kinds=KINDS, records=RECORDS):
    for kind in kinds:
        for record in records:
            for i in range(count):
                rng = np.random.default_rng([seed, KINDS.index(kind), RECORDS.index(record), i])
                scene = draw(rng, kind, record)
                tolerance = log_between(rng, 1e-8 if scene.motion.release is None else 1e-7, 1e-2)
                counts = [int(log_between(rng, 2, 100)) for _ in range(2)]
                yield kind, record, i, scene, {"tolerance": tolerance}
                yield kind, record, i, scene, {"before": counts[0], "after": counts[1]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=60)
    parser.add_argument("--seed", type=int, default=int(os.environ.get("BEAMWAVE_SEED", "1")))
    parser.add_argument("--kinds", nargs="*", default=KINDS)
    parser.add_argument("--records", nargs="*", default=RECORDS)
    parser.add_argument("--beamwave", type=Path, default=Path(__file__).parents[2] / "build/bin/beamwave")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        here = Workplace(options.beamwave.resolve(), Path(directory))
        for kind, record, i, scene, modes in draws(options.seed, options.draws, options.kinds, options.records):
            found = compare(here, scene, modes)
            if found is None:
                print(f"{kind}|{record}|{i}|refused|{modes}", flush=True)
                continue
            text = ["|".join(f"{x:.3g}" for x in values) for values in (found.displacement, found.velocity)]
            print(f"{kind}|{record}|{i}|{'t' if 'tolerance' in modes else 'c'}|{found.modes}|{found.missed:.3g}|" + "|".join(text), flush=True)


if __name__ == "__main__":
    main()
