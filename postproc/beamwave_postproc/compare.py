"""Two results laid over each other."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .parts.labels import axis_label
from .parts.moving import folding_note
from .parts.pairs import Pair, common_points, head_of_both, names_of, pairs_of
from .parts.points import FEW, point_label
from .parts.select import chosen, spread
from .parts.sheet import Sheet, sheet_for
from .parts.units import si_prefix, units_of
from .result import NothingToDraw, require
from .style import COLOURS, logarithmic, styled

DEPTH = 1e-9  # of the highest line of a spectrum, that is shown
CHANGES = {
    "angular_frequency": ("frequency", "o"),
    "phase_velocity": ("phase velocity", "s"),
    "group_velocity": ("group velocity", "^"),
}


def compare(first: xr.Dataset, second: xr.Dataset) -> dict[str, Figure]:
    """Pictures of two results laid over each other, by kind: what both hold the numbers for.

    The first is A, drawn in full, the second B, dashed or open. Of sweeps over the same values up to four cases are
    drawn, of other sweeps the first case. Raises `NothingToDraw` where the two have nothing in common.
    """
    drawn = {}
    for kind, draw in COMPARED.items():
        try:
            drawn[kind] = draw(chosen(first), chosen(second))
        except NothingToDraw:
            continue
    if not drawn:
        raise NothingToDraw("the two results have nothing in common to draw")
    return drawn


@styled
def frequencies(first: xr.Dataset, second: xr.Dataset) -> Figure:
    """Frequencies of the modes of both, and the changes of frequency and wave velocities from A to B."""
    pairs, note = _both(first, second, "angular_frequency", "mode")
    sheet = sheet_for(None, columns=2, width=9.6, height=3.8)
    left, right = sheet.axes
    names = names_of(first, second)
    values = []
    for number, pair in enumerate(pairs):
        for ds, look, name in zip(pair[1:], _looks(number, len(pairs)), names):
            frequency = ds["angular_frequency"].values / (2.0 * np.pi)
            values.append(frequency[frequency > 0.0])
            left.plot(ds["mode"], frequency, label=_label(pair, name), **{**look, "linestyle": ""})
        _draw_changes(right, pair, number, len(pairs))
    found = np.concatenate(values)
    if not found.size:
        raise NothingToDraw("no mode oscillates")
    logarithmic(left, "y", 0.6 * found.min(), 1.6 * found.max())
    left.set(xlabel="Mode", ylabel="Frequency (Hz)")
    right.set(xlabel="Mode", ylabel="Change from A to B (%)")
    right.axhline(0.0, color="0.5", linewidth=0.8, zorder=0)
    for axes in sheet.axes:
        axes.set_xlim(0.5, max(ds.sizes["mode"] for ds in (first, second)) + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    return sheet.finish_with(head_of_both(first, second, [note]))


def _draw_changes(axes: Axes, pair: Pair, number: int, pairs: int) -> None:
    """Relative changes by mode; of several pairs that of the frequency alone."""
    for name, (words, marker) in CHANGES.items():
        if name not in pair.first or name not in pair.second or (pairs > 1 and name != "angular_frequency"):
            continue
        a, b = xr.align(pair.first[name], pair.second[name], join="inner")
        change = 100.0 * (b.values / a.values - 1.0)
        colour = COLOURS[number + 1] if pairs > 1 else COLOURS[1 + list(CHANGES).index(name)]
        label = None if pairs > 1 else words
        axes.plot(a["mode"], change, color=colour, marker=marker, markerfacecolor="white", linestyle="", label=label)


@styled
def histories(first: xr.Dataset, second: xr.Dataset, name: str = "displacement") -> Figure:
    """Histories of both at up to three common points, each above its difference where the times are the same."""
    pairs, note = _both(first, second, name, "time", "point_position")
    points = common_points(first, second)
    shown = [points[i] for i in spread(len(points), FEW)]
    alike = np.array_equal(first["time"], second["time"])
    rows = 2 * len(shown) if alike else len(shown)
    sheet = sheet_for(None, rows, height=1.9, share="x")
    clock, ticks = si_prefix(np.concatenate([first["time"].values, second["time"].values]), units_of(first["time"]))
    above = sheet.axes[::2] if alike else sheet.axes
    for axes, xi in zip(above, shown):
        _draw_histories(axes, pairs, names_of(first, second), name, xi, ticks)
    for axes, xi in zip(sheet.axes[1::2] if alike else [], shown):
        _draw_difference(axes, pairs, name, xi, ticks)
    sheet.axes[-1].set_xlabel(axis_label(first["time"], clock))
    sheet.axes[-1].set_xlim(0.0, ticks * max(_end(ds["time"].values) for ds in (first, second)) or 1.0)
    notes = [
        note,
        f"{len(shown)} of {len(points)} points" if len(shown) < len(points) else "",
        "" if alike else "the times differ",
    ]
    return sheet.finish_with(head_of_both(first, second, notes))


def _end(time: np.ndarray) -> float:
    """End of a record, one sample after the last: a round number, and a tick there, where its length is one."""
    return float(time[-1] + (time[-1] - time[-2] if time.size > 1 else 0.0))


def _draw_histories(axes: Axes, pairs: list[Pair], names: tuple[str, str], name: str, xi: float, ticks: float) -> None:
    """Both histories of each pair at ξ."""
    both = [[chosen(ds, points=xi) for ds in pair[1:]] for pair in pairs]
    prefix, factor = si_prefix(
        np.concatenate([ds[name].values.ravel() for two in both for ds in two]), units_of(both[0][0][name])
    )
    for number, (pair, two) in enumerate(zip(pairs, both)):
        for ds, look, letter in zip(two, _looks(number, len(pairs)), names):
            axes.plot(ticks * ds["time"], factor * ds[name][0], label=_label(pair, letter), **{**look, "marker": ""})
    axes.set_ylabel(point_label(both[0][0], name, 0, prefix))


def _draw_difference(axes: Axes, pairs: list[Pair], name: str, xi: float, ticks: float) -> None:
    """B less A of each pair at ξ."""
    both = [[chosen(ds, points=xi)[name][0] for ds in pair[1:]] for pair in pairs]
    changes = [b.values - a.values for a, b in both]
    prefix, factor = si_prefix(np.concatenate(changes), units_of(both[0][0]))
    for number, (change, (a, _)) in enumerate(zip(changes, both)):
        axes.plot(
            ticks * a["time"], factor * change, color=COLOURS[number + 1] if len(pairs) > 1 else "0.35", linewidth=0.9
        )
    axes.set_ylabel(f"B − A ({prefix}{units_of(both[0][0])})\n" + rf"at $\xi$ = {xi:.4g}")


@styled
def jumps(first: xr.Dataset, second: xr.Dataset) -> Figure:
    """The jumps in velocity of both along the beam."""
    pairs, note = _both(first, second, "velocity_jump", "profile_position")
    sheet = _overlay(first, second, pairs, "velocity_jump", "profile_position")
    sheet.axes[0].set_xlim(0.0, 1.0)
    return sheet.finish_with(head_of_both(first, second, [note]))


@styled
def spectra(first: xr.Dataset, second: xr.Dataset) -> Figure:
    """The amplitude spectra of both at the last common point."""
    pairs, note = _both(first, second, "amplitude", "frequency", "point_position")
    xi = common_points(first, second)[-1]
    at_point = [Pair(pair.label, *(chosen(ds, points=xi).isel(point=0) for ds in pair[1:])) for pair in pairs]
    sheet = _overlay(first, second, at_point, "amplitude", "frequency")
    highest = max(float(ds["amplitude"].max()) for pair in at_point for ds in pair[1:]) or 1.0
    logarithmic(sheet.axes[0], "y", DEPTH * highest, 5.0 * highest)
    logarithmic(
        sheet.axes[0], "x", float(first["frequency"][1]), float(max(ds["frequency"][-1] for ds in (first, second)))
    )
    sides = zip(names_of(first, second), (first, second), zip(*(pair[1:] for pair in pairs)))
    said = [(name[0], folding_note([case.assign_attrs(ds.attrs) for case in cases])) for name, ds, cases in sides]
    folding = [f"{letter}: {words}" for letter, words in said if words]
    return sheet.finish_with(head_of_both(first, second, [note, rf"at $\xi$ = {xi:.4g}", *folding]))


def _overlay(first: xr.Dataset, second: xr.Dataset, pairs: list[Pair], name: str, along: str) -> Sheet:
    """Variable `name` of both over `along`, on one pair of axes."""
    sheet = sheet_for(None)
    axes = sheet.axes[0]
    for number, pair in enumerate(pairs):
        for ds, look, letter in zip(pair[1:], _looks(number, len(pairs)), names_of(first, second)):
            axes.plot(ds[along], ds[name], label=_label(pair, letter), **{**look, "marker": "", "linewidth": 1.0})
    axes.set(xlabel=axis_label(first[along]), ylabel=axis_label(first[name]))
    return sheet


def _both(first: xr.Dataset, second: xr.Dataset, *names: str) -> tuple[list[Pair], str]:
    """The pairs of two results that both hold `names`."""
    for ds in (first, second):
        require(ds, *names)
    return pairs_of(first, second)


def _looks(number: int, pairs: int) -> tuple[dict, dict]:
    """Look of A, in full, and of B, dashed: of a single pair in two colours, else in the colour of the pair."""
    one, other = (COLOURS[0], COLOURS[2]) if pairs == 1 else (COLOURS[number + 1],) * 2
    return (
        {"color": one, "linestyle": "-", "marker": "o", "markersize": 5.0, "linewidth": 1.2},
        {
            "color": other,
            "linestyle": (0, (4, 2)),
            "marker": "D",
            "markersize": 6.5,
            "markerfacecolor": "none",
            "linewidth": 1.2,
        },
    )


def _label(pair: Pair, name: str) -> str:
    """Legend text of one result of a pair."""
    return f"{name}, {pair.label}" if pair.label else name


COMPARED: dict[str, Callable[[xr.Dataset, xr.Dataset], Figure]] = {
    "frequencies": frequencies,
    "velocity_jump": jumps,
    **{name: partial(histories, name=name) for name in ("displacement", "velocity", "bending_moment")},
    "spectrum": spectra,
}
