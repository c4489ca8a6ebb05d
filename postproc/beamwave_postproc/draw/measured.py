"""What was measured from the histories against what the modes say, with error bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..parts.curves import Curve, panels_of
from ..parts.labels import QUANTITIES as WORDS
from ..parts.moving import is_released, last_modes
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, columns_for, sheet_for
from ..parts.units import unit_text, units_of
from ..result import NothingToDraw, require
from ..style import GREY, logarithmic, styled

QUANTITIES = ("angular_frequency", "wavenumber", "phase_velocity", "group_velocity")
ROUNDING = 1e-17  # an exact agreement is drawn here, a logarithmic axis having no 0; the head says so
CASES_WIDTH = 0.6  # taken by the cases of one mode, side by side, in modes


class Pairs(NamedTuple):
    """Peaks of one case beside the modes they belong to; arrays of one length."""

    mode: np.ndarray
    computed: np.ndarray
    measured: np.ndarray
    bound: np.ndarray


@styled
def measured(ds: xr.Dataset, name: str = "wavenumber", *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Measured against computed values of `name` with error bars, and the relative differences: two axes.

    An angular frequency is drawn in Hz. Waves are measured after the last event, so that after a release the computed
    ones are of the beam alone; raises `NothingToDraw` where the result does not hold these.
    """
    if name not in QUANTITIES:
        raise ValueError(f"{name} is not one of {', '.join(QUANTITIES)}")
    ds = chosen(ds, cases=cases)
    found, error = f"measured_{name}", f"measured_{name}_error"
    require(ds, name, found, error, "angular_frequency", "measured_angular_frequency")
    drawn = panels_of(ds, found, panels=1)
    curves = drawn.curves
    pairs = [_pairs(curve.data, name) for curve in curves]
    missing = [curve for curve in curves if last_modes(curve.data) is None]
    if len(missing) == len(curves):
        raise NothingToDraw("waves were measured after the release, and the result lacks the modes of the beam alone")
    if not any(pair.mode.size for pair in pairs):
        raise NothingToDraw(f"no peak has a {found} that belongs to a mode")
    sheet = sheet_for(ax, 2 // columns_for(2), columns_for(2), width=9.6)
    left, right = sheet.axes
    _draw_equality(left, pairs)
    for curve, pair in zip(curves, pairs):
        style = {**curve.style, "linestyle": ""}
        left.errorbar(pair.computed, pair.measured, pair.bound, capsize=3, label=curve.label or "peaks", **style)
    _draw_differences(right, curves, pairs)
    label, units = WORDS[name], unit_text(units_of(ds[name]))
    if name == "angular_frequency":
        label, units = "Frequency", "Hz"
    words = label[0].lower() + label[1:]
    left.set(xlabel=f"Computed {words} ({units})", ylabel=f"Measured {words} ({units})")
    right.set(xlabel="Mode", ylabel=f"Relative difference\nof the {words}")
    return sheet.finish(ds, [*drawn.notes, _about_release(curves, missing), _about_zero(pairs)])


def _about_zero(pairs: list[Pairs]) -> str:
    """That a place on the axis stands for zero, where a marker is on it."""
    equal = any(((pair.measured == pair.computed) | (pair.bound == 0.0)).any() for pair in pairs)
    return "a difference or bound at 10⁻¹⁷ stands for zero" if equal else ""


def _about_release(curves: list[Curve], missing: list[Curve]) -> str:
    """Which modes are computed, where a release decides that, and which cases lack them."""
    released = [curve for curve in curves if is_released(curve.data)]
    if not released:
        return ""
    of = "" if len(released) == len(curves) else f" of {len(released)} of {len(curves)} cases"
    words = f"measured{of} after the release, computed for the beam alone"
    gone = ", ".join(curve.label for curve in missing)
    return f"{words}; not drawn, as its modes are not in the file: {gone}" if gone else words


def _pairs(case: xr.Dataset, name: str) -> Pairs:
    """Match each peak that has a measured `name` with the mode nearest in frequency, of those that move then."""
    empty = Pairs(*(np.empty(0),) * 4)
    last = last_modes(case)
    if last is None or name not in last:
        return empty
    beta = last["angular_frequency"].values
    measured_beta = case["measured_angular_frequency"].values
    values, bound = case[f"measured_{name}"].values, case[f"measured_{name}_error"].values
    known = np.isfinite(measured_beta) & np.isfinite(values) & np.isfinite(bound)
    modes = np.isfinite(beta) & (last[name].values > 0.0)
    if not (known.any() and modes.any()):
        return empty
    nearest = np.abs(beta[modes][None, :] - measured_beta[known][:, None]).argmin(axis=1)
    mode, computed = last["mode"].values[modes], last[name].values[modes]
    scale = 1.0 / (2.0 * np.pi) if name == "angular_frequency" else 1.0
    return Pairs(mode[nearest], scale * computed[nearest], scale * values[known], scale * bound[known])


def _draw_equality(axes: Axes, pairs: list[Pairs]) -> None:
    """Line on which measured and computed agree, over the range of what was computed."""
    computed = np.concatenate([pair.computed for pair in pairs])
    ends = np.array([0.8 * computed.min(), 1.25 * computed.max()])
    logarithmic(axes, "x", *ends)
    logarithmic(axes, "y", *ends)
    axes.plot(ends, ends, color=GREY, linewidth=0.9, label="measured = computed")


def _draw_differences(axes: Axes, curves: list[Curve], pairs: list[Pairs]) -> None:
    """Relative differences as markers, each under the bar of its bound; the cases side by side."""
    drawn: list[np.ndarray] = []
    for number, (curve, pair) in enumerate(zip(curves, pairs)):
        scale = np.abs(pair.computed)
        difference = np.maximum(np.abs(pair.measured - pair.computed) / scale, ROUNDING)
        bound = np.maximum(pair.bound / scale, ROUNDING)
        drawn.extend((difference, bound))
        x = pair.mode + CASES_WIDTH * ((number + 0.5) / len(curves) - 0.5)
        first = number == 0
        bar = {"linestyle": "", "marker": "_", "markersize": 9, "color": curve.style["color"]}
        axes.vlines(x, difference, bound, color=curve.style["color"], linewidth=0.8)
        axes.plot(x, bound, label="error bound" if first else None, **bar)
        axes.plot(x, difference, label="difference" if first else None, **{**curve.style, "linestyle": ""})
    sizes = np.concatenate(drawn)
    logarithmic(axes, "y", 0.3 * sizes.min(), 10.0 * sizes.max())
    modes = np.concatenate([pair.mode for pair in pairs])
    axes.set_xlim(modes.min() - 0.7, modes.max() + 0.7)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
