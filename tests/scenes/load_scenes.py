"""Random scenes of forces and motions of the base, and how their errors compare with what is said of them."""

from typing import Iterator, NamedTuple

import numpy as np
from workplace import PAPER_BEAM

QUANTITIES = ("displacement", "velocity", "acceleration", "bending_moment", "shear_force")
SLOWEST = 2 * np.pi / 163.9533  # s, period of the first mode of the paper's beam
COUNTS = (8, 12, 16, 32, 64)
NOISE = 1e-13  # of a peak; errors below it are those of rounding
TOLD = 0.1  # of a peak; errors above it are no errors that an estimate is made for


class Judged(NamedTuple):
    """A history of few modes beside that of many."""

    quantity: str
    modes: int
    part: float  # error over the peak
    estimate: float  # over the error
    bound: float  # over the error; of displacements


def float_in(rng: np.random.Generator, low: float, high: float) -> float:
    """A number that a namelist takes."""
    return float(rng.uniform(low, high))


def draw(rng: np.random.Generator, kind: str) -> dict:
    """A scene without its count of modes; `kind` is force, base, hub or hub_base: a hub that is free, change: a force, and a body that comes, or
    let_go: from the static deflection under a force.
    """
    duration = 10 ** float_in(rng, -2.5, 0.5) * SLOWEST * 3
    scene = {"beam": dict(PAPER_BEAM)}
    if kind == "change" or rng.random() < 0.5:
        place = 1.0 if rng.random() < 0.5 else round(float_in(rng, 0.1, 1), 4)
        turning = 0.0 if rng.random() < 0.5 else 10 ** float_in(rng, -3, 0)
        scene["body"] = {"position": place, "mass_ratio": 10 ** float_in(rng, -2, 1), "rotary_inertia": turning}
    if kind == "change":
        scene["body"] |= {"from": float_in(rng, 0, 0.7 * duration)}
        if rng.random() < 0.5:
            scene["body"]["stiffness"] = 10 ** float_in(rng, 3, 7)
        if rng.random() < 0.4:
            scene["body"]["rotational_stiffness"] = 10 ** float_in(rng, 2, 6)
        if rng.random() < 0.5:
            scene["body"]["until"] = scene["body"]["from"] + float_in(rng, 0.05, 0.3) * duration
    if rng.random() < 0.2:
        scene["support"] = {"rotational_stiffness": 10 ** float_in(rng, 3, 6)}
    if kind.startswith("hub"):
        scene["hub"] = {"rotary_inertia": 10 ** float_in(rng, -3, 2)}
        if rng.random() < 0.7:
            scene["rotation"] = {"angular_velocity": float_in(rng, 0, 200)}
            scene["stiffening"] = {"hub_radius": float_in(rng, 0, 1)}
    elif rng.random() < 0.2:
        scene["tip_support"] = {"rotational_stiffness": 0.0}
    if rng.random() < 0.2:
        scene["shear"] = {}
    if rng.random() < 0.3:
        scene["damping"] = {"ratio": 10 ** float_in(rng, -3, -1)}
    load = draw_load(rng, duration)
    based = kind.endswith("base")
    if not based:
        load["position"] = 1.0 if "tip_support" not in scene and rng.random() < 0.5 else round(float_in(rng, 0.2, 0.95), 4)
    if kind == "let_go":
        load = {"force": load["amplitude"], "position": load["position"]}
    scene["base" if based else "initial" if kind == "let_go" else "force"] = load
    points = sorted({0.0, 1.0, *(round(float(x), 3) for x in rng.uniform(0.05, 1, 3))})
    asked = dict.fromkeys(QUANTITIES[1:], True)
    asked["acceleration"] = based or (kind in ("force", "hub") and load["shape"] != "rectangle")
    asked["shear_force"] = kind not in ("change", "let_go")
    scene["response"] = {"duration": duration, "samples": int(rng.choice([300, 1000])), "points": points, **asked}
    return scene


def draw_load(rng: np.random.Generator, duration: float) -> dict:
    """Any shape; a sine that ends does so after whole half turns, as its acceleration needs."""
    shape = str(rng.choice(["half_sine", "haversine", "triangle", "rectangle", "sine"]))
    load = {"shape": shape, "amplitude": float_in(rng, -100, 100), "start": float(rng.choice([0.0, float_in(rng, 0, 0.3 * duration)]))}
    length = duration * 10 ** float_in(rng, -2.5, 0)
    if shape not in ("sine", "rectangle") or rng.random() < 0.5:
        load["duration"] = length
    if shape == "sine":
        load["frequency"] = int(rng.integers(1, 12)) / (2 * length) if "duration" in load else 10 ** float_in(rng, 1, 4)
    return load


def judge(run, scene: dict, modes: int) -> Iterator[Judged]:
    """Compare the run of so many modes with one of far more; `run` makes a dataset of a scene."""
    modes = min(modes, 24) if "hub" in scene else modes  # Galerkin's method has few hundreds
    more = 8 * modes if "hub" in scene or "from" in scene.get("body", {}) else max(512, 8 * modes)
    few = run({**scene, "modes": {"before": modes, "after": modes}})
    many = run({**scene, "modes": {"before": more, "after": more}})
    for quantity in (q for q in QUANTITIES if q in few):
        peak = float(np.abs(many[quantity]).max())
        errors = np.abs(few[quantity] - many[quantity]).max("time").values
        for p, error in enumerate(errors):
            known = float(many[f"{quantity}_error"][p]) <= 0.3 * error  # the many are near enough to the truth
            if not (NOISE * peak < error < TOLD * peak and known):
                continue
            bounded = quantity == "displacement" and "displacement_bound" in few
            bound = float(few["displacement_bound"][p]) / error if bounded else np.inf
            yield Judged(quantity, modes, error / peak, float(few[f"{quantity}_error"][p]) / error, bound)
