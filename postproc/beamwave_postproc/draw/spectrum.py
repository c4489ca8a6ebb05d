"""Amplitude spectra of the histories, with the peaks that were measured."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.curves import Curve, Panel, panels_of
from ..parts.growth import grows
from ..parts.labels import axis_label
from ..parts.moving import folded_frequencies, folding_note
from ..parts.points import FEW, MAX_POINTS, error_warning, point_label, sheet_of_points, shown_points
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given
from ..parts.tail import spectrum_after_events
from ..result import NothingToDraw, require
from ..style import COLOURS, logarithmic, say_zero, styled, write_in_middle

DEPTH = 1e-9  # what lies further below the highest line is rounding, and not marked
BELOW = 3.0  # times that depth, to which the axis reaches so that no marker is cut
FOLDED = {"color": COLOURS[2], "markersize": 5.0, "markeredgewidth": 1.1}  # of lines that are aliased
COLUMNS = 3  # panels of cases beside each other
Tail = tuple[np.ndarray, np.ndarray, str]  # frequencies, amplitudes (point, frequency), what they are of
BEYOND = 0.012  # of the axis of frequencies, beyond the last: half a marker
ALIKE = 1e3  # times the smallest of the panels' highest lines, up to which a row has one scale


@styled
def spectrum(ds: xr.Dataset, points: Chosen = None, *, cases: Chosen = None, ax: Given = None) -> Figure:
    """Draw `amplitude` (case, point, frequency) in m against frequency in Hz, a row of panels for each point.

    Where something happens within the record the spectrum is that of the samples after the last event.

    Lines that are aliased from above half the sampling rate are marked, and the head says so. Of a motion that
    grows the spectrum is that of the growth, and not drawn: raises `NothingToDraw` where all grow.
    """
    ds = chosen(ds, points=points, cases=cases)
    require(ds, "amplitude", "frequency", "point_position")
    if "noise_level" in ds:
        raise NothingToDraw("the spectrum of a record is drawn by record_spectrum")
    if np.count_nonzero(ds["frequency"].values > 0.0) < 2:
        raise NothingToDraw("the spectrum has fewer than two frequencies above 0")
    drawn = panels_of(ds, "amplitude", panels=COLUMNS)
    panels, growing = _bounded(drawn.panels)
    tails = {id(curve): spectrum_after_events(curve.data) for panel in panels for curve in panel.curves}
    cases = [curve.data for panel in panels for curve in panel.curves]
    limit = None if points is not None else MAX_POINTS if len(panels) == 1 else FEW
    shown, left = shown_points(ds, cases, "amplitude", limit)
    sheet = sheet_of_points(ax, len(shown), len(panels))
    for row, point in zip(sheet.grid, shown):
        _draw_row(list(row), ds, panels, point, tails)
    for axes, panel in zip(sheet.grid[0], panels):
        axes.set_title(panel.title)
    for axes in sheet.grid[-1]:
        axes.set_xlabel(axis_label(ds["frequency"]))
    measured = "measured_angular_frequency" in ds and ds["measured_angular_frequency"].notnull().any()
    peaks = "markers: measured peaks" if measured else ""
    folding = folding_note([case.assign_attrs(ds.attrs) for case in cases], "×")
    warning = error_warning(cases, "displacement", shown)
    parts = list(dict.fromkeys(words for _, _, words in tails.values()))
    part = parts[0] if len(parts) == 1 else "of the samples after the last event of each case"
    return sheet.finish(ds, (*drawn.notes, part, left, growing, peaks, folding), warning=warning)


def _bounded(panels: list[Panel]) -> tuple[list[Panel], str]:
    """The panels without the cases that grow, and how many those are; raises `NothingToDraw` where all grow."""
    kept = [Panel(panel.title, [curve for curve in panel.curves if not grows(curve.data)]) for panel in panels]
    count, left = (sum(len(panel.curves) for panel in some) for some in (panels, kept))
    if not left:
        raise NothingToDraw("a motion that grows has no spectrum worth a picture")
    gone = count - left
    return kept, f"{gone} of these {'grows and has' if gone == 1 else 'grow and have'} no spectrum" if gone else ""


def _draw_row(row: list[Axes], ds: xr.Dataset, panels: list[Panel], point: int, tails: dict[int, Tail]) -> None:
    """Spectra of all cases at one point, with one scale where that suits all; the frequency 0 has no place on it."""
    lowest, last = max((frequency[1] for frequency, _, _ in tails.values()), default=1.0), float(ds["frequency"][-1])
    rows = [[tails[id(curve)][1][point] for curve in panel.curves] for panel in panels]
    peaks = [max((float(np.nanmax(one, initial=0.0)) for one in some), default=0.0) for some in rows]
    alike = max(peaks) < ALIKE * min(filter(None, peaks), default=1.0)
    for axes, panel, peak in zip(row, panels, peaks):
        highest = max(peaks) if alike else peak
        logarithmic(axes, "x", lowest, last * (last / lowest) ** BEYOND)
        if not panel.curves:
            axes.set_yticks([])
            write_in_middle(axes, "all grow")
        elif highest > 0.0:
            logarithmic(axes, "y", DEPTH / BELOW * highest, 5.0 * highest)
        else:
            say_zero(axes)
        for curve in panel.curves:
            frequency, amplitude, _ = tails[id(curve)]
            _draw_spectrum(axes, curve, frequency, amplitude[point], DEPTH * highest)
    row[0].set_ylabel(point_label(ds, "amplitude", point))


def _draw_spectrum(axes: Axes, curve: Curve, frequency: np.ndarray, row: np.ndarray, least: float) -> None:
    """One spectrum, and a marker on it at each measured frequency of its case where it is not below `least`."""
    shown = frequency > 0.0
    peaks = "measured_angular_frequency" in curve.data
    axes.plot(frequency[shown], row[shown], **{**curve.style, "marker": "", "linewidth": 0.9})
    axes.plot([], [], label=curve.label or None, **(curve.style if peaks else {**curve.style, "marker": ""}))
    folded = folded_frequencies(curve.data)
    if not row.any():
        return
    _mark(axes, folded, _highest_near(frequency, row, folded), least, marker="x", **FOLDED)
    if peaks:
        measured = curve.data["measured_angular_frequency"].values.ravel() / (2.0 * np.pi)
        measured = measured[np.isfinite(measured)]
        nearest = np.searchsorted(0.5 * (frequency[1:] + frequency[:-1]), measured)
        _mark(axes, measured, row[nearest], least, **curve.style)


def _mark(axes: Axes, frequency: np.ndarray, height: np.ndarray, least: float, **style: Any) -> None:
    """Markers alone, at what is not below `least`."""
    seen = height >= least
    axes.plot(frequency[seen], height[seen], **{**style, "linestyle": ""})


def _highest_near(frequency: np.ndarray, row: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Highest of `row` at each of `places` and one frequency to either side: the line of a mode between two of them."""
    nearest = np.searchsorted(0.5 * (frequency[1:] + frequency[:-1]), places)
    around = np.clip(nearest[:, None] + np.array([-1, 0, 1]), 0, frequency.size - 1)
    return row[around].max(axis=1)
