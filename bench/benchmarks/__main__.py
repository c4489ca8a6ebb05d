"""Run the scenes of input/benchmarks/ and write docs/benchmarks.md: `PYTHONPATH=bench .venv/bin/python -m benchmarks`."""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from pathlib import Path

import xarray as xr

from benchmarks.problems import Problem, Row, digits, problems
from common.bench import PROGRAM, PROJECT

OPENING = """# Benchmarks

Problems with published answers, compared with those of beamwave. The scenes are in [input/benchmarks/](../input/benchmarks);
`PYTHONPATH=bench .venv/bin/python -m benchmarks` runs them and writes this page; a test (`tests/scenes/test_benchmarks.py`) checks the
numbers. A difference below half a unit of the last published digit is called *rounding*. [numbers.md](numbers.md) shows the accuracy of the program
beyond published digits.
"""


def results_of(scenes: list[str], program: Path) -> dict[str, xr.Dataset]:
    """Run scenes; their results by name."""
    with tempfile.TemporaryDirectory() as scratch:
        paths = [PROJECT / f"input/benchmarks/{scene}.nml" for scene in scenes]
        subprocess.run([program, "run", *paths, "--output", scratch, "--quiet"], check=True)
        return {scene: xr.load_dataset(Path(scratch) / f"{scene}.nc") for scene in scenes}


def line_of(row: Row, results: dict[str, xr.Dataset]) -> str:
    """A row of the table."""
    ours, published = row.ours(results), float(row.published)
    text = f"{ours:.{digits(row.published) + 1}g}"
    off = ours / published - 1
    rounded = f"{ours:.{digits(row.published) - 1}e}" == f"{published:.{digits(row.published) - 1}e}"
    return f"| {row.what} | {row.published} | {text} | {'rounding' if rounded else f'{off:+.1e}'} |"


def section(problem: Problem, results: dict[str, xr.Dataset]) -> str:
    """A problem's heading, text and table."""
    links = ", ".join(f"[{scene}](../input/benchmarks/{scene}.nml)" for scene in problem.scenes)
    table = "\n".join(line_of(row, results) for row in problem.rows)
    plural = "s" if len(problem.scenes) > 1 else ""
    return (f"## {problem.title}\n\n{problem.text}\nScene{plural}: {links}.\n\n"
            f"| quantity | published | beamwave | difference |\n|---|---|---|---|\n{table}\n")


def document(results: dict[str, xr.Dataset]) -> str:
    """The whole page."""
    return "\n".join([OPENING, *(section(problem, results) for problem in problems())])


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--beamwave", type=Path, default=PROGRAM)
    parser.add_argument("--output", type=Path, default=PROJECT / "docs/benchmarks.md")
    words = parser.parse_args()
    scenes = [scene for problem in problems() for scene in problem.scenes]
    words.output.write_text(document(results_of(scenes, words.beamwave)), encoding="utf-8")


if __name__ == "__main__":
    main()
