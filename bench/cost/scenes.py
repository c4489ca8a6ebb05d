"""Random scenes of every kind, from milliseconds to some seconds of work."""

from __future__ import annotations

from typing import Any, Iterator

import common  # noqa: F401 (finds tests/scenes)
import numpy as np
from workplace import PAPER_BEAM, group_text

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

    def beam(self, pieces: int = 1) -> dict[str, Any]:
        if pieces == 1:
            return dict(PAPER_BEAM)
        return {**PAPER_BEAM, "length": [1.0 / pieces] * pieces, "diameter": self.rng.uniform(0.02, 0.04, pieces).tolist()}

    def response(self, most: float = 1e6) -> Groups:
        points = 2 if self.chance() else self.size(1, 12)
        record = {
            "duration": float(10.0 ** self.rng.uniform(-2, 0.5)),
            "samples": self.size(100, most),
            "points": [0.5, 1.0] if points == 2 else np.linspace(0.1, 1.0, points).tolist(),
            "velocity": self.chance(0.3),
            "bending_moment": self.chance(0.2),
        }
        return [("response", record)]

    def counts(self, first: float, last: float) -> Groups:
        return [("modes", {"before": self.size(first, last), "after": self.size(first, last)})]

    def tolerance(self, finest: float) -> Groups:
        return [("modes", {"tolerance": float(10.0 ** self.rng.uniform(np.log10(finest), -2))})]

    def turning(self) -> Groups:
        return [("rotation", {"angular_velocity": float(self.rng.uniform(0, 100))})] if self.chance() else []

    def captured(self, pieces: int = 1) -> Groups:
        return [("beam", self.beam(pieces)), ("impact", {"mass_ratio": float(self.rng.uniform(0.02, 1))}), ("capture", {})]


TENSION: Groups = [("rotation", {"angular_velocity": 50.0}), ("stiffening", {})]
SHEAR: Groups = [("shear", {})]


def frequencies(dice: Dice) -> Groups:
    return [*dice.captured(), *dice.turning(), *dice.counts(10, 1e6)]


def counted(dice: Dice) -> Groups:
    return [*dice.captured(), *dice.turning(), *dice.counts(10, 1e5), *dice.response(4e6)]


def tolerated(dice: Dice) -> Groups:
    return [*dice.captured(), *dice.turning(), *dice.tolerance(1e-12), *dice.response(4e6)]


def damped(dice: Dice) -> Groups:
    modes = dice.tolerance(1e-7) if dice.chance() else dice.counts(10, 1e4)
    return [*dice.captured(), ("damping", {"ratio": 0.01}), *modes, *dice.response(1e5)]


def with_shear(dice: Dice) -> Groups:
    modes = dice.tolerance(1e-5) if dice.chance() else dice.counts(10, 1e4)
    return [*dice.captured(), *SHEAR, *modes, *dice.response(1e5)]


def of_pieces(dice: Dice) -> Groups:
    modes = dice.tolerance(1e-7) if dice.chance() else dice.counts(10, 1e3)
    return [*dice.captured(dice.size(2, 100)), *modes, *dice.response(1e5)]


def under_tension(dice: Dice) -> Groups:
    modes = dice.tolerance(1e-5) if dice.chance() else dice.counts(10, 500)
    pieces = dice.size(2, 30) if dice.chance(0.4) else 1
    return [*dice.captured(pieces), *TENSION, *(SHEAR if dice.chance(0.3) else []), *modes, *dice.response(1e5)]


def released(dice: Dice) -> Groups:
    modes = dice.tolerance(1e-6) if dice.chance() else dice.counts(10, 1e3)
    record = dice.response(1e5)
    release = [("release", {"time": float(record[0][1]["duration"] * dice.rng.uniform(0.1, 0.9))})]
    kind = [[], [], TENSION, SHEAR][dice.rng.integers(4)]
    return [*dice.captured(), *kind, *modes, *record, *release]


def struck_again(dice: Dice) -> Groups:
    blow = {"mass_ratio": float(dice.rng.uniform(0.05, 1)), "restitution": float(dice.rng.choice([0.0, 0.5, 0.9]))}
    modes = [("modes", {"before": dice.size(5, 200)})]
    return [("beam", dice.beam()), ("impact", blow), *dice.turning(), *modes, *dice.response(1e5), ("recontact", {})]


def rebound(dice: Dice) -> Groups:
    modes = [("modes", {"before": dice.size(10, 1e4)})]
    return [("beam", dice.beam()), ("impact", {"mass_ratio": 0.2, "restitution": 0.5}), *modes, *dice.response()]


def waves(dice: Dice) -> Groups:
    modes = dice.tolerance(1e-7) if dice.chance() else dice.counts(5, 200)
    record = dice.response(3e5)
    record[0][1]["points"] = [0.5, 1.0]
    return [*dice.captured(), *modes, *record, ("spectrum", {})]


def spectra(dice: Dice) -> Groups:
    """Amplitudes alone: of places where no waves are measured."""
    record = dice.response(1e4)
    record[0][1]["points"] = [0.4, 0.9]
    sweep = {"parameter": "impact%mass_ratio", "first": 0.1, "last": 1.0, "count": dice.size(10, 1000)}
    return [*dice.captured(), *dice.counts(5, 100), *record, ("spectrum", {}), ("sweep", sweep)]


def swept(dice: Dice) -> Groups:
    few = [*dice.captured(), ("rotation", {"angular_velocity": 0.0}), *dice.counts(5, 100)]
    if dice.chance(0.6):
        few = [group for group in few if group[0] != "modes"]
        few += [*(dice.tolerance(1e-6) if dice.chance(0.3) else dice.counts(5, 100)), *dice.response(1e4)]
    if dice.chance(0.3):
        few += SHEAR
    if dice.chance(0.2):
        few += [("stiffening", {})]
    ranges = [("impact%mass_ratio", 0.1, 1.0), ("rotation%angular_velocity", 0.0, 60.0), ("beam%diameter", 0.03, 0.05)]
    name, first, last = ranges[dice.rng.integers(3)]
    return [*few, ("sweep", {"parameter": name, "first": first, "last": last, "count": dice.size(10, 3000)})]


KINDS = (
    frequencies, counted, tolerated, damped, with_shear, of_pieces, under_tension,
    released, struck_again, rebound, waves, spectra, swept,
)


def drawn(seed: int, draws: int) -> Iterator[tuple[str, str]]:
    """Names and namelists of so many scenes of each kind."""
    for k, draw in enumerate(KINDS):
        for n in range(draws):
            yield f"{draw.__name__}_{n}", "".join(group_text(*group) for group in dict(draw(Dice(seed, k, n))).items())
