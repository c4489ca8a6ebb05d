"""What accuracy costs on scenes with a long record and a short one."""

from __future__ import annotations

import argparse
import re
import tempfile
from pathlib import Path
from typing import Any

import matplotlib as mpl
import netCDF4
import numpy as np
from beamwave_postproc.style import COLOURS, GREY, RC
from common.bench import PROJECT, Bench, Measured, Rows
from common.document import measured_with, table
from common.measuring import launched, rounded, say
from matplotlib.axes import Axes
from matplotlib.figure import Figure

SCENE = PROJECT / "input/spectrum.nml"
SAMPLES, SMALL = (65_536, 4096), (256,)
NUMBERS = {  # our name: the file's variable
    "tolerance": "tolerance",
    "modes": "mode_count",
    "error": "true_error",
    "estimate": "estimated_error",
    "repeats": "repeats",
    "seconds": "seconds",
    "lower": "seconds_lower",
    "upper": "seconds_upper",
    "digit_seconds": "digit_seconds",
    "digit_growth": "digit_growth",
    "digit_noise": "digit_noise",
}
WHOLE = ("modes", "repeats")
AIM = 0.25  # of the time at hand, for a tenth of the tolerance
COARSE, FINE = 1e-3, 1e-11  # between which the aim is meant
STYLES = ((COLOURS[1], "o"), (COLOURS[2], "s"))

WORDS = """\
## What accuracy costs

Made by `bench/price.sh` ([bench/](../bench/README.md#the-price-of-accuracy) describes it): `beamwave accuracy` on `input/spectrum.nml`,
and on the same scene with a short record. Errors are the largest of the displacement at midpoint and tip over the peak, against a
converged run; the estimate is the run's own. Times are those of the stages up to the histories, medians of interleaved repeats; +/- is
half their interquartile range.

The aim is that from 1e-3 to 1e-11 each further digit costs at most 25 % more time. Down to 1e-5 few modes are summed directly, at a
cost proportional to their number. This is far cheaper than any transform, so that the step to the transform is large.

![Error against seconds](pictures/price.png)
"""


def measured(options: argparse.Namespace) -> Measured:
    """Rows of all scenes, and what each scene's errors were measured against."""
    rows: Rows = []
    against: dict[str, dict[str, float]] = {}
    for samples in SMALL if options.small else SAMPLES:
        say(f"{SCENE.name} with {samples} samples")
        with tempfile.TemporaryDirectory() as directory:
            scene = Path(directory) / "price.nml"
            scene.write_text(re.sub(r"(samples *= *)\d+", rf"\g<1>{samples}", SCENE.read_text(encoding="utf-8")))
            launched(options.beamwave, "accuracy", scene, "--output", directory, "--quiet")
            with netCDF4.Dataset(Path(directory) / "price.accuracy.nc") as file:
                rows += [{"samples": samples, **row} for row in rungs(file)]
                against[str(samples)] = {"converged_error": rounded(file["converged_error"][()])}
    return {"against": against, "rows": rows}


def rungs(file: netCDF4.Dataset) -> Rows:
    """One row for each rung; what a rung has not is left out."""
    ladder, status, stages = file["ladder"], file["rung_status"], file["stage"].flag_meanings.split()
    rows = []
    for place in range(file.dimensions["rung"].size):
        row: dict[str, Any] = {"ladder": word(ladder, place), "status": word(status, place)}
        for name, variable in NUMBERS.items():
            value = file[variable][place]
            if value is not netCDF4.numpy.ma.masked:
                row[name] = int(value) if name in WHOLE else rounded(value)
        if "seconds" in row:
            row["stages"] = dict(zip(stages, map(rounded, file["stage_seconds"][place])))
        rows.append(row)
    return rows


def word(flags: netCDF4.Variable, place: int) -> str:
    """The word of a flag."""
    return flags.flag_meanings.split()[list(flags.flag_values).index(flags[place])]


def section(measured: Measured) -> list[str]:
    """Text and a table for each scene."""
    parts = [WORDS, measured_with(measured["machine"])]
    for samples, against in measured["against"].items():
        rows = [row for row in measured["rows"] if row["samples"] == int(samples)]
        converged = against["converged_error"]
        trust = f"The converged run's error is estimated at {converged:.1e}."
        parts += [f"{int(samples)} samples. {summary(rows)} {trust}", details(rows, converged)]
    return parts


def summary(rows: Rows) -> str:
    """What a digit costs between the two ends of the aim."""
    timed = {row["tolerance"]: row for row in rows if row["ladder"] == "tolerance" and "seconds" in row}
    ends = [timed[end]["seconds"] for end in (COARSE, FINE) if end in timed]
    if len(ends) < 2:
        return ""
    steps = [row["digit_growth"] for tolerance, row in timed.items() if FINE < tolerance <= COARSE and "digit_growth" in row]
    mean = (ends[1] / ends[0]) ** (1.0 / 8.0) - 1.0
    return (
        f"From 1e-3 to 1e-11 a digit costs {mean:+.0%} on average and {max(steps):+.0%} at most, where the aim is "
        f"{AIM:+.0%}; all eight together {ends[1] / ends[0]:.2g} times the time of 1e-3."
    )


def details(rows: Rows, resolved: float) -> str:
    """Every rung that was timed."""
    body = [["requested", "modes", "true error", "estimate", "ratio", "ms", "+/-", "modes %", "events %", "response %", "next digit"]]
    for row in rows:
        if "seconds" in row:
            body.append(rung(row, resolved))
    return table(body)


def rung(row: dict[str, Any], resolved: float) -> list[str]:
    """Its cells."""
    name = f"{row['modes']} before and after"
    if row["ladder"] != "counts":
        name = f"tolerance {row.get('tolerance', 0.0):.0e}".replace("e-0", "e-")
    measured = row["error"] > resolved
    share = {stage: 100.0 * seconds / sum(row["stages"].values()) for stage, seconds in row["stages"].items()}
    step = ""
    if "digit_growth" in row:  # a price below zero is noise too: a finer tolerance never sums fewer modes
        step = "within noise"
        if row["digit_seconds"] > row["digit_noise"]:
            step = f"{1e3 * row['digit_seconds']:+.2g} ms, {row['digit_growth']:+.0%}"
    return [
        name,
        str(row["modes"]),
        f"{row['error']:.1e}" if measured else f"<{resolved:.1e}",
        f"{row['estimate']:.1e}",
        f"{row['estimate'] / row['error']:.2g}" if measured else "–",
        f"{1e3 * row['seconds']:.3g}",
        f"{500.0 * (row['upper'] - row['lower']):.2g}",
        *(f"{share[stage]:.0f}" for stage in ("modes", "events", "response")),
        step,
    ]


def draw(measured: Measured) -> Figure:
    """Error against seconds: tolerances as lines with marks, counts as marks alone, what a digit may cost beside each."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(7.0, 4.4), layout="constrained")
        axes = figure.subplots()
        for samples, style in zip(measured["against"], STYLES):
            rows = [row for row in measured["rows"] if row["samples"] == int(samples) and row.get("error", 0.0) > 0.0]
            scene(axes, [row for row in rows if "seconds" in row], int(samples), style)
        axes.set(xscale="log", yscale="log", xlabel="Largest error of the displacement over its peak",
                 ylabel="Time to the histories (ms)")  # fmt: skip
        axes.plot([], [], color=GREY, linestyle=":", label=f"{AIM:.0%} more time for each digit")
        axes.invert_xaxis()
        axes.legend(fontsize=9, loc="upper left")
    return figure


def scene(axes: Axes, rows: Rows, samples: int, style: tuple[str, str]) -> None:
    """The curves of one scene."""
    colour, marker = style
    for ladder, line, filled, label in (
        ("tolerance", "-", colour, f"tolerance, {samples} samples"),
        ("counts", "none", "white", f"counts, {samples} samples"),
    ):
        mine = [row for row in rows if row["ladder"] == ladder]
        if not mine:
            continue
        error = np.array([row["error"] for row in mine])
        seconds = np.array([row["seconds"] for row in mine])
        axes.plot(error, 1e3 * seconds, color=colour, linestyle=line, marker=marker, markersize=5, markerfacecolor=filled,
                  label=label)  # fmt: skip
        if ladder == "tolerance":
            reach = np.geomspace(error[0], error.min(), 50)
            axes.plot(reach, 1e3 * seconds[0] * (1.0 + AIM) ** np.log10(error[0] / reach), color=GREY, linestyle=":")


BENCH = Bench("price", "what accuracy costs", measured, section, draw)
