"""Histories that grow without bound, drawn so that what stays bounded is seen."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from .labels import how_it_ended
from .units import number_text, with_unit

GROWN = 4.0  # growth rate × duration beyond which a linear axis shows little of the start: fiftyfold
START = 50  # a growing history has this part of its samples, at its start, on the linear part of the axis
LINEAR_SHARE = 4.0  # decades of the axis to one of its linear part, on either side of 0
ROOM = 1.2  # times the largest number of the linear part, that it ends beyond it
MARGIN = 0.03  # of the decades, kept free beyond the largest number
LARGEST = 307.9  # common logarithm of the end of an axis at the latest: the next decades are infinite
LABELS = 6  # decades that are labelled on either side of 0


def grows(case: xr.Dataset) -> bool:
    """Whether a mode of `case` is unstable and has the time to grow out of any linear axis."""
    if "growth_rate" not in case or "time" not in case:
        return False
    rates = case["growth_rate"].values
    duration = np.ptp(case["time"].values)
    return bool(np.any(np.nan_to_num(rates) * duration > GROWN))


def samples_held(case: xr.Dataset, name: str) -> int:
    """Return the number of samples up to the last that is not fill, at any point: what overflows is fill."""
    held = np.isfinite(case[name].values).any(axis=0)
    return int(np.flatnonzero(held)[-1]) + 1 if held.any() else 0


def growth_note(cases: list[xr.Dataset], name: str) -> str:
    """What a history that grows does to a picture of `name`; empty where none does."""
    growing = [case for case in cases if grows(case)]
    if not growing:
        return ""
    some = f"{len(growing)} of these " if len(growing) < len(cases) else ""
    words = f"{some}unstable: symmetric logarithmic scale"
    held = [samples_held(case, name) for case in growing]
    if min(held) == growing[0].sizes["time"]:
        return words
    return f"{words}; numbers overflow after {number_text(float(growing[0]['time'][max(min(held) - 1, 0)]), 3)} s"


def end_note(cases: list[xr.Dataset], name: str) -> str:
    """When the numbers of a bounded history end before its record does, and why; empty where none does."""
    ending = [case for case in cases if not grows(case) and 0 < samples_held(case, name) < case.sizes["time"]]
    if not ending:
        return ""
    last = [float(case["time"][samples_held(case, name) - 1]) for case in ending]
    some = f" of {len(ending)} of these" if len(ending) < len(cases) else ""
    return f"the numbers{some} end at {with_unit(min(last), 's', 3)}{how_it_ended(ending[0])}"


def scale_for_growth(axes: Axes, rows: np.ndarray, growing: list[bool]) -> None:
    """Symmetric logarithmic y axis for `rows` (curve, time): linear where the bounded ones are, or the start."""
    sizes = np.abs(rows[:, : max(int(np.isfinite(rows).any(axis=0).sum()), 1)])
    bounded = sizes[~np.array(growing)]
    start = bounded if bounded.size else sizes[:, : max(sizes.shape[1] // START, 2)]
    linear = ROOM * np.nanmax(start, initial=0.0) or np.nanmin(sizes[sizes > 0.0], initial=np.inf)
    highest = np.nanmax(sizes)
    if not 0.0 < linear < highest:
        return
    decades = np.log10(highest) - np.log10(linear)
    axes.set_ylim(-_end(-np.nanmin(rows), linear), _end(np.nanmax(rows), linear))
    axes.set_yscale("symlog", linthresh=linear, linscale=max(decades / LINEAR_SHARE, 1.0))
    _label_decades(axes, linear, decades)


def _end(largest: float, linear: float) -> float:
    """End of one side of the axis, a little beyond its `largest` number, or where the linear part ends."""
    if largest <= linear:
        return linear
    beyond = np.log10(largest) + MARGIN * (np.log10(largest) - np.log10(linear))
    return float(10.0 ** min(beyond, LARGEST))


def _label_decades(axes: Axes, linear: float, decades: float) -> None:
    """Ticks at 0 and at a few powers of ten beyond the linear part, on both sides where the axis has them."""
    step = max(int(np.ceil(decades / LABELS)), 1)
    bottom, top = axes.get_ylim()
    ticks = {0.0: "0"}
    for power in range(int(np.ceil(np.log10(linear))), int(np.log10(max(top, -bottom))) + 1, step):
        size = 10.0**power
        ticks.update({size: f"$10^{{{power}}}$"} if size < top else {})
        ticks.update({-size: f"$-10^{{{power}}}$"} if size < -bottom else {})
    axes.set_yticks(list(ticks), list(ticks.values()))
    axes.yaxis.set_minor_locator(NullLocator())
