"""Ways to the same histories: error against seconds of each, in a table and a work–precision diagram."""

from __future__ import annotations

import functools
import time
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any, Callable, NamedTuple, Sequence

import matplotlib as mpl
import numpy as np
from beamwave_postproc.style import COLOURS, RC
from common.bench import Rows
from common.document import table
from common.measuring import in_turns, median, rounded
from matplotlib.axes import Axes
from matplotlib.figure import Figure

ROUNDS = 11
FEWER = ((0.3, 5), (1.0, 3), (5.0, 1))  # what takes longer than this, s, is run so many times only
ROOM_FOR_WORDS = 12
BEHIND_WORDS = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
LINE, DASHED = "-", (0, (4, 2))


class Answer(NamedTuple):
    """What it took, s: CPU time of the one thread, and on the wall; displacement (points, samples), m."""

    seconds: float
    wall: float
    displacement: np.ndarray


@dataclass(frozen=True)
class Peer:
    """`solve(problem, **setting)` in sizes: each name with its values, `small` being those of a trial run."""

    name: str
    what: str  # for the table: how it gets there
    solve: Callable[..., Answer]
    settings: dict[str, Sequence[float]]
    small: dict[str, Sequence[float]]
    packages: tuple[str, ...] = field(default=())

    def sizes(self, small: bool) -> list[dict[str, Any]]:
        """All settings, from the coarsest."""
        chosen = self.small if small else self.settings
        return [dict(zip(chosen, values)) for values in zip(*chosen.values())]

    def missing(self) -> list[str]:
        """Packages that it needs and this Python lacks."""
        return [name for name in self.packages if find_spec(name) is None]


class Curve(NamedTuple):
    """How a peer is drawn: look, words, at which of its sizes they are, how far from it in points, alignment."""

    colour: str
    dash: Any
    marker: str
    words: str
    size: int
    offset: tuple[int, int]
    aligned: str


def own_curve(words: str, size: int, offset: tuple[int, int], aligned: str, dash: Any = LINE) -> Curve:
    """A curve of the program itself."""
    return Curve(COLOURS[2], dash, "o", words, size, offset, aligned)


def timed(histories: Callable[..., np.ndarray]) -> Callable[..., Answer]:
    """Time a function from the problem's data to the histories, all in this process."""

    @functools.wraps(histories)
    def solve(problem: Any, **setting: Any) -> Answer:
        wall, processor = time.perf_counter(), time.process_time()
        displacement = histories(problem, **setting)
        return Answer(time.process_time() - processor, time.perf_counter() - wall, displacement)

    return solve


def error(displacement: np.ndarray, exact: np.ndarray) -> float:
    """The largest error of any point's history over that history's peak; nan where the history has one."""
    return float(np.max(np.max(np.abs(displacement - exact), axis=1) / np.max(np.abs(exact), axis=1)))


def measure(peers: tuple[Peer, ...], problem: Any, exact: np.ndarray, small: bool) -> Rows:
    """One row for each peer and size; a peer whose packages are missing has one row that says so."""
    able = [peer for peer in peers if not peer.missing()]
    rows = [{"peer": peer.name, "not_measured": f"no {', '.join(peer.missing())}"} for peer in peers if peer not in able]
    for peer in able:  # nobody pays for imports
        peer.solve(problem, **peer.sizes(small)[0])
    jobs = [(peer, setting) for peer in able for setting in peer.sizes(small)]

    def run(job: tuple[Peer, dict[str, Any]]) -> tuple[float, float, float]:
        answer = job[0].solve(problem, **job[1])
        return answer.seconds, answer.wall, error(answer.displacement, exact)

    def name(job: tuple[Peer, dict[str, Any]]) -> str:
        return f"{job[0].name}, {setting_text(job[1])}"

    for (peer, setting), runs in zip(jobs, in_turns(jobs, run, 1 if small else ROUNDS, name, FEWER)):
        seconds, wall, errors = zip(*runs)
        rows.append({
            "peer": peer.name,
            "setting": setting_text(setting),
            "error": rounded(errors[-1]) if np.isfinite(errors[-1]) else None,
            "cpu_seconds": median(seconds),
            "wall_seconds": median(wall),
            "runs": len(runs),
        })
    return rows


def setting_text(setting: dict[str, Any]) -> str:
    """'modes 300, eps 1e-08'."""
    return ", ".join(f"{name} {value:g}" for name, value in setting.items())


def seconds_to_reach(rows: Rows, level: float) -> float | None:
    """Seconds of the cheapest way to an error of at most `level`: a size, or between two sizes by a power law."""
    found = [row["cpu_seconds"] for row in rows if row["error"] <= level]
    for worse, better in zip(rows, rows[1:]):
        if worse["error"] > level >= better["error"]:
            part = np.log(worse["error"] / level) / np.log(worse["error"] / better["error"])
            found.append(worse["cpu_seconds"] * (better["cpu_seconds"] / worse["cpu_seconds"]) ** part)
    return float(min(found)) if found else None


def summary(rows: Rows, peers: tuple[Peer, ...], levels: tuple[float, ...]) -> str:
    """Seconds that each peer takes to an error."""
    body = [["peer", "how", *(f"s to {level:.0e}".replace("e-0", "e-") for level in levels), "smallest error"]]
    for peer in peers:
        own = [row for row in rows if row["peer"] == peer.name]
        if not own:
            continue
        if "not_measured" in own[0]:
            body.append([peer.name, peer.what, *("not measured" for _ in levels), own[0]["not_measured"]])
            continue
        known = [row for row in own if row["error"] is not None]
        smallest = f"{min(row['error'] for row in known):.1e}" if known else "none"
        times = [seconds_to_reach(known, level) for level in levels]
        body.append([peer.name, peer.what, *("–" if t is None else f"{t:.2g}" for t in times), smallest])
    return table(body)


def details(rows: Rows) -> str:
    """Every size."""
    body = [["peer", "size", "error over peak", "CPU s", "runs"]]
    for row in rows:
        if "not_measured" not in row:
            size = "overflow" if row["error"] is None else f"{row['error']:.1e}"
            body.append([row["peer"], row["setting"], size, f"{row['cpu_seconds']:.2g}", str(row["runs"])])
    return table(body)


def diagram(rows: Rows, curves: dict[str, Curve], title: str) -> Figure:
    """Error over peak against CPU seconds."""
    with mpl.rc_context({**RC, "font.size": 10.0}):
        figure = Figure(figsize=(8.6, 5.8), layout="constrained")
        axes = figure.subplots()
        axes.set(xscale="log", yscale="log")
        for name, curve in curves.items():
            draw_curve(axes, [row for row in rows if row["peer"] == name and row.get("error")], curve)
        axes.set_xlabel("CPU time of one thread (s)")
        axes.set_ylabel("Largest error of the displacement over its peak")
        left, right = axes.get_xlim()
        axes.set_xlim(left / ROOM_FOR_WORDS, right)
        axes.set_ylim(bottom=axes.get_ylim()[0] / 3)
        axes.set_title(title, loc="left", fontsize=10)
    return figure


def draw_curve(axes: Axes, rows: Rows, look: Curve) -> None:
    """One peer with its words; a small run has fewer sizes."""
    if not rows:
        return
    seconds, errors = [row["cpu_seconds"] for row in rows], [row["error"] for row in rows]
    style = {"linestyle": look.dash, "marker": look.marker, "markerfacecolor": "white", "linewidth": 1.6}
    axes.plot(seconds, errors, color=look.colour, **style)
    size = max(-len(rows), min(look.size, len(rows) - 1))
    axes.annotate(
        look.words, (seconds[size], errors[size]), xytext=look.offset, textcoords="offset points",
        ha=look.aligned, va="center", color=look.colour, fontsize=9, bbox=BEHIND_WORDS)
