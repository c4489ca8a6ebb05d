"""Every peer in every size, interleaved: round by round each is run once, and medians are taken."""

from __future__ import annotations

import statistics
import sys
from typing import Any

import numpy as np

from . import (
    beamwave,
    cosh_shapes,
    hermite_modes,
    hermite_newmark,
    numpy_direct,
    numpy_finufft,
    numpy_products,
    opensees,
)
from .peer import Answer, Peer, Setting, setting_text
from .problem import Problem
from .reference import error

PEERS = (
    beamwave.STAGES,
    beamwave.PROCESS,
    numpy_finufft.PEER,
    numpy_products.PEER,
    numpy_direct.PEER,
    cosh_shapes.PEER,
    hermite_modes.PEER,
    hermite_newmark.PEER,
    opensees.PEER,
)
ROUNDS = 11
FEWER = ((0.3, 5), (1.0, 3), (5.0, 1))  # what takes longer than this, s, is run so many times only

Job = tuple[Peer, Setting]


def measure(peers: tuple[Peer, ...], problem: Problem, exact: np.ndarray, small: bool) -> list[dict[str, Any]]:
    """One row for each peer and size; a peer whose packages are missing has one row that says so."""
    jobs: list[Job] = []
    rows: list[dict[str, Any]] = []
    for peer in peers:
        if lacking := peer.missing():
            rows.append({"peer": peer.name, "not_measured": f"no {', '.join(lacking)}"})
        else:
            jobs += [(peer, setting) for setting in (peer.small if small else peer.settings)]
    rounds = 1 if small else ROUNDS
    answers: list[list[Answer]] = [[] for _ in jobs]
    worst = [0.0] * len(jobs)
    warm_up(jobs, problem)
    for turn in range(rounds):
        for number, job in enumerate(jobs):
            if turn < times_to_run(answers[number], rounds):
                answer = run(problem, job, turn)
                worst[number] = error(answer.displacement, exact)
                answers[number].append(Answer(answer.displacement[:, :0], answer.seconds, answer.wall))
    return rows + [row(job, kept, size) for job, kept, size in zip(jobs, answers, worst)]


def warm_up(jobs: list[Job], problem: Problem) -> None:
    """The smallest size of each peer once, so that nobody pays for imports."""
    seen: set[str] = set()
    for job in jobs:
        if job[0].name not in seen:
            job[0].solve(problem, **job[1])
        seen.add(job[0].name)


def times_to_run(answers: list[Answer], rounds: int) -> int:
    """How often, by what the first took."""
    wanted = rounds
    for limit, fewer in FEWER:
        if answers and answers[0].seconds > limit:
            wanted = min(rounds, fewer)
    return wanted


def run(problem: Problem, job: Job, turn: int) -> Answer:
    """One run, said on standard error in the first round."""
    peer, setting = job
    answer = peer.solve(problem, **setting)
    if turn == 0:
        print(f"  {peer.name}, {setting_text(setting)}: {answer.seconds:.3g} s", file=sys.stderr, flush=True)
    return answer


def row(job: Job, answers: list[Answer], size: float) -> dict[str, Any]:
    """Medians."""
    return {
        "peer": job[0].name,
        "setting": setting_text(job[1]),
        "error": float(f"{size:.3g}") if np.isfinite(size) else None,
        "cpu_seconds": float(f"{statistics.median(answer.seconds for answer in answers):.3g}"),
        "wall_seconds": float(f"{statistics.median(answer.wall for answer in answers):.3g}"),
        "runs": len(answers),
    }
