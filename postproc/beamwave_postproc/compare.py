"""Two results laid over each other."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .draw.campbell import MAX_MODES, RPM, curve_of, highest_of, over_speed
from .draw.jump import draw_jump
from .parts.curves import Curve
from .parts.labels import axis_label, in_units
from .parts.moving import folding_note
from .parts.pairs import Pair, common_points, head_of_both, names_of, pairs_of
from .parts.points import FEW, common_prefixes, error_warning, point_label, rests
from .parts.select import chosen, left_out, spread
from .parts.sheet import sheet_for
from .parts.units import si_prefix, units_of
from .result import NothingToDraw, require
from .style import COLOURS, logarithmic, say_zero, styled

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
        for ds, look, label in zip(pair.both, _looks(number, len(pairs)), _labels(pair, names)):
            frequency = ds["angular_frequency"].values / (2.0 * np.pi)
            values.append(frequency[frequency > 0.0])
            left.plot(ds["mode"], frequency, label=label, **{**look, "linestyle": ""})
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
    """Histories of both at up to three common points, each above its difference where the times are the same.

    Points at which both rest are left out, unless they do so at all.
    """
    pairs, note = _both(first, second, name, "time", "point_position")
    points = common_points(first, second)
    moving = [xi for xi in points if not all(map(rests, _values(pairs, name, xi)))] or points
    shown = [moving[i] for i in spread(len(moving), FEW)]
    prefixes = common_prefixes(
        [max(float(np.nanmax(np.abs(row), initial=0.0)) for row in _values(pairs, name, xi)) for xi in shown],
        units_of(first[name]),
    )
    alike = np.array_equal(first["time"], second["time"])
    rows = 2 * len(shown) if alike else len(shown)
    sheet = sheet_for(None, rows, height=1.9, share="x")
    clock, ticks = si_prefix(np.concatenate([first["time"].values, second["time"].values]), units_of(first["time"]))
    above = sheet.axes[::2] if alike else sheet.axes
    for axes, xi, (prefix, factor) in zip(above, shown, prefixes):
        _draw_histories(axes, pairs, names_of(first, second), name, xi, (ticks, factor))
        axes.set_ylabel(point_label(chosen(first, points=xi), name, 0, prefix))
    for axes, xi in zip(sheet.axes[1::2] if alike else [], shown):
        _draw_difference(axes, pairs, name, xi, ticks)
    sheet.axes[-1].set_xlabel(axis_label(first["time"], clock))
    sheet.axes[-1].set_xlim(0.0, ticks * max(_end(ds["time"].values) for ds in (first, second)) or 1.0)
    notes = [
        note,
        left_out(len(shown), len(points), "points"),
        "" if alike else "the times differ",
    ]
    doubts = [error_warning(side, name) for side in zip(*(pair.both for pair in pairs))]
    return sheet.finish_with(head_of_both(first, second, notes, doubts))


def _end(time: np.ndarray) -> float:
    """End of a record, one sample after the last: a round number, and a tick there, where its length is one."""
    return float(time[-1] + (time[-1] - time[-2] if time.size > 1 else 0.0))


def _values(pairs: list[Pair], name: str, xi: float) -> list[np.ndarray]:
    """All histories of the pairs at ξ."""
    return [chosen(ds, points=xi)[name][0].values for pair in pairs for ds in pair.both]


def _draw_histories(
    axes: Axes, pairs: list[Pair], names: tuple[str, str], name: str, xi: float, scales: tuple[float, float]
) -> None:
    """Both histories of each pair at ξ, times and numbers times `scales`."""
    for number, pair in enumerate(pairs):
        for ds, look, label in zip(pair.both, _looks(number, len(pairs)), _labels(pair, names)):
            history = chosen(ds, points=xi)[name][0]
            axes.plot(scales[0] * ds["time"], scales[1] * history, label=label, **{**look, "marker": ""})
    if all(map(rests, _values(pairs, name, xi))):
        say_zero(axes)


def _draw_difference(axes: Axes, pairs: list[Pair], name: str, xi: float, ticks: float) -> None:
    """B less A of each pair at ξ."""
    both = [[chosen(ds, points=xi)[name][0] for ds in pair.both] for pair in pairs]
    changes = [b.values - a.values for a, b in both]
    prefix, factor = si_prefix(np.concatenate(changes), units_of(both[0][0]))
    for number, (change, (a, _)) in enumerate(zip(changes, both)):
        axes.plot(
            ticks * a["time"], factor * change, color=COLOURS[number + 1] if len(pairs) > 1 else "0.35", linewidth=0.9
        )
    if all(map(rests, changes)):
        say_zero(axes)
    axes.set_ylabel("B − A\n" + rf"at $\xi$ = {xi:.4g}" + in_units(both[0][0], prefix))


@styled
def jumps(first: xr.Dataset, second: xr.Dataset) -> Figure:
    """The jumps in velocity of both along the beam."""
    pairs, note = _both(first, second, "velocity_jump", "profile_position")
    sheet = sheet_for(None)
    (axes,) = sheet.axes
    notes = []
    for number, pair in enumerate(pairs):
        looks = zip(pair.both, _looks(number, len(pairs)), _labels(pair, names_of(first, second)))
        for index, (ds, look, label) in enumerate(looks):
            curve = Curve(2 * number + index, ds, label, look)
            notes.append(draw_jump(axes, ds["profile_position"].values, curve))
    if all(rests(ds["velocity_jump"].values) for pair in pairs for ds in pair.both):
        say_zero(axes)
    axes.set(xlim=(0.0, 1.0), xlabel=axis_label(first["profile_position"]), ylabel=axis_label(first["velocity_jump"]))
    return sheet.finish_with(head_of_both(first, second, [note, *dict.fromkeys(notes)]))


@styled
def spectra(first: xr.Dataset, second: xr.Dataset) -> Figure:
    """The amplitude spectra of both at the last common point."""
    pairs, note = _both(first, second, "amplitude", "frequency", "point_position")
    xi = common_points(first, second)[-1]
    sheet = sheet_for(None)
    (axes,) = sheet.axes
    for number, pair in enumerate(pairs):
        for ds, look, label in zip(pair.both, _looks(number, len(pairs)), _labels(pair, names_of(first, second))):
            line = chosen(ds, points=xi)["amplitude"][0]
            axes.plot(ds["frequency"], line, label=label, **{**look, "marker": "", "linewidth": 1.0})
    axes.set(xlabel=axis_label(first["frequency"]), ylabel=axis_label(first["amplitude"]))
    highest = max(float(row.max()) for row in _values(pairs, "amplitude", xi)) or 1.0
    logarithmic(axes, "y", DEPTH * highest, 5.0 * highest)
    logarithmic(axes, "x", float(first["frequency"][1]), float(max(ds["frequency"][-1] for ds in (first, second))))
    sides = zip(names_of(first, second), (first, second), zip(*(pair.both for pair in pairs)))
    said = [(name[0], folding_note([case.assign_attrs(ds.attrs) for case in cases])) for name, ds, cases in sides]
    folding = [f"{letter}: {words}" for letter, words in said if words]
    return sheet.finish_with(head_of_both(first, second, [note, rf"at $\xi$ = {xi:.4g}", *folding]))


@styled
def campbells(first: xr.Dataset, second: xr.Dataset) -> Figure:
    """The lowest modes that both have over the angular velocity, in one diagram."""
    for ds in (first, second):
        require(ds, "angular_frequency", "mode")
    numbers = np.intersect1d(first["mode"], second["mode"])[:MAX_MODES]
    sides = [over_speed(ds, numbers) for ds in (first, second)]
    if not any((values > 0.0).any() for _, values in sides):
        raise NothingToDraw("no mode oscillates")
    sheet = sheet_for(None, height=4.4)
    (axes,) = sheet.axes
    for (speed, values), look, name in zip(sides, _looks(0, 1), names_of(first, second)):
        look = {**look, "marker": ""}
        drawn = [curve_of(speed, branch) for branch in values.T if np.isfinite(branch).sum() > 1]
        for number, (at, hertz) in enumerate(drawn):
            axes.plot(RPM * at, hertz, label="" if number else name, **look)
    top = highest_of(np.concatenate([values for _, values in sides]))
    axes.set(xlabel="Angular velocity (rpm)", ylabel="Frequency (Hz)", ylim=(0.0, top))
    axes.set_xlim(RPM * min(speed[0] for speed, _ in sides), RPM * max(speed[-1] for speed, _ in sides))
    of_modes = left_out(numbers.size, max(ds.sizes["mode"] for ds in (first, second)), "modes")
    return sheet.finish_with(head_of_both(first, second, [of_modes]))


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


def _labels(pair: Pair, names: tuple[str, str]) -> list[str]:
    """Legend texts of both results of a pair."""
    return [", ".join(filter(None, both)) for both in zip(names, pair.labels)]


COMPARED: dict[str, Callable[[xr.Dataset, xr.Dataset], Figure]] = {
    "frequencies": frequencies,
    "campbell": campbells,
    "velocity_jump": jumps,
    **{
        name: partial(histories, name=name)
        for name in ("displacement", "velocity", "acceleration", "bending_moment", "shear_force")
    },
    "spectrum": spectra,
}
