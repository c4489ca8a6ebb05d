"""What a peer is: one way to the histories, in several sizes."""

from __future__ import annotations

import functools
import time
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any, Callable

import numpy as np

from .problem import Problem

Setting = dict[str, Any]


@dataclass(frozen=True)
class Answer:
    """Displacement (points, samples), m, and what it took, s: CPU time of the one thread, and on the wall."""

    displacement: np.ndarray
    seconds: float
    wall: float


@dataclass(frozen=True)
class Peer:
    """`solve(problem, **setting)` for each of `settings`; `small` are those of a trial run."""

    name: str
    what: str  # for the table: how it gets there
    solve: Callable[..., Answer]
    settings: tuple[Setting, ...]
    small: tuple[Setting, ...]
    packages: tuple[str, ...] = field(default=())

    def missing(self) -> list[str]:
        """Packages that it needs and this Python lacks."""
        return [name for name in self.packages if find_spec(name) is None]


def timed(histories: Callable[..., np.ndarray]) -> Callable[..., Answer]:
    """Time a function from the problem's data to the histories, all in this process."""

    @functools.wraps(histories)
    def solve(problem: Problem, **setting: Any) -> Answer:
        wall, processor = time.perf_counter(), time.process_time()
        displacement = histories(problem, **setting)
        return Answer(displacement, time.process_time() - processor, time.perf_counter() - wall)

    return solve


def setting_text(setting: Setting) -> str:
    """'modes 300, eps 1e-08'."""
    return ", ".join(f"{name} {value:g}" for name, value in setting.items())
