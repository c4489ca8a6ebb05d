"""Cases per second of sweeps over the angular velocity and the mass ratio, beside what else one could write."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from common.bench import Bench, Measured, Rows, read
from common.document import measured_with, table

from .parts import PARTS, WAYS

MEMORY = "/dev/shm" if Path("/dev/shm").is_dir() else None  # no disk is measured

HEAD = """## Throughput of sweeps

Made by `bench/throughput.sh` ([bench/](../bench/README.md#throughput) describes it). Rates are cases per CPU second of a core, including
start-up and writing the result; numpy writes by netCDF4. beamwave saves every case to the disk within two seconds."""


def measured(options: argparse.Namespace) -> Measured:
    """All parts, or one of them beside those that were measured before, each with its machine."""
    known = read(BENCH.data()) if options.only else {"machine": {}, "rows": []}
    rows = [row for row in known["rows"] if row["part"] != options.only]
    for part in [options.only] if options.only else PARTS:
        with tempfile.TemporaryDirectory(dir=MEMORY) as name:
            found = PARTS[part](options.beamwave, Path(name), options.small)
        rows += [{"part": part, **row} for row in found]
        known["machine"][part] = options.machine
    return {"machine": known["machine"], "rows": rows}


def section(measured: Measured) -> list[str]:
    """All that was measured, each part with where, or once for parts that were measured together."""
    drawn = []
    for part, draw in TABLES.items():
        rows = [row for row in measured["rows"] if row["part"] == part]
        if rows:
            drawn.append((draw(rows), measured_with(measured["machine"][part])))
    parts = [HEAD]
    for i, (text, machine) in enumerate(drawn):
        last = i + 1 == len(drawn) or drawn[i + 1][1] != machine
        parts += [text, machine] if last else [text]
    return parts


def rates(rows: Rows) -> str:
    """Cases per second of each way."""
    heads = ["beamwave, cases/s", "numpy loop", "numpy by products", "beamwave is faster by"]
    lines = [["sweep over ω and γ", *heads]]
    for row in rows:
        speed = [1.0 / row[way] for way in WAYS]
        factors = ", ".join(f"{speed[0] / other:.1f}" for other in speed[1:])
        lines.append([row["what"], *(f"{value:.0f}" for value in speed), factors])
    return (
        "The loop computes a sine for every mode at every time. *By products* is the loop with the addition "
        "theorem, so that BLAS sums the histories.\n\n" + table(lines)
    )


def ranks(rows: Rows) -> str:
    """Two processes beside one."""
    lines = [["sweep", "shared by", "cases", "start-up, s", "wall, s", "CPU, s", "wall over that of one process"]]
    for i, row in enumerate(rows):
        numbers = [row[name] for name in ("what", "by", "cases", "start_wall", "wall", "cpu")]
        lines.append([*map(str, numbers), f"{row['wall'] / rows[i - i % 2]['wall']:.2f}"])
    return (
        "Start-up, mainly of `mpirun`, is the time of 20 cases, and is subtracted. All processes write into one "
        "file. Parts are commands with `--part`, which need no MPI.\n\n" + table(lines)
    )


def designs(rows: Rows) -> str:
    """A table of cases beside a sweep."""
    lines = [["cases of a sweep", "cases", "as a sweep, CPU s", "as rows of a table, CPU s", "more"]]
    for row in rows:
        lines.append([row["what"], str(row["cases"]), f"{row['sweep']:g}", f"{row['design']:g}", f"{row['ratio']:.2f}"])
    return "A `&design` also reads its table and computes quantiles; the cases are those of a sweep.\n\n" + table(lines)


def memory(rows: Rows) -> str:
    """The peak against the number of cases."""
    lines = [["cases", "CPU, s", "peak, MB"], *([str(row["cases"]), f"{row['cpu']:g}", f"{row['peak_mb']:g}"] for row in rows)]
    return "Memory of a sweep of very small cases (one mode) against their number.\n\n" + table(lines)


def predictions(rows: Rows) -> str:
    """What `check` says beside what a run takes."""
    lines = [["scene", "estimate, s", "wall, s", "CPU, s", "estimate over CPU", "memory", "file"]]
    for row in rows:
        numbers = [row["expected"], row["wall"], row["cpu"], float(f"{row['expected'] / row['cpu']:.2g}")]
        ratios = [row["memory_ratio"], row["size_ratio"]]
        lines.append([row["scene"], *(f"{number:g}" for number in numbers), *(f"{ratio:.2g}" for ratio in ratios)])
    return (
        "Estimates of `beamwave check` over the actual run: time (on an idle core, with start-up), memory and size of the "
        "file. On busy cores only the CPU seconds are meaningful.\n\n" + table(lines)
    )


def scenes(rows: Rows) -> str:
    """Many small scenes in one call."""
    lines = [["a small scene (20 modes, no history)", "CPU, ms"], *([row["what"], f"{row['ms']:g}"] for row in rows)]
    return "Cost of one of 200 small scenes, and of starting the program alone.\n\n" + table(lines)


TABLES = {"rates": rates, "designs": designs, "ranks": ranks, "memory": memory, "predictions": predictions, "scenes": scenes}
BENCH = Bench("throughput", "cases per second of sweeps", measured, section, packages=("numpy",),
              options={"--only": {"choices": list(PARTS), "help": "measure one part; keep the others"}})  # fmt: skip
