"""Amplitude spectra of the histories, with the peaks that were measured."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.curves import Curve, Panel, panels_of
from ..parts.labels import axis_label
from ..parts.moving import folded_frequencies, folding_note
from ..parts.points import FEW, MAX_POINTS, point_label, sheet_of_points, shown_points, thinned
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given
from ..result import NothingToDraw, require
from ..style import COLOURS, logarithmic, say_zero, styled

DEPTH = 1e-9  # what lies further below the highest line is rounding, and not shown
FOLDED = {"color": COLOURS[2], "markersize": 5.0, "markeredgewidth": 1.1}  # of lines that are folded back
COLUMNS = 3  # panels of cases beside each other


@styled
def spectrum(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `amplitude` (case, point, frequency) in m against frequency in Hz, a row of panels for each point.

    Lines that are folded back from above half the sampling rate are marked, and the head says so.
    """
    ds = chosen(ds, points=points, cases=cases)
    require(ds, "amplitude", "frequency", "point_position")
    if np.count_nonzero(ds["frequency"].values > 0.0) < 2:
        raise NothingToDraw("the spectrum has fewer than two frequencies above 0")
    drawn = panels_of(ds, "amplitude", panels=COLUMNS)
    limit = ds.sizes["point"] if points is not None else MAX_POINTS if len(drawn.panels) == 1 else FEW
    shown = shown_points(ds, limit)
    sheet = sheet_of_points(ax, len(shown), len(drawn.panels))
    for row, point in zip(sheet.grid, shown):
        _draw_row(list(row), ds, drawn.panels, point)
    for axes, panel in zip(sheet.grid[0], drawn.panels):
        axes.set_title(panel.title)
    for axes in sheet.grid[-1]:
        axes.set_xlabel(axis_label(ds["frequency"]))
    measured = "measured_angular_frequency" in ds and ds["measured_angular_frequency"].notnull().any()
    peaks = "markers: measured peaks" if measured else ""
    folding = folding_note([curve.data.assign_attrs(ds.attrs) for curve in drawn.curves], "× marks them")
    return sheet.finish(ds, (*drawn.notes, thinned(ds, shown), peaks, folding))


def _draw_row(row: list[Axes], ds: xr.Dataset, panels: list[Panel], point: int) -> None:
    """Spectra of all cases at one point; the frequency 0 has no place on the axis."""
    frequency = ds["frequency"].values
    values = np.array([curve.data["amplitude"][point].values for panel in panels for curve in panel.curves])
    highest = np.nanmax(values, initial=0.0)
    for axes, panel in zip(row, panels):
        logarithmic(axes, "x", frequency[frequency > 0.0][0], frequency[-1])
        if highest > 0.0:
            logarithmic(axes, "y", DEPTH * highest, 5.0 * highest)
        else:
            say_zero(axes)
        for curve in panel.curves:
            _draw_spectrum(axes, curve, frequency, curve.data["amplitude"][point].values)
    row[0].set_ylabel(point_label(ds, "amplitude", point))


def _draw_spectrum(axes: Axes, curve: Curve, frequency: np.ndarray, row: np.ndarray) -> None:
    """One spectrum, and a marker on it at each measured frequency of its case."""
    shown = frequency > 0.0
    peaks = "measured_angular_frequency" in curve.data
    axes.plot(frequency[shown], row[shown], **{**curve.style, "marker": "", "linewidth": 0.9})
    axes.plot([], [], label=curve.label or None, **(curve.style if peaks else {**curve.style, "marker": ""}))
    folded = folded_frequencies(curve.data)
    axes.plot(folded, _highest_near(frequency, row, folded), linestyle="", marker="x", **FOLDED)
    if peaks:
        measured = curve.data["measured_angular_frequency"].values.ravel() / (2.0 * np.pi)
        measured = measured[np.isfinite(measured)]
        nearest = np.searchsorted(0.5 * (frequency[1:] + frequency[:-1]), measured)
        axes.plot(measured, row[nearest], **{**curve.style, "linestyle": ""})


def _highest_near(frequency: np.ndarray, row: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Highest of `row` at each of `places` and one frequency to either side: the line of a mode between two of them."""
    nearest = np.searchsorted(0.5 * (frequency[1:] + frequency[:-1]), places)
    around = np.clip(nearest[:, None] + np.array([-1, 0, 1]), 0, frequency.size - 1)
    return row[around].max(axis=1)
