"""Random scenes of every kind, from milliseconds to some seconds of work."""

from __future__ import annotations

from typing import Any, Callable, Iterator

import common  # noqa: F401 (finds tests/scenes)
import contact_scenes
import load_scenes
import numpy as np
from workplace import PAPER_BEAM, group_text

from common.bench import PROJECT

Groups = list[tuple[str, dict[str, Any]]]


class Dice:
    """Random inputs of one scene."""

    def __init__(self, *seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def size(self, first: float, last: float) -> int:
        """A whole number, evenly spread over its logarithm."""
        return round(float(np.exp(self.rng.uniform(np.log(first), np.log(last)))))

    def chance(self, part: float = 0.5) -> bool:
        return bool(self.rng.random() < part)

    def beam(self, pieces: int = 1) -> Groups:
        if pieces == 1:
            return [("beam", dict(PAPER_BEAM))]
        diameters = self.rng.uniform(0.02, 0.04, pieces).tolist()
        return [("beam", {**PAPER_BEAM, "length": [1.0 / pieces] * pieces, "diameter": diameters})]

    def response(self, most: float = 1e5, points: list[float] | None = None) -> Groups:
        points = points or ([0.5, 1.0] if self.chance() else np.linspace(0.1, 1.0, self.size(1, 12)).tolist())
        record = {"duration": float(10.0 ** self.rng.uniform(-2, 0.5)), "samples": self.size(100, most), "points": points}
        return [("response", {**record, "velocity": self.chance(0.3), "bending_moment": self.chance(0.2)})]

    def counts(self, first: float, last: float) -> Groups:
        return [("modes", {"before": self.size(first, last), "after": self.size(first, last)})]

    def tolerance(self, finest: float) -> Groups:
        return [("modes", {"tolerance": float(10.0 ** self.rng.uniform(np.log10(finest), -2))})]

    def modes(self, finest: float, most: float) -> Groups:
        """A tolerance or counts."""
        return self.tolerance(finest) if self.chance() else self.counts(10, most)

    def turning(self) -> Groups:
        return [("rotation", {"angular_velocity": float(self.rng.uniform(0, 100))})] if self.chance() else []

    def captured(self, pieces: int = 1) -> Groups:
        return [*self.beam(pieces), ("impact", {"mass_ratio": float(self.rng.uniform(0.02, 1))}), ("capture", {})]

    def struck(self, restitution: float, most: float) -> Groups:
        """A rebound, which has counts alone."""
        blow = {"mass_ratio": float(self.rng.uniform(0.05, 1)), "restitution": restitution}
        return [*self.beam(), ("impact", blow), *self.turning(), ("modes", {"before": self.size(5, most)})]


TENSION: Groups = [("rotation", {"angular_velocity": 50.0}), ("stiffening", {})]
SHEAR: Groups = [("shear", {})]
RANGES = (("impact%mass_ratio", 0.1, 1.0), ("rotation%angular_velocity", 0.0, 60.0), ("beam%diameter", 0.03, 0.05))


def under_tension(dice: Dice) -> Groups:
    pieces = dice.size(2, 30) if dice.chance(0.4) else 1
    return [*dice.captured(pieces), *TENSION, *(SHEAR if dice.chance(0.3) else []), *dice.modes(1e-5, 500), *dice.response()]


def released(dice: Dice) -> Groups:
    record = dice.response()
    release = [("release", {"time": float(record[0][1]["duration"] * dice.rng.uniform(0.1, 0.9))})]
    return [*dice.captured(), *[[], [], TENSION, SHEAR][dice.rng.integers(4)], *dice.modes(1e-6, 1e3), *record, *release]


def swept(dice: Dice, range_of: tuple[str, float, float], most: float) -> Groups:
    name, first, last = range_of
    return [("sweep", {"parameter": name, "first": first, "last": last, "count": dice.size(10, most)})]


def sweeps(dice: Dice) -> Groups:
    histories = dice.chance(0.6)
    modes = dice.tolerance(1e-6) if histories and dice.chance(0.3) else dice.counts(5, 100)
    effects = [*(SHEAR if dice.chance(0.3) else []), *([("stiffening", {})] if dice.chance(0.2) else [])]
    few = [*dice.captured(), ("rotation", {"angular_velocity": 0.0}), *modes, *(dice.response(1e4) if histories else []), *effects]
    return [*few, *swept(dice, RANGES[dice.rng.integers(3)], 3000)]


def loaded(dice: Dice) -> Groups:
    scene = load_scenes.draw(dice.rng, str(dice.rng.choice(["force", "base", "hub", "hub_base", "change"])))
    return [*scene.items(), *dice.modes(1e-5, 300)]


def in_contact(dice: Dice) -> Groups:
    kind = str(dice.rng.choice(["blow", "initial", "captures", "loads", "changes"]))
    scene = contact_scenes.draw(dice.rng) if kind == "blow" else contact_scenes.draw_moving(dice.rng, kind)
    if dice.chance() and "damping" not in scene["contact"]:
        scene["modes"] = {"tolerance": 1e-4}
    return list(scene.items())


KINDS: dict[str, Callable[[Dice], Groups]] = {
    "frequencies": lambda dice: [*dice.captured(), *dice.turning(), *dice.counts(10, 1e6)],
    "counted": lambda dice: [*dice.captured(), *dice.turning(), *dice.counts(10, 1e5), *dice.response(4e6)],
    "tolerated": lambda dice: [*dice.captured(), *dice.turning(), *dice.tolerance(1e-12), *dice.response(4e6)],
    "damped": lambda dice: [*dice.captured(), ("damping", {"ratio": 0.01}), *dice.modes(1e-7, 1e4), *dice.response()],
    "shear": lambda dice: [*dice.captured(), *SHEAR, *dice.modes(1e-5, 1e4), *dice.response()],
    "pieces": lambda dice: [*dice.captured(dice.size(2, 100)), *dice.modes(1e-7, 1e3), *dice.response()],
    "tension": under_tension,
    "released": released,
    "struck_again": lambda dice: [*dice.struck(float(dice.rng.choice([0.0, 0.5, 0.9])), 200), *dice.response(), ("recontact", {})],
    "rebound": lambda dice: [*dice.struck(0.5, 1e4), *dice.response(1e6)],
    "waves": lambda dice: [*dice.captured(), *dice.modes(1e-7, 200), *dice.response(3e5, [0.5, 1.0]), ("spectrum", {})],
    "spectra": lambda dice: [  # amplitudes alone: of places where no waves are measured
        *dice.captured(), *dice.counts(5, 100), *dice.response(1e4, [0.4, 0.9]), ("spectrum", {}), *swept(dice, RANGES[0], 1000)],
    "sweeps": sweeps,
    "loaded": loaded,
    "in_contact": in_contact,
}  # fmt: skip


def drawn(seed: int, draws: int) -> Iterator[tuple[str, str]]:
    """Names and namelists of so many scenes of each kind, and of all of input/ but records."""
    for k, (name, draw) in enumerate(KINDS.items()):
        for n in range(draws):
            yield f"{name}_{n}", "".join(group_text(*group) for group in draw(Dice(seed, k, n)))
    for scene in sorted((PROJECT / "input").rglob("*.nml")):
        text = scene.read_text()
        if "&record" not in text:
            yield scene.stem, text
