"""Amplitude spectra of the histories, with the peaks that were measured."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .curves import Curve, curves_of, heading
from .labels import axis_label
from .legend import add_legend
from .points import chosen_points, panels_for, point_label, thinned
from .result import NothingToDraw, require, require_numbers
from .style import logarithmic, styled

SHARED_INPUTS = ("rotation_angular_velocity", "impact_mass_ratio", "impact_mass")
DEPTH = 1e-9  # what lies further below the highest line is rounding, and not shown


@styled
def spectrum(ds: xr.Dataset) -> Figure:
    """Draw `amplitude` (case, point, frequency) in m against frequency in Hz, one panel per point."""
    require(ds, "amplitude", "frequency", "point_position")
    if np.count_nonzero(ds["frequency"].values > 0.0) < 2:
        raise NothingToDraw("the spectrum has fewer than two frequencies above 0")
    points = chosen_points(ds)
    curves = curves_of(ds)
    fig = panels_for(points)
    for axes, point in zip(fig.axes, points):
        _draw_point(axes, ds, curves, point)
    fig.axes[-1].set_xlabel(axis_label(ds["frequency"]))
    _describe(fig.axes[0], ds, curves, thinned(ds, points))
    return fig


def _describe(axes: Axes, ds: xr.Dataset, curves: list[Curve], note: str) -> None:
    """Legend above the first panel: the cases by line and marker, what a marker is, and a `note`."""
    peaks = "measured_angular_frequency" in ds
    for curve in curves:
        if curve.label:
            axes.plot([], [], label=curve.label, **(curve.style if peaks else {**curve.style, "marker": ""}))
    words = (heading(ds, *SHARED_INPUTS), note, "markers: measured peaks" if peaks else "")
    add_legend(axes, "; ".join(filter(None, words)), above=True)


def _draw_point(axes: Axes, ds: xr.Dataset, curves: list[Curve], point: int) -> None:
    """Spectra of all `curves` at one point; the frequency 0 has no place on the axis."""
    frequency = ds["frequency"].values
    shown = frequency > 0.0
    values = np.array([curve.data["amplitude"].isel(point=point).values for curve in curves])
    require_numbers(values, "amplitude")
    highest = np.nanmax(values) or 1.0  # a point at rest has an empty panel
    logarithmic(axes, "x", frequency[shown][0], frequency[-1])
    logarithmic(axes, "y", DEPTH * highest, 5.0 * highest)
    for curve, row in zip(curves, values):
        axes.plot(frequency[shown], row[shown], **{**curve.style, "marker": ""})
        _mark_peaks(axes, curve, frequency, row)
    axes.set_ylabel(point_label(ds, "amplitude", point))


def _mark_peaks(axes: Axes, curve: Curve, frequency: np.ndarray, row: np.ndarray) -> None:
    """Put a marker on the spectrum at each measured frequency of one case."""
    if "measured_angular_frequency" not in curve.data:
        return
    measured = curve.data["measured_angular_frequency"].values / (2.0 * np.pi)
    measured = measured[np.isfinite(measured)]
    nearest = np.searchsorted(0.5 * (frequency[1:] + frequency[:-1]), measured)
    axes.plot(measured, row[nearest], **{**curve.style, "linestyle": ""})
