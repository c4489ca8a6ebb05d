"""Which points of the beam a picture of histories or spectra shows, one panel each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from .labels import in_units, quantity
from .select import left_out, spread
from .sheet import Given, Sheet, sheet_for
from .units import number_text, si_prefix

MAX_POINTS = 6
SMALL = 0.01  # in a prefix: a smaller peak takes its own
FEW = 3  # panels up to which the figure stays on a screen at full height


def shown_points(ds: xr.Dataset, cases: list[xr.Dataset], name: str, limit: int | None) -> tuple[list[int], str]:
    """Indices of all points, or of `limit` of those at which `name` is given and not 0 throughout, spread evenly.

    The words say what is left out. Where no point moves all are shown.
    """
    every = list(range(ds.sizes["point"]))
    if limit is None:
        return every, ""
    values = np.array([case[name].values for case in cases])
    resting = [point for point in every if all(map(rests, values[:, point]))]
    unknown = [point for point in every if np.isnan(values[:, point]).all()]
    there = [point for point in every if point not in resting + unknown] or every
    shown = [there[i] for i in spread(len(there), limit)]
    words = [left_out(len(shown), len(there), "points that move" if len(there) < len(every) else "points")]
    for left, which in ((resting, "zero throughout"), (unknown, "not given, as the notes say,")):
        if left and len(there) < len(every):
            places = ds["point_position"].values[left]
            words.append(rf"{which} at $\xi$ = {', '.join(map(number_text, places))}")
    return shown, "; ".join(filter(None, words))


def rests(values: np.ndarray) -> bool:
    """Whether nothing but zeros is known."""
    return not np.nan_to_num(values).any() and bool(np.isfinite(values).any())


def common_prefixes(peaks: list[float], units: str) -> list[tuple[str, float]]:
    """SI prefix and factor for rows of these `peaks`: one for all, but for those that would be small numbers in it."""
    prefix, factor = si_prefix(np.array(peaks), units)
    small = [0.0 < peak * factor < SMALL for peak in peaks]
    return [si_prefix(np.array([peak]), units) if own else (prefix, factor) for peak, own in zip(peaks, small)]


def sheet_of_points(ax: Given, rows: int, columns: int) -> Sheet:
    """Axes with a row for each point, as high as the words beside it need, and a column for each panel of cases."""
    height = 3.6 if rows == 1 else 2.4 if rows <= FEW else 1.8
    return sheet_for(ax, rows, columns, width=6.4 if columns == 1 else 3.4 * columns + 0.6, height=height, share="x")


def point_label(ds: xr.Dataset, name: str, point: int, prefix: str = "") -> str:
    """Label of variable `name` at one point, in two lines: neighbours do not meet."""
    place = float(ds["point_position"][point])
    where = rf"at $\xi$ = {place:.4g}" if np.isfinite(place) else ""
    return f"{quantity(ds[name])}\n{where}{in_units(ds[name], prefix)}"


def error_note(ds: xr.Dataset, cases: list[xr.Dataset], name: str, points: list[int]) -> str:
    """The largest estimated error, over the peak at its point, where that is, and its proved bound there, if there is one.

    Empty without estimates; where one exceeds the peak `error_warning` tells it.
    """
    worst, where, bound = _worst_error(cases, name, points)
    if not 0.0 < worst <= 1.0:
        return ""
    place = rf"at $\xi$ = {float(ds['point_position'][where]):.4g}"
    single = len(cases) == 1 and len(points) == 1
    proved = f", surely below {percent(bound, up=True)}" if np.isfinite(bound) else ""
    return f"estimated error {percent(worst)} of the peak {place}{proved}" + ("" if single else ", the largest here")


def error_warning(cases: Sequence[xr.Dataset], name: str, points: Sequence[int] | None = None) -> str:
    """Warning of a history that may be nothing but error, its estimated error exceeding its peak; empty elsewhere.

    Without `points` all of them count.
    """
    worst, where, _ = _worst_error(cases, name, range(cases[0].sizes.get("point", 0)) if points is None else points)
    if worst <= 1.0:
        return ""
    place = rf"at $\xi$ = {float(cases[0]['point_position'][where]):.4g}"
    words = name.replace("_", " ")
    return f"Warning: the {words} may be nothing but error, which is estimated at {percent(worst)} of its peak {place}"


def _worst_error(cases: Sequence[xr.Dataset], name: str, points: Sequence[int]) -> tuple[float, int, float]:
    """The largest estimated error over the peak at its point, which point that is, and the bound there over the same peak.

    Without estimates the error is 0, without a bound that is NaN.
    """
    worst, where, bound = 0.0, 0, np.nan
    for case in cases:
        if f"{name}_error" not in case:
            return 0.0, 0, np.nan
        values, errors = case[name].values, case[f"{name}_error"].values
        for point in points:
            peak = np.nanmax(np.abs(values[point]), initial=0.0)
            error = float(errors[point])
            if peak > 0.0 and np.isfinite(error) and error / peak > worst:
                worst, where = error / peak, point
                bound = float(case[f"{name}_bound"][point]) / peak if f"{name}_bound" in case else np.nan
    return worst, where, bound


def percent(share: float, *, up: bool = False) -> str:
    """A share to two digits, in per cent unless it is very small; a bound is rounded up."""
    return f"{number_text(100.0 * share, 2, up=up)} %" if share >= 1e-4 else number_text(share, 2, up=up)
