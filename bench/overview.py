"""What opens and closes docs/numbers.md: the numbers that matter, each read off the data of a bench or the table of hard cases,
and where all were measured. `PYTHONPATH=bench python -m overview` writes both."""

from __future__ import annotations

from typing import Any, Callable

from common.bench import BENCH, PROJECT, Measured, Rows, read
from common.document import put_section, table
from common.growing import slope
from peers.comparison import seconds_to_reach

DOCUMENT = PROJECT / "docs/numbers.md"
NAMES = ("peers", "contact", "growth", "throughput", "price", "effects", "sum", "records", "large_records")
FIRST = "<!-- what matters: every bench writes from here -->"
LAST = "<!-- machines: every bench writes from here -->"

WHAT_MATTERS = """\
## What matters

All times are for one core of the machine [below](#where-it-was-measured). The sections say how each number was measured."""

MACHINES = """\
## Where it was measured

Compiler and flags are those of the preset `default`."""

IN_SECTIONS = ("Python", "date")  # and the program's commit


def put_overview() -> None:
    """Write both sections anew."""
    for mark, text in sections().items():
        put_section(DOCUMENT, mark, text)


def sections() -> dict[str, str]:
    """Both, by their marks, from the committed data of all benches and from the document itself."""
    measured = {name: read(path) for name in NAMES if (path := BENCH / name / "measured.json").is_file()}
    points = [hard_cases(DOCUMENT.read_text(encoding="utf-8")), *(POINTS[name](measured[name]) for name in POINTS if name in measured)]
    return {FIRST: "\n".join([WHAT_MATTERS, "", *(f"- {point}" for point in points if point)]), LAST: machines(measured)}


def hard_cases(document: str) -> str:
    """How many there are, and some of them; nothing where the document has none."""
    lines = document.partition("\n## Hard cases\n")[2].partition("<!--")[0].splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    worst = {row[0]: row[1] for row in rows if len(row) == 5 and row[3] != "measured as" and not row[1].startswith("-")}
    starts = ("α_k", "shapes Φ_k", "displacement to t = 1")
    root, shape, motion = (next((worst[name] for name in worst if name.startswith(start)), "") for start in starts)
    if not (root and shape and motion):
        return ""
    return (
        f"**Digits.** [{len(worst)} hard cases](#hard-cases) are compared with references of 50 digits or more, and all errors are "
        f"within their bounds. Roots of modes 1 to 10⁸ are off by at most {root} units in the last place, shapes by {shape}, and the "
        f"displacement up to 10⁹ s by {motion} of its peak."
    )


def known(data: Measured, chosen: Callable[[str], bool]) -> Rows:
    """The rows of peers whose error is known."""
    return [row for row in data["rows"] if row.get("error") is not None and chosen(row["peer"])]


def smallest(rows: Rows) -> dict[str, Any]:
    """The row with the smallest error."""
    return min(rows, key=lambda row: row["error"])


def speed(data: Measured) -> str:
    """Seconds to an error, of the program and of the best of the others."""

    def milliseconds(name: str, *levels: float) -> str:
        seconds = [seconds_to_reach(known(data, name.__eq__), level) for level in levels]
        return " and ".join("–" if time is None else f"{1e3 * time:.3g} ms" for time in seconds)

    elements, best = smallest(known(data, lambda name: "Hermite" in name)), "numpy + FINUFFT"
    return (
        f"**Time to an answer.** [The paper's beam after the capture](#comparison-with-other-methods), two points, "
        f"{grouped(data['problem']['samples'])} times: beamwave takes {milliseconds('beamwave', 1e-6)} for an error of 1e-6 and "
        f"{milliseconds('beamwave', 1e-9)} for 1e-9; the whole process, including its file, takes "
        f"{milliseconds('beamwave, whole process', 1e-9)}. A careful program in {best} takes {milliseconds(best, 1e-6, 1e-9)}. "
        f"Finite elements reach {short(elements['error'])} at best, in {1e3 * elements['cpu_seconds']:.3g} ms."
    )


def contact(data: Measured) -> str:
    """The smallest errors of the program and of the others, and what they take."""
    own, other = smallest(known(data, "beamwave, whole process".__eq__)), smallest(known(data, lambda name: "beamwave" not in name))
    return (
        f"**Contact of finite duration.** [With a linear stop](#contact-of-finite-duration-opensees-and-exudyn) beamwave reaches an error "
        f"of {short(own['error'])} of the displacement's peak in {1e3 * own['cpu_seconds']:.3g} ms, files included; "
        f"{other['peer'].split(',')[0]}, with finite elements and time steps, {short(other['error'])} in {other['cpu_seconds']:.2g} s."
    )


def grouped(number: int) -> str:
    """Its digits by threes where it has five or more; no line ends between them."""
    return f"{number:,}".replace(",", "\N{NO-BREAK SPACE}") if number >= 10000 else str(number)


def short(value: float) -> str:
    """One digit and a power of ten."""
    return f"{value:.0e}".replace("e-0", "e-")


def digits(data: Measured) -> str:
    """What a further digit costs on average."""
    means = []
    for samples in data["against"]:
        rows = [row for row in data["rows"] if row["samples"] == int(samples) and row["ladder"] == "tolerance"]
        seconds = {row["tolerance"]: row["seconds"] for row in rows if "seconds" in row}
        if 1e-3 in seconds and 1e-11 in seconds:
            growth = (seconds[1e-11] / seconds[1e-3]) ** (1.0 / 8.0) - 1.0
            means.append(f"{100 * growth:.0f} % more time with {grouped(int(samples))} samples")
    return "**A further digit** [from 1e-3 to 1e-11](#what-accuracy-costs) costs on average " + " and ".join(means) + "."


def of_last(row: dict[str, Any]) -> str:
    """What the largest size takes."""
    return f"{row['cpu_seconds']:.2g} s and {row['memory_bytes'] / 1e9:.2g} GB"


def sizes(data: Measured) -> str:
    """The largest size of each axis that grows in proportion."""
    own = {axis: [row for row in data["rows"] if row["axis"] == axis] for axis in ("modes", "samples", "points")}
    said = "; ".join(f"{grouped(rows[-1]['size'])} {axis} take {of_last(rows[-1])}" for axis, rows in own.items())
    powers = ", ".join(f"{slope(rows, 'cpu_seconds'):.2f}" for rows in own.values())
    return f"**Size.** [Large scenes](#how-time-and-memory-grow): {said}. Time grows as these numbers to the powers {powers}."


def sweeps(data: Measured) -> str:
    """Cases per second beside a loop in numpy, and what a second process brings."""
    rates, ranks = ([row for row in data["rows"] if row["part"] == part] for part in ("rates", "ranks"))
    said = [f"{grouped(round(1 / row['beamwave']))} with {kind} ({row['numpy loop'] / row['beamwave']:.0f})"
            for row, kind in zip(rates, ("frequencies", "histories", "spectra"))]  # fmt: skip
    shares = [f"{two['wall'] / one['wall']:.2f}" for one, two in zip(ranks[::2], ranks[1::2])]
    return (
        f"**Sweeps.** Cases per second [of one core](#throughput-of-sweeps), in brackets over those of a loop in numpy: {', '.join(said)}. "
        f"Two MPI processes take {', '.join(shares[::2])} of the time of one, two parts without MPI {', '.join(shares[1::2])}."
    )


def effects(data: Measured) -> str:
    """How much longer a scene takes with them."""
    rows = {row["variant"]: row for row in data["rows"]}
    said = [f"{name.removeprefix('with ')} {row['seconds'] / rows[row['beside']]['seconds']:.2g}"
            for name, row in rows.items() if name in ("with damping", "with stiffening", "with shear")]  # fmt: skip
    return (
        f"**Effects.** Run time of [the paper's scene](#what-each-effect-costs) with one more effect, over that without: "
        f"{', '.join(said)}. An absent effect costs nothing."
    )


def lines(data: Measured) -> str:
    """Errors and intervals of lines in noise, and the records in which more than a hundredth of the lines are missed."""
    own = [row for row in data["rows"] if row["peer"] == "beamwave" and "missed" in row]  # with lines
    found = [row for row in own if row["missed"] <= 0.01]
    missed = [f"{100 * row['missed']:.0f} % in the cell '{row['cell']}'" for row in own if row["missed"] > 0.01]
    inside = [part for row in found for part in row["inside"]]
    return (
        f"**Lines of records.** In {len(found)} of [{len(own)} kinds of noisy records](#lines-in-noise) the mean square errors of "
        f"frequency and decay are at most {max(max(row['over_bound']) for row in found):.3g} times the Cramér–Rao bound, and "
        f"{100 * min(inside):.3g} to {100 * max(inside):.3g} % of the 95 % intervals contain the true value. "
        + ("Missed lines: " + ", ".join(missed) + "." if missed else "Nowhere are more than 1 % of the lines missed.")
    )


def large(data: Measured) -> str:
    """The largest record."""
    return f"**Large records.** 1 048 576 samples of 64 sensors with 20 lines [take](#large-records) {of_last(data['rows'][-1])}."


POINTS = {
    "peers": speed, "contact": contact, "price": digits, "growth": sizes, "throughput": sweeps, "effects": effects, "records": lines,
    "large_records": large,
}  # fmt: skip


def machines(measured: dict[str, Any]) -> str:
    """A table of one line for each thing that is known, or for each of its values."""
    found: dict[str, dict[str, list[str]]] = {}
    for bench, data in measured.items():
        machine = data["machine"]
        for about in [machine] if "program" in machine else machine.values():
            for name, value in parts(about):
                benches = found.setdefault(name, {}).setdefault(value, [])
                if bench not in benches:
                    benches.append(bench)
    rows = [["what", "value", "benches"]]
    for name, values in found.items():
        rows += [[name, value, "all" if len(benches) == len(measured) else ", ".join(benches)] for value, benches in values.items()]
    return f"{MACHINES}\n\n{table(rows)}"


def parts(about: dict[str, str]) -> list[tuple[str, str]]:
    """Names and values; of what the program says of itself, `; ` between its lines, those below the first."""
    found = []
    for name, value in about.items():
        if name == "program":
            found += [tuple(line.split(" ", 1)) for line in value.split("; ")[1:] if not line.startswith("compiler ")]
        elif name not in IN_SECTIONS:
            found.append((name, value))
    return found


if __name__ == "__main__":
    put_overview()
