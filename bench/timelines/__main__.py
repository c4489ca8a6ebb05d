"""Random scenes in which bodies and springs come and leave: how good are the estimates of their errors, and do histories, energies and momenta
agree with modal sums in 40 digits?

`PYTHONPATH=bench python -m timelines [--scenes 100] [--sums 100]` holds runs of 32, 64 and 128 modes
against those of 640, and runs of five modes against `tests/reference/make_timelines.py`, and prints what it found.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

import make_timelines
import numpy as np
from common.bench import PROGRAM
from test_timelines import QUANTITIES, estimates_over_errors, random_groups, text_of, unit_scene
from workplace import Workplace

COUNTS, FINEST = (32, 64, 128), 640


def run(here: Workplace, *groups: tuple) -> Any:
    """The result of a scene; None where the program ends otherwise than in order."""
    here.write("a.nml", text_of(*groups))
    ended = here.beamwave("run", "a.nml", "--quiet", "--overwrite")
    return here.result("a") if ended.returncode == 0 else None


def estimates(here: Workplace, scenes: range) -> None:
    """Estimates over errors."""
    found: dict[str, list] = {name: [] for name in QUANTITIES}
    refused = 0
    for seed in scenes:
        groups = random_groups(seed)
        finest = run(here, *groups, ("modes", {"before": FINEST, "after": FINEST}))
        for count in COUNTS:
            result = run(here, *groups, ("modes", {"before": count, "after": count}))
            if result is None or finest is None:
                refused += 1
                continue
            for name, ratio in estimates_over_errors(result, finest).items():
                found[name].append(ratio)
    print("| quantity | points | below 1 | lowest | median | 95 % |\n|---|---|---|---|---|---|")
    for name, parts in found.items() if scenes else ():
        ratio = np.concatenate(parts)
        print(f"| {name} | {ratio.size} | {(ratio < 1).sum()} | {ratio.min():.2f} | {np.median(ratio):.1f} | {np.quantile(ratio, 0.95):.0f} |")
    print(f"{refused} runs did not end in order.")


def sums(here: Workplace, seeds: range) -> None:
    """Distances from modal sums, over the largest value."""
    worst = {"displacement": 0.0, "velocity": 0.0, "energies": 0.0, "momentum": 0.0}
    events = 0
    for seed in seeds:
        case = make_timelines.reference(seed, 5)
        result = run(here, *unit_scene(case))
        if result is None:
            continue
        count = len(case["energies"])
        events += count
        energies = np.stack([result["energy_before"][:count], result["energy_after"][:count]], axis=1) if count else []
        momenta = [result[f"momentum_{when}"][:count] if count else np.zeros(1) for when in ("after", "before")]
        for name, one, other in [
            ("displacement", result["displacement"], case["displacement"]),
            ("velocity", result["velocity"], case["velocity"]),
            ("energies", energies, case["energies"]),
            ("momentum", *momenta),
        ]:
            one, other = np.array(one), np.array(other)
            if one.size and np.abs(other).max() > 0:
                worst[name] = max(worst[name], np.abs(one - other).max() / np.abs(other).max())
    print(f"{len(seeds)} timelines with {events} events: " + ", ".join(f"{name} {value:.1e}" for name, value in worst.items()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=100, help="whose estimates are looked at")
    parser.add_argument("--sums", type=int, default=100, help="timelines that are summed in 40 digits")
    parser.add_argument("--beamwave", type=Path, default=PROGRAM)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        here = Workplace(options.beamwave.resolve(), Path(directory))
        estimates(here, range(options.scenes))
        sums(here, range(1, 1 + options.sums))


if __name__ == "__main__":
    main()
