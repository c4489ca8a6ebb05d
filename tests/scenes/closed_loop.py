"""Random beams are struck, their histories get noise, and the beams are identified from these.

By hand: `python tests/scenes/closed_loop.py --beams 200` prints how many of the true numbers are inside their intervals, and which
of those that the information matrix calls not fixed are named so.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np
from results import is_fill
from workplace import Workplace, namelist

LEVELS = [60, 40, 20]  # dB: signal over noise, root mean squares of the first sensor
DURATION, SAMPLES = 1.0, 4096
ROUND = {"length": 1.0, "density": 7870.0, "youngs_modulus": 2e11, "diameter": 0.037}
STEPPED = {**ROUND, "length": [0.4, 0.3, 0.3], "diameter": [0.037, 0.032, 0.028]}
MODULUS, LENGTH, ROOT = "beam%youngs_modulus", "beam%length", "support%rotational_stiffness"
MASS, PLACE = "body%mass", "body%position"
RANGES = {  # of each unknown: first, last, and whether its logarithm is drawn
    MODULUS: (1.5e11, 2.5e11, False),
    LENGTH: (0.95, 1.05, False),
    ROOT: (1e4, 1e7, True),
    MASS: (0.05, 4.0, True),
    PLACE: (0.55, 0.98, False),
}
KINDS = [  # beam, unknowns, place of a body that is known, largest speed, whether tension stiffens
    (ROUND, [MODULUS, ROOT], 0.8, 30, False),
    (ROUND, [MASS, PLACE], 0.8, 30, False),
    (STEPPED, [MODULUS, ROOT, MASS], 0.8, 30, False),
    (STEPPED, [MODULUS, ROOT, MASS], 0.8, 60, True),
    (ROUND, [MODULUS, ROOT, MASS], 1.0, 30, False),  # a root that turns has about the frequencies of a mass at the tip
    (ROUND, [MODULUS, LENGTH], 0.8, 30, False),  # √E/l² alone, but for what rotation adds to β²
]
ROUND_OF_KINDS = len(KINDS) * len(LEVELS)
HARDLY = 0.25  # of its range, from which the interval of an unknown counts as not fixed
QUANTILE = 1.959963984540054
STEP = 1e-4  # of half the range: derivatives are central differences


def with_values(beam, values, place):
    """The groups of a beam with these numbers; a body whose place is not looked for stands at `place`."""
    groups = {"beam": dict(beam)}
    for name, value in values.items():
        group, key = name.split("%")
        groups.setdefault(group, {})[key] = value
    if "body" in groups:
        groups["body"].setdefault("position", place)
    return groups


def drawn(dice, kind):
    """The true numbers, the struck beam, and what is known of it."""
    beam, unknowns, place, speed, tension = kind
    true = {name: at(name, dice.uniform(-0.8, 0.8)) for name in unknowns}
    same = {"rotation": {"angular_velocity": float(dice.uniform(0, speed))}, **({"stiffening": {}} if tension else {})}
    struck = {
        **with_values(beam, true, place),
        **same,
        "damping": {"ratio": float(10 ** dice.uniform(-3.3, -2.3))},
        "impact": {"mass": 0.05, "position": float(dice.uniform(0.85, 1.0)), "restitution": 0.5},
        "modes": {"before": 5},
        "response": {"duration": DURATION, "samples": SAMPLES, "points": [1.0, 0.47], "velocity": True},
    }
    return true, struck, {**with_values(beam, dict.fromkeys(unknowns), place), **same}


def at(name, v):
    """The value at the place v = -1 ... 1 of the range of an unknown."""
    first, last, logarithmic = RANGES[name]
    way = 0.5 + 0.5 * v
    return float(first * (last / first) ** way if logarithmic else first + (last - first) * way)


def place_of(name, value):
    """The place of a value in its range."""
    first, last, logarithmic = RANGES[name]
    return 2 * (np.log(value / first) / np.log(last / first) if logarithmic else (value - first) / (last - first)) - 1


def without_values(groups, unknowns):
    """The groups as a person has them who does not know these numbers."""
    return {name: {key: value for key, value in group.items() if f"{name}%{key}" not in unknowns} for name, group in groups.items()}


def as_record(result, level, dice):
    """The velocities in noise, as text."""
    noise = np.sqrt((result["velocity"][0] ** 2).mean()) * 10 ** (-level / 20)
    values = result["velocity"] + noise * dice.standard_normal(result["velocity"].shape)
    rows = (",".join([repr(float(t)), *(f"{value:.9e}" for value in row)]) for t, row in zip(result["time"], values.T))
    return "\n".join(["time [s],tip [m/s],middle [m/s]", *rows]) + "\n"


def identify(here, count, seed):
    """Strike and identify beams; for each its level, kind, true numbers and result. Those that cannot be simulated are left out."""
    dice = np.random.default_rng(seed)
    beams = []
    for number in range(count):
        kind = number % len(KINDS)
        true, struck, known = drawn(dice, KINDS[kind])
        here.write(f"struck/s{number}.nml", namelist(struck))
        beams.append({"level": LEVELS[number // len(KINDS) % len(LEVELS)], "kind": kind, "true": true, "known": known, "number": number})
    run(here, "struck")
    beams = [beam for beam in beams if here.result(f"s{beam['number']}")["case_status"] == 0]
    for beam in beams:
        number, true = beam["number"], beam["true"]
        here.write(f"found/s{number}.csv", as_record(here.result(f"s{number}"), beam["level"], dice))
        groups = {**without_values(beam["known"], true), "record": {"file": f"s{number}.csv"}, "spectrum": {}}
        text = "".join(namelist({"identify": {"parameter": name, "first": RANGES[name][0], "last": RANGES[name][1]}}) for name in true)
        here.write(f"found/i{number}.nml", namelist(groups) + text)
    run(here, "found")
    for beam in beams:
        beam["result"] = here.result(f"i{beam['number']}")
    return beams


def run(here, *paths):
    """Run scenes, or those of a directory; of some, numbers may not be trusted."""
    ended = here.beamwave("run", *paths, "--quiet", timeout=10000)
    assert ended.returncode in (0, 4), ended.stderr


def is_inside(beam):
    """Which of the true numbers are inside their intervals, which are open where a number is at the end of its range."""
    values = np.array(list(beam["true"].values()))
    low, high = beam["result"]["identified_low"], beam["result"]["identified_high"]
    return (is_fill(low) | (low <= values)) & (is_fill(high) | (values <= high))


def linear_widths(here, beams):
    """Widths of the intervals of each beam, over the ranges, as the information matrix has them: residuals taken for linear."""
    for beam in beams:
        number = beam["number"]
        v = {name: place_of(name, value) for name, value in zip(beam["true"], beam["result"]["identified"])}
        for name in v:
            for side, step in enumerate([-STEP, STEP]):
                values = {key: at(key, x + step * (key == name)) for key, x in v.items()}
                beam_there = with_values(KINDS[beam["kind"]][0], values, KINDS[beam["kind"]][2])
                groups = {**beam["known"], **beam_there, "modes": {"before": 12}}
                here.write(f"beside/d{number}_{list(v).index(name)}_{side}.nml", namelist(groups))
    run(here, "beside")
    widths = []
    for beam in beams:
        number, result = beam["number"], beam["result"]
        line = np.flatnonzero(result["peak_mode"][: result["peak_count"]] > 0)
        frequency = result["measured_angular_frequency"][line]
        deviation = np.hypot(result["measured_angular_frequency_error"][line] / QUANTILE, float(result["model_scatter"]) * frequency)
        mode = result["peak_mode"][line] - 1
        sides = [[here.result(f"d{number}_{i}_{side}")["angular_frequency"][mode] for side in (0, 1)] for i in range(len(beam["true"]))]
        slopes = np.array([(up - down) / (2 * STEP) / deviation for down, up in sides])
        covariance = np.linalg.inv(slopes @ slopes.T + np.eye(len(slopes)))  # 1: what the range itself says
        widths.append(QUANTILE * np.sqrt(np.diag(covariance)))
    return widths


def print_tables(here, beams):
    """How many are inside, by level; and what is named as not fixed beside what the information matrix says."""
    print("| signal over noise | beams | true numbers | inside intervals of 95 % | noise explains the misfit |")
    print("|---|---|---|---|---|")
    for level in [*LEVELS, None]:
        some = [beam for beam in beams if level in (None, beam["level"])]
        inside = np.concatenate([is_inside(beam) for beam in some])
        explained = np.mean([beam["result"]["misfit_probability"] > 1e-3 for beam in some])
        print(f"| {f'{level} dB' if level else 'all'} | {len(some)} | {inside.size} | {100 * inside.mean():.1f} % | {100 * explained:.1f} % |")
    counts, differing = np.zeros((2, 2), dtype=int), []
    for beam, wide in zip(beams, linear_widths(here, beams)):
        result = beam["result"]
        for i, name in enumerate(beam["true"]):
            named = f"not fixed: {name}" in str(result.attributes["notes"])
            counts[int(wide[i] >= HARDLY), int(named)] += 1
            if named != (wide[i] >= HARDLY):
                low, high = (place_of(name, result[f"identified_{end}"][i]) for end in ("low", "high"))
                differing.append(
                    f"beam {beam['number']}, {name}: {'' if named else 'not '}named; {50 * (high - low):.1f} % of its range, "
                    f"{100 * wide[i]:.1f} % by the information matrix"
                )
    for line in differing:
        print(line)
    print(f"\nNot fixed by the information matrix: {counts[1].sum()}, named {counts[1, 1]}; fixed by it: {counts[0].sum()}, named {counts[0, 1]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--beams", type=int, default=200)
    parser.add_argument("--seed", type=int, default=19)
    parser.add_argument("--program", default=str(Path(__file__).parents[2] / "build/bin/beamwave"))
    parser.add_argument("--directory", help="where scenes and results stay; else they are removed")
    words = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        place = Path(words.directory or directory).resolve()
        place.mkdir(parents=True, exist_ok=True)
        here = Workplace(Path(words.program).resolve(), place)
        print_tables(here, identify(here, words.beams, words.seed))


if __name__ == "__main__":
    sys.exit(main())
