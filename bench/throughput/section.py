"""The section of docs/numbers.md."""

from __future__ import annotations

from typing import Any

from common.document import measured_with, table

FIRST = "<!-- throughput: bench/throughput.sh writes from here -->"
WAYS = ["beamwave", "numpy loop", "by products", "pool of 2"]

HEAD = """## Throughput of sweeps

Made by `bench/throughput.sh` ([bench/](../bench/README.md#throughput) describes it). Rates are cases per CPU second of a core, including
start-up and writing the result; numpy writes by netCDF4. The rate of the pool is that of each of its processes. beamwave saves
every case to the disk within two seconds."""


def section(measured: dict[str, Any]) -> str:
    """All that was measured, each part with where."""
    drawn = [(draw(measured[name]["rows"]), measured_with(measured[name]["about"]))
             for name, draw in DRAWN.items() if measured.get(name, {}).get("rows")]  # fmt: skip
    parts = [HEAD]
    for i, (rows, about) in enumerate(drawn):
        last = i + 1 == len(drawn) or drawn[i + 1][1] != about  # of those that were measured together
        parts += [rows, about] if last else [rows]
    return "\n\n".join(parts)


def rates(rows: list[dict[str, Any]]) -> str:
    heads = ["beamwave, cases/s", "numpy loop", "numpy by products", "multiprocessing pool", "beamwave is faster by"]
    lines = [["sweep over ω and γ", *heads]]
    for row in rows:
        speed = [1.0 / row[way] for way in WAYS]
        factors = ", ".join(f"{speed[0] / other:.1f}" for other in speed[1:])
        lines.append([row["what"], *(f"{value:.0f}" for value in speed), factors])
    return (
        "Loop and pool compute a sine for every mode at every time. *By products* is the loop with the addition "
        "theorem, so that BLAS sums the histories.\n\n" + table(lines)
    )


def ranks(rows: list[dict[str, Any]]) -> str:
    lines = [["sweep", "shared by", "cases", "start-up, s", "wall, s", "CPU, s", "wall over that of one process"]]
    for i, row in enumerate(rows):
        numbers = [row[name] for name in ("what", "by", "cases", "start_wall", "wall", "cpu")]
        lines.append([*map(str, numbers), f"{row['wall'] / rows[i - i % 2]['wall']:.2f}"])
    return (
        "Start-up, mainly of `mpirun`, is the time of 20 cases, and is subtracted. All processes write into one "
        "file. Parts are commands with `--part`, which need no MPI.\n\n" + table(lines)
    )


def designs(rows: list[dict[str, Any]]) -> str:
    lines = [["cases of a sweep", "cases", "as a sweep, CPU s", "as rows of a table, CPU s", "more"]]
    lines += [[row["what"], str(row["cases"]), f"{row['sweep']:g}", f"{row['design']:g}", f"{row['ratio']:.2f}"] for row in rows]
    return "A `&design` also reads its table and computes quantiles; the cases are those of a sweep.\n\n" + table(lines)


def memory(rows: list[dict[str, Any]]) -> str:
    lines = [["cases", "CPU, s", "peak, MB"], *([str(row["cases"]), f"{row['cpu']:g}", f"{row['peak_mb']:g}"] for row in rows)]
    return "Memory of a sweep of very small cases (one mode) against their number.\n\n" + table(lines)


def predictions(rows: list[dict[str, Any]]) -> str:
    lines = [["scene", "estimate, s", "wall, s", "CPU, s", "estimate over CPU", "memory", "file"]]
    for row in rows:
        numbers = [row["expected"], row["wall"], row["cpu"], float(f"{row['expected'] / row['cpu']:.2g}")]
        ratios = [row["memory_ratio"], row["size_ratio"]]
        lines.append([row["scene"], *(f"{number:g}" for number in numbers), *(f"{ratio:.2g}" for ratio in ratios)])
    return (
        "Estimates of `beamwave check` over the actual run: time (on an idle core, with start-up), memory and size of the "
        "file. On busy cores only the CPU seconds are meaningful.\n\n"
        + table(lines)
    )


def small_scenes(rows: list[dict[str, Any]]) -> str:
    lines = [["a small scene (20 modes, no history)", "CPU, ms"], *([row["what"], f"{row['ms']:g}"] for row in rows)]
    return "Cost of one of 200 small scenes, and of starting the program alone.\n\n" + table(lines)


DRAWN = {"rows": rates, "designs": designs, "ranks": ranks, "memory": memory, "predictions": predictions, "scenes": small_scenes}
