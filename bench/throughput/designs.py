"""A design beside a sweep of the same cases, in turns: its table has to be read, and its quantiles to be found."""

from __future__ import annotations

import re
import statistics
from pathlib import Path
from typing import Any

from .jobs import JOBS, Job
from .sweeps import launched, rounded, run_words

CASES = 10_000
ROUNDS = 15


def designs(program: Path, directory: Path, small: bool) -> list[dict[str, Any]]:
    """CPU seconds of both, medians, and the median of how much more the design takes in each turn."""
    rows = []
    for job in JOBS[:2]:
        cases = 100 if small else CASES
        seconds: dict[str, list[float]] = {"sweep": [], "design": []}
        for turn in range(1 if small else ROUNDS):
            for way in sorted(seconds, reverse=turn % 2 == 0):
                words = run_words(directory, job, cases) if way == "sweep" else design_words(directory, job, cases)
                seconds[way].append(launched(program, *words)[0])
        sweep, design = (statistics.median(seconds[way]) for way in ("sweep", "design"))
        ratio = statistics.median(one / other for one, other in zip(seconds["design"], seconds["sweep"]))  # of neighbours in time
        rows.append(rounded({"what": job.what, "cases": cases, "sweep": sweep, "design": design, "ratio": ratio}))
    return rows


def design_words(directory: Path, job: Job, cases: int) -> list[Any]:
    """The sweep's scene with a table of its cases."""
    words = run_words(directory, job, cases)
    scene = Path(words[1])
    text = re.sub(r"&sweep.*\n", "", scene.read_text()) + "&design file = 'cases.csv' /\n"
    scene.write_text(text)
    table = "".join(f"{float(ratio)!r},{float(speed)!r}\n" for speed, ratio in job.grid(cases))
    (directory / "cases.csv").write_text("impact%mass_ratio,rotation%angular_velocity\n" + table)
    return words
