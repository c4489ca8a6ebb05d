"""Angular frequency, phase velocity and group velocity against wave number (Figs 2, 4, 5)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .curves import Curve, curves_of, heading
from .labels import axis_label
from .legend import add_legend
from .relation import Relation, relation_of
from .result import NothingToDraw, require
from .style import logarithmic, new_figure, styled

SHARED_INPUTS = ("rotation_angular_velocity", "impact_mass_ratio", "impact_mass")


def dispersion(ds: xr.Dataset) -> Figure:
    """Angular frequency β against wave number P: the relation (Eq. 2) and the modes on it."""
    return _against_wavenumber(ds, "angular_frequency")


def phase_velocity(ds: xr.Dataset) -> Figure:
    """Phase velocity C_p against wave number P: the relation (Eq. 32) and the modes on it."""
    return _against_wavenumber(ds, "phase_velocity")


def group_velocity(ds: xr.Dataset) -> Figure:
    """Group velocity C_g against wave number P: the relation (Eq. 33) and the modes on it."""
    return _against_wavenumber(ds, "group_velocity")


@styled
def _against_wavenumber(ds: xr.Dataset, name: str) -> Figure:
    """Draw variable `name` (case, mode) against `wavenumber`: logarithmic, so that the low modes show."""
    require(ds, "wavenumber", "angular_frequency", name)
    curves = curves_of(ds)
    fig = new_figure()
    axes = fig.axes[0]
    _set_limits(axes, curves, name)
    captured = len(curves) == 1 and name + "_before" in ds
    for curve in curves:
        _draw_curve(axes, curve, name, curve.label or ("modes after the capture" if captured else "modes"))
    if captured:
        _draw_modes_before(axes, curves[0].data, name)
    axes.set_xlabel(axis_label(ds["wavenumber"]))
    axes.set_ylabel(axis_label(ds[name]))
    add_legend(axes, heading(ds, *SHARED_INPUTS))
    return fig


def _modes(case: xr.Dataset, name: str, suffix: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Wave numbers and values of the modes of one case where both exist and fit a logarithmic axis."""
    p, values = case["wavenumber" + suffix].values, case[name + suffix].values
    drawn = np.isfinite(p) & np.isfinite(values) & (p > 0.0) & (values > 0.0)
    return p[drawn], values[drawn]


def _set_limits(axes: Axes, curves: list[Curve], name: str) -> None:
    """Logarithmic axes around the modes, with room at the low end for the relation's cut-off."""
    modes = [_modes(curve.data, name) for curve in curves]
    p, values = (np.concatenate(parts) for parts in zip(*modes))
    if not p.size:
        raise NothingToDraw(f"{name} holds nothing but fill")
    logarithmic(axes, "x", 0.55 * p.min(), 1.3 * p.max())
    logarithmic(axes, "y", 0.45 * values.min(), 1.8 * values.max())


def _draw_curve(axes: Axes, curve: Curve, name: str, label: str) -> None:
    """One case: its relation as a smooth line and its modes as markers, or the modes joined."""
    p, values = _modes(curve.data, name)
    relation = relation_of(curve.data)
    if relation is None:
        axes.plot(p, values, label=label, **curve.style)
        return
    line = {**curve.style, "marker": ""}
    points = {**curve.style, "linestyle": ""}
    axes.plot(*_smooth(relation, name, axes.get_xlim()[1]), **line)
    axes.plot(p, values, **points)
    axes.plot([], [], label=label, **curve.style)


def _smooth(relation: Relation, name: str, p_max: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the relation up to `p_max`, even in log β: its steep start at the cut-off stays smooth."""
    beta_max = relation.h * p_max**2
    beta = np.geomspace(1e-12 * beta_max, beta_max, 4000)
    return relation.wavenumber(beta), relation.value(name, beta)


def _draw_modes_before(axes: Axes, case: xr.Dataset, name: str) -> None:
    """Modes of the beam alone, before it caught the mass."""
    p, values = _modes(case, name, "_before")
    axes.plot(p, values, linestyle="", marker="x", color="0.3", label="modes before the capture")
