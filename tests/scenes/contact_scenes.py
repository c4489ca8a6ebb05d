"""Random scenes of contacts of a finite duration, and how their errors compare with what is said of them."""

from __future__ import annotations

from typing import Iterator, NamedTuple

import contact_reference
import numpy as np
from load_scenes import NOISE, TOLD, float_in
from workplace import PAPER_BEAM

HISTORIES = ("displacement", "velocity", "bending_moment")
SAMPLES = 200
MOST_CONTACTS = 50
FEW = 5  # contacts, which hardly amplify an error


class Judged(NamedTuple):
    """What a run gives beside what is true."""

    quantity: str
    contacts: int  # up to there
    part: float  # error over the peak; of times over that of the first contact
    estimate: float  # given, over the error


def draw(rng: np.random.Generator) -> dict:
    """A scene with a count of modes; one in eight has a contact that damps, and few modes, since its force is stiff."""
    beam = dict(PAPER_BEAM)
    heavy = beam["density"] * np.pi * beam["diameter"] ** 2 / 4 * beam["length"]
    ratio = 10 ** float_in(rng, -1.5, 0.7)
    speed = float(rng.choice([-1, 1])) * 10 ** float_in(rng, -1, 1)
    exponent = float(rng.choice([1.0, 1.5, round(float_in(rng, 1, 3), 3)]))
    time = 10 ** float_in(rng, -4.7, -2.7)  # that a contact with a wall takes, s, or nearly
    deep = abs(speed) * time / 3
    contact = {"stiffness": float((exponent + 1) / 2 * ratio * heavy * speed**2 / deep ** (exponent + 1)), "exponent": exponent}
    damped = rng.random() < 0.125
    if damped:
        contact["damping"] = 10 ** float_in(rng, -1.5, -0.3) / abs(speed)
    contact["max_contacts"] = MOST_CONTACTS
    scene = {
        "beam": beam,
        "impact": {"mass_ratio": ratio, "approach_velocity": speed, "position": 1.0 if rng.random() < 0.5 else round(float_in(rng, 0.3, 0.95), 4)},
        "contact": contact,
        "modes": {"before": int(rng.integers(6, 13) if damped else rng.integers(16, 61))},
    }
    if rng.random() < 0.5:
        scene["rotation"] = {"angular_velocity": float_in(rng, 10, 250), "plane": str(rng.choice(["in", "out"]))}
    if rng.random() < 0.3:
        scene["damping"] = {"ratio": 10 ** float_in(rng, -3, -1)}
    duration = min(0.03, time * 10 ** float_in(rng, 0.2, 0.8 if damped else 2.5))
    scene["response"] = {"duration": duration, "samples": SAMPLES, "points": [0.0, 0.4, 1.0], "velocity": True, "bending_moment": True}
    return scene


SLOPE = 336.0  # N s/m: a force at the tip of the paper's beam over the speed of its first mode after it is let go


def draw_moving(rng: np.random.Generator, kind: str) -> dict:
    """Such a scene, of a beam that is let go from a deflection ('initial'), that captures the mass ('captures'), or that forces and motions of
    its base move ('loads'), while a body comes or leaves, or the mass is captured and released ('changes').
    """
    scene = draw(rng)
    speed = abs(scene["impact"]["approach_velocity"])
    if kind == "captures":
        scene["capture"] = {"rotary_inertia": 10 ** float_in(rng, -4, -2)} if rng.random() < 0.5 else {}
        if rng.random() < 0.35:
            scene["damping"] = {"stiffness_proportional": 10 ** float_in(rng, -8, -5)}
        if rng.random() < 0.3:
            scene["release"] = {"time": scene["response"]["duration"] * float_in(rng, 0.2, 0.9)}
        return scene
    if kind == "initial":
        scene["rotation"] = {"angular_velocity": float_in(rng, 10, 100), "plane": str(rng.choice(["in", "out"]))}
        force = float(rng.choice([-1, 1])) * SLOPE * speed * 10 ** float_in(rng, -1, 0.5)
        scene["initial"] = {"force": force, "position": 1.0 if rng.random() < 0.5 else round(float_in(rng, 0.3, 0.95), 4)}
        return scene
    duration = scene["response"]["duration"]
    for group in ("force", "base"):
        if rng.random() < 0.65 or (group == "base" and "force" not in scene):
            unit = SLOPE if group == "force" else 164.0
            load = {"shape": str(rng.choice(["half_sine", "haversine", "triangle", "rectangle", "sine"]))}
            load["amplitude"] = float(rng.choice([-1, 1])) * unit * speed * 10 ** float_in(rng, -1, 0.7)
            load["start"] = 0.0 if rng.random() < 0.3 else duration * float_in(rng, 0, 0.5)
            load["duration"] = duration * float_in(rng, 0.05, 0.7)
            if load["shape"] == "sine":
                load["frequency"] = 10 ** float_in(rng, -0.5, 1) / load["duration"]
            if group == "force":
                load["position"] = 1.0 if rng.random() < 0.5 else round(float_in(rng, 0.3, 0.95), 4)
            scene[group] = load
    if kind == "changes":
        if rng.random() < 0.3:
            scene |= {"capture": {}, "release": {"time": duration * float_in(rng, 0.3, 0.9)}}
        else:
            body = {"position": round(float_in(rng, 0.3, 1.0), 4), "mass_ratio": 10 ** float_in(rng, -2, 0)}
            body[str(rng.choice(["from", "until"]))] = duration * float_in(rng, 0.02, 0.8)
            scene["body"] = body
    return scene


def load_of(load: dict, sign: float, heavy: float | None) -> contact_reference.Load:
    """A force, or with a mass of the beam a motion of the base."""
    size, start, long = sign * load["amplitude"] * (-heavy if heavy else 1.0), load["start"], load["duration"]
    half, end = start + long / 2, start + long
    piece = contact_reference.Piece
    pieces = {
        "half_sine": [piece(start, end, 0, 0, -1j * size, np.pi / long)],
        "haversine": [piece(start, end, size / 2, 0, -size / 2, 2 * np.pi / long)],
        "triangle": [piece(start, half, 0, 2 * size / long, 0, 0), piece(half, end, size, -2 * size / long, 0, 0)],
        "rectangle": [piece(start, end, size, 0, 0, 0)],
        "sine": [piece(start, end, 0, 0, -1j * size, 2 * np.pi * load.get("frequency", 0.0))],
    }
    return contact_reference.Load(None if heavy else load["position"], pieces[load["shape"]])


def blow_of(scene: dict) -> contact_reference.Blow:
    """The same scene for the reference, from positive sides."""
    beam, impact, contact, response = scene["beam"], scene["impact"], scene["contact"], scene["response"]
    rotation = scene.get("rotation", {"angular_velocity": 0.0, "plane": "in"})
    rho = beam["density"] * np.pi * beam["diameter"] ** 2 / 4
    sign = float(np.sign(impact["approach_velocity"]) or 1.0)
    return contact_reference.Blow(
        length=beam["length"],
        mass_per_length=rho,
        bending_stiffness=beam["youngs_modulus"] * np.pi * beam["diameter"] ** 4 / 64,
        modes=scene["modes"]["before"],
        mass=impact["mass_ratio"] * rho * beam["length"],
        position=impact["position"],
        speed=abs(impact["approach_velocity"]),
        stiffness=contact["stiffness"],
        exponent=contact["exponent"],
        contact_damping=contact.get("damping", 0.0),
        ratio=scene.get("damping", {"ratio": 0.0})["ratio"],
        omega=rotation["angular_velocity"],
        in_plane=rotation["plane"] == "in",
        points=response["points"],
        times=np.arange(response["samples"]) * (response["duration"] / response["samples"]),
        duration=response["duration"],
        most_contacts=contact["max_contacts"],
        pulled=(sign * scene["initial"]["force"], scene["initial"]["position"]) if "initial" in scene else None,
        loads=[load_of(scene[group], sign, None if group == "force" else rho * beam["length"]) for group in ("force", "base") if group in scene],
    )


def judge(run, scene: dict) -> Iterator[Judged]:
    """Compare a run with the reference of as many modes; `run` makes a dataset of a scene."""
    found, true = run(scene), contact_reference.follow(blow_of(scene))
    sign = np.sign(scene["impact"]["approach_velocity"]) or 1.0
    events = found.isel(event=(found["event_kind"] > 0).values)
    count, both = events.sizes["event"], min(events.sizes["event"], len(true.start))
    yield Judged("contacts", both, abs(len(true.start) - count), np.inf)
    unit, strongest, blow = true.end[0] if true.end else 1.0, max(true.largest, default=1.0), max(true.impulse, default=1.0)
    for i in range(both):
        for name, value in (("event_time", true.start[i]), ("event_end", true.end[i])):
            yield judged(name, i + 1, abs(float(events[name][i]) - value), float(events[f"{name}_error"][i]), unit)
        error = abs(float(events["event_force"][i]) * sign - true.largest[i])
        yield judged("event_force", i + 1, error, float(events["contact_force_error"][i]), strongest)
        yield Judged("event_impulse", i + 1, abs(float(events["event_impulse"][i]) * sign - true.impulse[i]) / blow, np.inf)
    for name in HISTORIES:
        known = np.array(getattr(true, name)).T * sign
        history = found[name].values[:, : known.shape[1]]
        there = np.isfinite(history + known).all(axis=0)
        there[0] = False  # at the first instant the force may jump to a slope
        for p, row in enumerate(np.abs(history - known)[:, there]):
            yield judged(name, len(true.start), row.max(), float(found[f"{name}_error"][p]), np.nanmax(np.abs(known)))


def judge_estimates(run, scene: dict) -> Iterator[Judged]:
    """Compare the histories of a run with those of eight times as many modes, which are near enough to the truth where they say so."""
    few, many = run(scene), run({**scene, "modes": {"before": 8 * scene["modes"]["before"]}})
    contacts = int((many["event_kind"] > 0).sum())
    for name in HISTORIES:
        peak = float(np.abs(many[name]).max())
        for p, error in enumerate(np.abs(few[name] - many[name]).max("time").values):
            if NOISE * peak < error < TOLD * peak and float(many[f"{name}_error"][p]) <= 0.3 * error:
                yield judged(name, contacts, error, float(few[f"{name}_error"][p]), peak)


def judged(name: str, contacts: int, error: float, given: float, peak: float) -> Judged:
    """An error that is not given, of a contact that half of the modes do not show, promises nothing."""
    return Judged(name, contacts, error / peak, given / error if error > NOISE * peak and np.isfinite(given) else np.inf)
