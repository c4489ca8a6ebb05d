"""What opens and closes docs/numbers.md: the numbers that matter, each read off the data of a bench or the table of hard cases,
and where all were measured. `PYTHONPATH=bench python -m overview` writes both."""

from __future__ import annotations

import json
from typing import Any

from common.bench import BENCH, PROJECT
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
    files = {name: BENCH / name / "measured.json" for name in NAMES}
    measured = {name: json.loads(path.read_text(encoding="utf-8")) for name, path in files.items() if path.is_file()}
    return {FIRST: what_matters(measured, DOCUMENT.read_text(encoding="utf-8")), LAST: machines(measured)}


def what_matters(measured: dict[str, Any], document: str) -> str:
    """A list with a line for each section that has data."""
    writers = {
        "peers": speed, "contact": contact, "price": digits, "growth": sizes, "throughput": sweeps,
        "effects": effects, "records": lines, "large_records": large,
    }
    points = [hard_cases(document), *(write(measured[name]) for name, write in writers.items() if name in measured)]
    return "\n".join([WHAT_MATTERS, "", *(point for point in points if point)])


def hard_cases(document: str) -> str:
    """How many there are, and some of them; nothing where the document has none."""
    lines = [line for line in document.partition("\n## Hard cases\n")[2].partition("<!--")[0].splitlines() if line.startswith("| ")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    worst = {row[0]: row[1] for row in rows if len(row) == 5 and row[3] != "measured as" and not row[1].startswith("-")}
    root, shape, motion = (find(worst, start) for start in ("α_k", "shapes Φ_k", "displacement to t = 1"))
    if not (root and shape and motion):
        return ""
    return (
        f"- **Digits.** [{len(worst)} hard cases](#hard-cases) are compared with references of 50 digits or more, and all errors are within their bounds. "
        f"Roots of modes 1 to 10⁸ are off by at most {root} units in the last place, shapes by {shape}, and the displacement "
        f"up to 10⁹ s by {motion} of its peak."
    )


def find(worst: dict[str, str], start: str) -> str:
    """The error of the first case whose name begins so."""
    return next((error for name, error in worst.items() if name.startswith(start)), "")


def speed(data: dict[str, Any]) -> str:
    """Seconds to an error, of the program and of the best of the others."""

    def curve(name: str) -> list[dict[str, Any]]:
        return [row for row in data["rows"] if row["peer"] == name and row.get("error") is not None]

    def milliseconds(name: str, level: float) -> str:
        seconds = seconds_to_reach(curve(name), level)
        return "–" if seconds is None else f"{1e3 * seconds:.3g} ms"

    elements = min((row for name in {row["peer"] for row in data["rows"]} if "Hermite" in name for row in curve(name)), key=lambda row: row["error"])
    ours, best = "beamwave", "numpy + FINUFFT"
    return (
        f"- **Time to an answer.** [The paper's beam after the capture](#comparison-with-other-methods), two points, "
        f"{grouped(data['problem']['samples'])} times: beamwave takes {milliseconds(ours, 1e-6)} for an error of 1e-6 and {milliseconds(ours, 1e-9)} for 1e-9; "
        f"the whole process, including its file, takes {milliseconds('beamwave, whole process', 1e-9)}. A careful program in {best} takes "
        f"{milliseconds(best, 1e-6)} and {milliseconds(best, 1e-9)}. Finite elements reach {short(elements['error'])} at best, "
        f"in {1e3 * elements['cpu_seconds']:.3g} ms."
    )


def contact(data: dict[str, Any]) -> str:
    """The smallest errors of the program and of the others, and what they take."""
    known = [row for row in data["rows"] if row.get("error") is not None]
    own = min((row for row in known if row["peer"] == "beamwave, whole process"), key=lambda row: row["error"])
    other = min((row for row in known if not row["peer"].startswith("beamwave")), key=lambda row: row["error"])
    return (
        f"- **Contact of finite duration.** [With a linear stop](#contact-of-finite-duration-opensees-and-exudyn) beamwave reaches an error of {short(own['error'])} "
        f"of the displacement's peak in {1e3 * own['cpu_seconds']:.3g} ms, files included; {other['peer'].split(',')[0]}, with finite elements and time steps, "
        f"{short(other['error'])} in {other['cpu_seconds']:.2g} s."
    )


def grouped(number: int) -> str:
    """Its digits by threes where it has five or more; no line ends between them."""
    return f"{number:,}".replace(",", "\N{NO-BREAK SPACE}") if number >= 10000 else str(number)


def short(value: float) -> str:
    """One digit and a power of ten."""
    return f"{value:.0e}".replace("e-0", "e-")


def digits(data: dict[str, Any]) -> str:
    """What a further digit costs on average."""
    means = []
    for samples in data["against"]:
        rows = [row for row in data["rows"] if row["samples"] == int(samples) and row["ladder"] == "tolerance"]
        seconds = {row["tolerance"]: row["seconds"] for row in rows if "seconds" in row}
        if 1e-3 in seconds and 1e-11 in seconds:
            growth = (seconds[1e-11] / seconds[1e-3]) ** (1.0 / 8.0) - 1.0
            means.append(f"{100 * growth:.0f} % more time with {grouped(int(samples))} samples")
    return "- **A further digit** [from 1e-3 to 1e-11](#what-accuracy-costs) costs on average " + " and ".join(means) + "."


def sizes(data: dict[str, Any]) -> str:
    """The largest size of each axis that grows in proportion."""
    said, powers = [], []
    for axis in ("modes", "samples", "points"):
        own = [row for row in data["rows"] if row["axis"] == axis]
        last = own[-1]
        said.append(f"{grouped(last['size'])} {axis} take {last['cpu_seconds']:.2g} s and {last['memory_bytes'] / 1e9:.2g} GB")
        powers.append(f"{slope(own, 'cpu_seconds'):.2f}")
    growth = f"Time grows as these numbers to the powers {', '.join(powers)}"
    return "- **Size.** [Large scenes](#how-time-and-memory-grow): " + "; ".join(said) + f". {growth}."


def sweeps(data: dict[str, Any]) -> str:
    """Cases per second beside a loop in numpy, and what a second process brings."""
    rates, ranks = ([row for row in data["rows"] if row["part"] == part] for part in ("rates", "ranks"))
    said = [f"{grouped(round(1 / row['beamwave']))} with {kind} ({row['numpy loop'] / row['beamwave']:.0f})"
            for row, kind in zip(rates, ("frequencies", "histories", "spectra"))]  # fmt: skip
    shares = [f"{two['wall'] / one['wall']:.2f}" for one, two in zip(ranks[::2], ranks[1::2])]
    return (
        "- **Sweeps.** Cases per second [of one core](#throughput-of-sweeps), in brackets over those of a loop in numpy: "
        + ", ".join(said)
        + f". Two MPI processes take {', '.join(shares[::2])} of the time of one, two parts without MPI {', '.join(shares[1::2])}."
    )


def effects(data: dict[str, Any]) -> str:
    """How much longer a scene takes with them."""
    known = {row["variant"]: row for row in data["rows"]}
    said = [f"{name.removeprefix('with ')} {row['seconds'] / known[row['beside']]['seconds']:.2g}"
            for name, row in known.items() if name in ("with damping", "with stiffening", "with shear")]  # fmt: skip
    return (
        "- **Effects.** Run time of [the paper's scene](#what-each-effect-costs) with one more effect, over that without: " + ", ".join(said) + ". "
        "An absent effect costs nothing."
    )


def lines(data: dict[str, Any]) -> str:
    """Errors and intervals of lines in noise, and the records in which more than a hundredth of the lines are missed."""
    own = [row for row in data["rows"] if row["peer"] == "beamwave" and "missed" in row]  # with lines
    found = [row for row in own if row["missed"] <= 0.01]
    missed = [f"{100 * row['missed']:.0f} % in the cell '{row['cell']}'" for row in own if row["missed"] > 0.01]
    worst = max(max(row["over_bound"]) for row in found)
    inside = [part for row in found for part in row["inside"]]
    return (
        f"- **Lines of records.** In {len(found)} of [{len(own)} kinds of noisy records](#lines-in-noise) the mean square errors of "
        f"frequency and decay are at most {worst:.3g} times the Cramér–Rao bound, and {100 * min(inside):.3g} to "
        f"{100 * max(inside):.3g} % of the 95 % intervals contain the true value. "
        + ("Missed lines: " + ", ".join(missed) + "." if missed else "Nowhere are more than 1 % of the lines missed.")
    )


def large(data: dict[str, Any]) -> str:
    """The largest record."""
    last = data["rows"][-1]
    took = f"{last['cpu_seconds']:.2g} s and {last['memory_bytes'] / 1e9:.2g} GB"
    return f"- **Large records.** 1 048 576 samples of 64 sensors with 20 lines [take](#large-records) {took}."


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
