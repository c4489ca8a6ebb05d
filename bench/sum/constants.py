"""The constants of the cost model in src/response/sums/bw_sum_choice.f90, measured, and how well the model chooses.

    PYTHONPATH=bench OMP_NUM_THREADS=1 python -m sum.constants [--beamwave PROGRAM] [--check]

Prints the lines of the source that hold the constants, fitted to the relative error over sums of many sizes, warm and alone
in turn; then, of other sizes, how much longer the way that the built program chooses takes than the faster of the two.
"""

from __future__ import annotations

import argparse
import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import nnls

from common.bench import PROGRAM

from .bench import Call, seconds
from .library import Beamwave

VECTOR = 8  # grid points whose weights are made together
ENOUGH = 3e-3  # seconds of one way, in as many runs as that takes
LONGEST = 0.25  # seconds that one sum of the fit or the check may take by the model's older constants
FIT = ((4, 32, 256, 2048, 16384), (64, 1024, 16384, 131072), (1, 2, 6, 40))
CHECK = ((2, 8, 20, 50, 120, 300, 1000, 5000), (50, 300, 2000, 10000, 65536), (1, 2, 6, 40))

PRODUCTS = {
    "product_set_up": "a call",
    "product_mode": "a mode",
    "product_turn": "an entry of the tables of turns, each for a mode",
    "product_entry": "an entry of these tables, read for all histories of a block",
    "product_state": "a mode's state at a block of a history",
    "product_term": "a mode at a sample of a history",
    "product_sample": "a sample of a history",
}
TRANSFORM = {
    "set_up": "kernel and plan",
    "mode_phase": "place and phase of a mode",
    "mode_weight": "a vector of weights",
    "mode_spread": "a vector of weights put to use, for each history",
    "grid_point": "a point of the grid and step of the fast transform, for each history",
    "sample": "a sample made and added, for each history",
    "factor": "the kernel's factor of a sample",
}


def cost(call: Call) -> float:
    """The median of a few turns of processor time."""
    first = seconds(call)
    turns = max(3, min(31, int(ENOUGH / max(first, 1e-6))))
    return float(np.median([seconds(call) for _ in range(turns)]))


def product_steps(n: int, samples: int, points: int) -> list[float]:
    """What the constants of PRODUCTS are multiplied with."""
    length = 2 ** min(8, max(3, round(0.5 * math.log2(samples))))
    blocks = -(-samples // length)
    return [1, n, n * (length + blocks), n * length * blocks, n * blocks * points, n * length * blocks * points, samples * points]


def transform_steps(n: int, samples: int, points: int, width: int, half: int) -> list[float]:
    """What the constants of TRANSFORM are multiplied with."""
    vectors = -(-width // VECTOR)
    grid = 2 * half
    steps = [1, n, n * vectors, n * vectors * points, points * grid * math.log2(grid), points * samples, samples]
    return [float(step) for step in steps]


def terms(n: int, points: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Modes like those of a beam."""
    beta = np.zeros((n, 2))
    beta[:, 0] = ((np.arange(n) + 0.8) * np.pi) ** 2
    return beta, 1 / (1 + np.arange(n)), np.cos(np.outer(np.arange(points) + 1.0, np.arange(n)))


def sums(beamwave: Beamwave, sizes: tuple[tuple, ...]) -> list[dict[str, Any]]:
    """Both ways at all sizes that do not take too long."""
    rows = []
    for n, samples, points in itertools.product(*sizes):
        if n * samples * points * 1e-9 > LONGEST or samples * points > 2**20:
            continue
        chosen, width, half = beamwave.choice(n, samples, points)
        known = terms(n, points)
        products = cost(lambda: beamwave.by_products(samples, known))
        transform = cost(lambda: beamwave.by_transform(samples, known, width, half))
        size = (n, samples, points)
        rows.append({"size": size, "kernel": (width, half), "chosen": chosen, "products": products, "transform": transform})
    return rows


def fitted(names: dict[str, str], steps: list[list[float]], costs: list[float]) -> dict[str, float]:
    """Constants ≥ 0 of the least squares of relative errors."""
    weights = 1 / np.array(costs)
    found, _ = nnls(np.array(steps) * weights[:, None], np.ones(len(costs)))
    return dict(zip(names, found))


def source(constants: dict[str, float], names: dict[str, str]) -> str:
    """As Fortran."""
    lines = []
    for name, value in constants.items():
        power = 3 * math.floor(math.log10(value) / 3) if value else 0
        text = f"real(dp), parameter :: {name} = {value / 10.0**power:.3g}e{power}_dp"
        lines.append(f"  {text:<52} ! {names[name]}")
    return "\n".join(lines)


def worst(rows: list[dict[str, Any]]) -> str:
    """How the built program chose."""
    over = []
    for row in rows:
        took = row["transform" if row["chosen"] else "products"]
        over.append((took / min(row["transform"], row["products"]), row))
    over.sort(key=lambda pair: -pair[0])
    lines = [f"{len(over)} sums; the chosen way took at most {over[0][0]:.2f} times the faster one's time, "
             f"{over[len(over) // 50][0]:.2f} times in all but 2 of 100. The farthest:"]  # fmt: skip
    for ratio, row in over[:8]:
        ways = ", ".join(f"{way} {1e3 * row[way]:.3g} ms" for way in ("products", "transform"))
        lines.append(f"  {ratio:.2f}: modes, samples, points {row['size']}: {ways}")
    return "\n".join(lines)


def main() -> None:
    words = argparse.ArgumentParser(prog="python -m sum.constants", description=__doc__.splitlines()[0])
    words.add_argument("--beamwave", type=Path, default=PROGRAM, help="the program")
    words.add_argument("--check", action="store_true", help="only say how the built program chooses")
    given = words.parse_args()
    beamwave = Beamwave(given.beamwave.resolve().parents[1])
    if not given.check:
        rows = sums(beamwave, FIT)
        products = fitted(PRODUCTS, [product_steps(*row["size"]) for row in rows], [row["products"] for row in rows])
        steps = [transform_steps(*row["size"], *row["kernel"]) for row in rows]
        transform = fitted(TRANSFORM, steps, [row["transform"] for row in rows])
        print(source(products, PRODUCTS) + "\n" + source(transform, TRANSFORM), flush=True)
        for name, made, known in (("products", products, product_steps), ("transform", transform, transform_steps)):
            ratios = []
            for row in rows:
                size = (*row["size"], *row["kernel"]) if name == "transform" else row["size"]
                ratios.append(np.dot(list(made.values()), known(*size)) / row[name])
            print(f"{name}: the model says {min(ratios):.2f} to {max(ratios):.2f} of what was measured", flush=True)
    print(worst(sums(beamwave, CHECK)))


if __name__ == "__main__":
    main()
