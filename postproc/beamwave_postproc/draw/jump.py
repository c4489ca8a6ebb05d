"""The jump in velocity along the beam at the impact (Fig. 3)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.curves import Curve, panels_of, where_it_varies
from ..parts.labels import axis_label
from ..parts.places import mark_places
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import markers_to_end, say_zero, styled

SAMPLES_PER_WAVE = 6  # of the shortest wave, that a line through the samples shows its form


@styled
def velocity_jump(ds: xr.Dataset, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `velocity_jump` (case, profile) in m/s against the position ξ along the beam.

    One whose waves have too few samples is drawn as samples alone, with a note. Inputs of a sweep that do not change it
    make no curves. Raises `NothingToDraw` where of infinitely many modes (`modes%tolerance`) the struck place alone jumps.
    """
    ds = chosen(ds, cases=cases)
    require(ds, "velocity_jump", "profile_position")
    varying, same = where_it_varies(ds, "velocity_jump")
    drawn = panels_of(varying, "velocity_jump")
    if all(np.count_nonzero(curve.data["velocity_jump"].values) == 1 for curve in drawn.curves):
        raise NothingToDraw("of infinitely many modes the struck place alone jumps: modes by counts show a form")
    sheet = sheet_for(ax, len(drawn.panels), height=4.0 if len(drawn.panels) == 1 else 2.6, share="x")
    position = ds["profile_position"].values
    notes = [same, *drawn.notes]
    for axes, panel in zip(sheet.axes, drawn.panels):
        notes += [draw_jump(axes, position, curve) for curve in panel.curves]
        mark_places(axes, ds, "x", first=True)
        axes.set_title(panel.title)
        axes.set_ylabel(axis_label(ds["velocity_jump"]))
        axes.set_xlim(position.min(), position.max())
        if not any(curve.data["velocity_jump"].values.any() for curve in panel.curves):
            say_zero(axes)
    sheet.axes[-1].set_xlabel(axis_label(ds["profile_position"]))
    return sheet.finish(ds, dict.fromkeys(notes))


def draw_jump(axes: Axes, position: np.ndarray, curve: Curve) -> str:
    """One case as its line, or where a line would invent a form as marks; what has to be said of it."""
    jump = curve.data["velocity_jump"].values
    whole = {"label": curve.label or None, "clip_on": False}  # the markers at the tip are whole
    if np.count_nonzero(jump) <= 1:
        return _draw_place(axes, position, jump, curve)
    if _coarse(curve.data, position):
        axes.plot(position, jump, **whole, **{**curve.style, "linestyle": "", "markersize": 2.5})
        return f"{position.size} samples do not show {_modes(curve.data)} modes: give more by impact%profile_points"
    axes.plot(position, jump, markevery=markers_to_end(curve.index, position.size), **whole, **curve.style)
    return ""


def _draw_place(axes: Axes, position: np.ndarray, jump: np.ndarray, curve: Curve) -> str:
    """A jump of one place as a mark above the line of all that rests; what has to be said of it."""
    axes.plot(
        position,
        np.zeros(position.size),
        label=None if jump.any() else curve.label or None,
        **{**curve.style, "marker": ""},
    )
    if not jump.any():
        return f"no jump: {curve.label}" if curve.label else "no jump"
    there = np.flatnonzero(jump)
    axes.vlines(position[there], 0.0, jump[there], color=curve.style["color"], linewidth=0.8, linestyle=":")
    axes.plot(
        position[there], jump[there], label=curve.label or None, clip_on=False, **{**curve.style, "linestyle": ""}
    )
    return "of infinitely many modes: the struck place alone jumps"


def _coarse(case: xr.Dataset, position: np.ndarray) -> bool:
    """Whether the shortest of the modes that jump has too few samples to each of its waves."""
    return _modes(case) / 2.0 * SAMPLES_PER_WAVE > position.size - 1


def _modes(case: xr.Dataset) -> int:
    """Number of modes that jump: half as many waves lie on the beam in the last of them."""
    velocity = case.get("modal_velocity_before", case.get("modal_velocity"))
    return int(np.isfinite(velocity.values).sum()) if velocity is not None else 0
