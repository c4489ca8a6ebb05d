"""Commands with their time and memory, runs that take turns, and numbers with three digits."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any, Callable, Iterable, NamedTuple, Sequence

LAUNCH = Path(__file__).with_name("launch.py")


class Took(NamedTuple):
    """What a command took, and what it printed."""

    seconds: float  # of processor time
    wall: float
    memory: int  # bytes at the peak
    said: str


def launched(*words: Any, accepted: tuple[int, ...] = (0,)) -> Took:
    """Run a command; it has to end with a status that is accepted."""
    command = [sys.executable, "-I", "-S", LAUNCH, *map(str, words)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    if ended.returncode not in accepted:
        raise RuntimeError(f"{words} ended with {ended.returncode}\n{ended.stderr[-2000:]}")
    *said, last = ended.stdout.splitlines()
    seconds, wall, memory = last.split()
    return Took(float(seconds), float(wall), int(memory), "\n".join(said))


def run_scene(directory: Path, scene: str, accepted: tuple[int, ...] = (0,)) -> Took:
    """Run the program, which BEAMWAVE names, on a scene's text; its result is `scene.nc` in the directory."""
    path = directory / "scene.nml"
    path.write_text(scene, encoding="utf-8")
    words = [os.environ["BEAMWAVE"], "run", path, "--output", directory, "--quiet"]
    return launched(*words, accepted=accepted)


def expected(program: Path, scene: Path) -> tuple[float, float, float, float]:
    """Seconds and bytes of memory and disk that `check` says a scene will take, and the CPU seconds that it needs to know them."""
    took = launched(program, "check", scene, "--json")
    said = json.loads(took.said)["scenes"][0]
    return said["seconds"], said["memory_bytes"], said["disk_bytes"], took.seconds


def stage_seconds(result: Any) -> float:
    """Seconds of all stages but writing, of an open result."""
    stages = zip(result["stage"].flag_meanings.split(), result["stage_seconds"][:])
    return sum(float(seconds) for name, seconds in stages if name != "write")


def in_turns(
    jobs: Sequence[Any],
    run: Callable[[Any], tuple],
    rounds: int,
    name: Callable[[Any], str] = str,
    fewer: Sequence[tuple[float, int]] = (),
) -> list[list[tuple]]:
    """Answers of each job, whose first number is its seconds; round by round each job is run once, every other round backwards.

    `fewer` has pairs of a limit and a count: what takes longer than the limit is run so many times only.
    """
    answers: list[list[tuple]] = [[] for _ in jobs]
    for turn in range(rounds):
        for job, kept in list(zip(jobs, answers))[:: -1 if turn % 2 else 1]:
            limits = [count for limit, count in fewer if kept and kept[0][0] > limit]
            if turn < min([rounds, *limits]):
                kept.append(run(job))
            if turn == 0:
                say(f"{name(job)}: {kept[0][0]:.3g} s")
    return answers


def say(words: str) -> None:
    """Show progress."""
    print(f"  {words}", file=sys.stderr, flush=True)


def rounded(value: float) -> float:
    """Three digits, as many as a table shows and one more."""
    return float(f"{float(value):.3g}")


def median(values: Iterable[float]) -> float:
    """The median, with three digits."""
    return rounded(statistics.median(values))
