"""Instructions and seconds of the paper's scene with each effect added alone."""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
from beamwave_postproc.style import COLOURS, RC
from common.bench import Bench, Measured
from common.document import measured_with, table
from common.measuring import in_turns, median, run_scene, stage_seconds
from matplotlib.figure import Figure

ROUNDS = 11
METHODS = (None, "closed form", "galerkin", "pieces")  # each has a colour
COSTS = (("instructions", "Instructions (millions)", 1e-6), ("seconds", "Time (ms)", 1e3))

WORDS = """\
## What each effect costs

Made by `bench/effects.sh` ([bench/](../bench/README.md#effects) describes it). The paper's scene (γ = 0.2, ω = 50 rad/s, {modes} modes
before and after the capture, {samples} samples at midpoint and tip) is run alone and with one additional effect. Valgrind counts the
instructions of the whole run; those of `beamwave --version` are subtracted. Times are those of all stages except writing, medians of
{runs} interleaved runs. The procedures of an absent effect are never called;
`tests/scenes/test_absent_effects.py` checks each of them.

![Instructions and seconds with each effect](pictures/effects.png)
"""


BEAM = "&beam length = 1, diameter = 0.037, density = 7870, youngs_modulus = 2e11 /"
ROTATION = "&rotation angular_velocity = 50 /"
IMPACT = "&impact mass_ratio = 0.2 /"
CAPTURE = "&capture /"
RESPONSE = "&response duration = 1, samples = {samples} /"
PAPER = (BEAM, ROTATION, IMPACT, CAPTURE, RESPONSE)

SAMPLES, SMALL_SAMPLES = 4096, 64
MODES, SMALL_MODES = 40, 4


@dataclass(frozen=True)
class Variant:
    """A scene of the table: its words there, and its groups besides `&modes`."""

    words: str
    groups: tuple[str, ...]
    beside: str = "paper"  # what it is held against, by the words
    modes: int = 0  # how many; 0: as many as the others

    def scene(self, small: bool) -> str:
        """The scene's text."""
        modes = self.modes or (SMALL_MODES if small else MODES)
        counts = f"before = {modes}, after = {modes}" if CAPTURE[:8] in "".join(self.groups) else f"before = {modes}"
        samples = SMALL_SAMPLES if small else SAMPLES
        return "\n".join([*self.groups, f"&modes {counts} /"]).replace("{samples}", str(samples)) + "\n"


REBOUND = (  # the mass strikes six times; of more modes the contacts are too many to be counted
    BEAM,
    ROTATION,
    "&impact mass_ratio = 0.2, restitution = 0.9 /",
    "&response duration = 0.02, samples = {samples} /",
)

VARIANTS = (
    Variant("paper", PAPER),
    Variant("without rotation", (BEAM, IMPACT, CAPTURE, RESPONSE)),
    Variant("out of plane", (BEAM, "&rotation angular_velocity = 50, plane = 'out' /", IMPACT, CAPTURE, RESPONSE)),
    Variant("with stiffening", (*PAPER, "&stiffening /")),
    Variant("with shear", (*PAPER, "&shear /")),
    Variant("with damping", (*PAPER, "&damping ratio = 0.01 /")),
    Variant("with the body's rotary inertia", (BEAM, ROTATION, IMPACT, "&capture rotary_inertia = 1e-3 /", RESPONSE)),
    Variant("captured at xi = 0.7", (BEAM, ROTATION, "&impact mass_ratio = 0.2, position = 0.7 /", CAPTURE, RESPONSE)),
    Variant("with a soft root", (*PAPER, "&support rotational_stiffness = 1.84e5 /")),
    Variant("with a body at xi = 0.5", (*PAPER, "&body position = 0.5, mass_ratio = 0.01 /")),
    Variant("with release at half time", (*PAPER, "&release time = 0.5 /")),
    Variant("rebound of 5 modes", REBOUND, modes=5),
    Variant("with recontact", (*REBOUND, "&recontact /"), "rebound of 5 modes", modes=5),
)


def measured(options: argparse.Namespace) -> Measured:
    """One row for each scene."""
    portable = Path(os.environ.get("BEAMWAVE_PORTABLE", options.beamwave))
    variants = (VARIANTS[0], VARIANTS[4]) if options.small else VARIANTS

    def run(variant: Variant) -> tuple[float, str]:
        return seconds_and_method(variant.scene(options.small))

    answers = in_turns(variants, run, 1 if options.small else ROUNDS, lambda variant: variant.words)
    start = instructions(portable, "--version")
    rows = []
    for variant, runs in zip(variants, answers):
        counted = None if start is None else count(portable, variant.scene(options.small))
        rows.append({
            "variant": variant.words,
            "beside": variant.beside,
            "method": runs[0][1],
            "instructions": None if counted is None or start is None else counted - start,
            "seconds": median(seconds for seconds, _ in runs),
            "runs": len(runs),
        })
    return {"rows": rows}


def seconds_and_method(scene: str) -> tuple[float, str]:
    """Seconds of all stages but writing, and the method."""
    from netCDF4 import Dataset

    with tempfile.TemporaryDirectory() as directory:
        run_scene(Path(directory), scene)
        with Dataset(Path(directory) / "scene.nc") as result:
            return stage_seconds(result), result.method


def count(program: Path, scene: str) -> int | None:
    """Instructions of a run."""
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "scene.nml"
        path.write_text(scene)
        return instructions(program, "run", path, "--output", directory, "--quiet")


def instructions(*words: str | Path) -> int | None:
    """Instructions of a command; None without valgrind, or where it does not know the processor's."""
    if not shutil.which("valgrind"):
        return None
    counting = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
    ended = subprocess.run([*counting, *words], capture_output=True, text=True, check=False)
    found = re.search(r"Collected : (\d+)", ended.stderr)
    return int(found[1]) if found and ended.returncode == 0 else None


def section(measured: Measured) -> list[str]:
    """Text, and a table with a line for each scene."""
    rows = measured["rows"]
    words = WORDS.format(modes=MODES, samples=SAMPLES, runs=max(row["runs"] for row in rows))
    known = {row["variant"]: row for row in rows}
    body = [["scene", "modes by", "million instructions", "times as many", "ms", "times as long"]]
    for row in rows:
        beside = known[row["beside"]]
        body.append([
            row["variant"],
            row["method"],
            "–" if row["instructions"] is None else f"{row['instructions'] / 1e6:.3g}",
            times(row["instructions"], beside["instructions"]),
            f"{row['seconds'] * 1e3:.3g}",
            times(row["seconds"], beside["seconds"]),
        ])
    return [words, measured_with(measured["machine"]), table(body)]


def times(value: float | None, beside: float | None) -> str:
    """A ratio; a dash where one of the two is not known."""
    return f"{float(f'{value / beside:.2g}'):g}" if value and beside else "–"


def draw(measured: Measured) -> Figure:
    """Instructions and seconds as bars, side by side."""
    rows = measured["rows"][::-1]
    with mpl.rc_context(RC):
        figure = Figure(figsize=(8.6, 3.8), layout="constrained")
        for axes, (cost, words, scale) in zip(figure.subplots(1, 2, sharey=True), COSTS):
            values = [(row[cost] or 0.0) * scale for row in rows]
            colours = [COLOURS[METHODS.index(row["method"])] for row in rows]
            bars = axes.barh([row["variant"] for row in rows], values, color=colours)
            axes.bar_label(bars, [f"{value:.3g}" if value else "not counted" for value in values], padding=3, fontsize="small")
            axes.set_xlabel(words)
            axes.margins(x=0.15)
            axes.grid(visible=False)
        figure.suptitle("blue: modes in closed form; orange: by Galerkin's method; green: of pieces", fontsize="medium")
    return figure


BENCH = Bench("effects", "what each effect costs", measured, section, draw)
