"""Angular frequency, phase velocity and group velocity against wave number (Figs 2, 4, 5)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.bands import draw_bands, is_scattered
from ..parts.curves import Curve, Panel, panels_of, where_it_varies
from ..parts.describe import turns_out_of_plane
from ..parts.labels import axis_label
from ..parts.relation import Relation, plain_relation, relation_of
from ..parts.select import Chosen, chosen
from ..parts.sheet import Given, columns_for, sheet_for
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, label_decades, logarithmic, styled

SAMPLES = 2000  # of the smooth relation
EQUATIONS = {"angular_frequency": "Eq. 2", "phase_velocity": "Eq. 32", "group_velocity": "Eq. 33"}
LOWEST = 1e-12  # of the highest frequency: where the smooth relation starts


def dispersion(ds: xr.Dataset, *, modes: Chosen = None, cases: Chosen = None, ax: Given = None) -> Figure:
    """Angular frequency β against wave number P: the modes, and the relation (Eq. 2) where they obey it."""
    return _against_wavenumber(chosen(ds, modes=modes, cases=cases), "angular_frequency", ax)


def phase_velocity(ds: xr.Dataset, *, modes: Chosen = None, cases: Chosen = None, ax: Given = None) -> Figure:
    """Phase velocity C_p against wave number P: the modes, and the relation (Eq. 32) where they obey it."""
    return _against_wavenumber(chosen(ds, modes=modes, cases=cases), "phase_velocity", ax)


def group_velocity(ds: xr.Dataset, *, modes: Chosen = None, cases: Chosen = None, ax: Given = None) -> Figure:
    """Group velocity C_g against wave number P: the modes, and the relation (Eq. 33) where they obey it."""
    return _against_wavenumber(chosen(ds, modes=modes, cases=cases), "group_velocity", ax)


@styled
def _against_wavenumber(ds: xr.Dataset, name: str, ax: Given) -> Figure:
    """Draw variable `name` (case, mode) against `wavenumber`: logarithmic, so that the low modes show."""
    require(ds, "wavenumber", "angular_frequency", name)
    if is_scattered(ds):
        return _of_many(ds, name, ax)
    varying, same = where_it_varies(ds, "wavenumber", "angular_frequency", name)
    drawn = panels_of(varying, name)
    columns = columns_for(len(drawn.panels))
    rows = -(-len(drawn.panels) // columns)
    sheet = sheet_for(ax, rows, columns, width=6.4 if columns == 1 else 9.0, height=4.0 if rows == 1 else 3.2)
    limits = _limits(drawn.curves, name)
    for axes, panel in zip(sheet.axes, drawn.panels):
        _draw_panel(axes, panel, name, limits, alone=len(drawn.curves) == 1)
        axes.set_ylabel(axis_label(ds[name]))
        axes.set_xlabel(axis_label(ds["wavenumber"]))
    for axes in sheet.axes[len(drawn.panels) :]:
        axes.set_visible(False)
    return sheet.finish(ds, [*drawn.notes, same, _first_modes(ds), _growing(drawn.curves)])


def _of_many(ds: xr.Dataset, name: str, ax: Given) -> Figure:
    """Draw the modes of all cases by their medians, and below the bands in which the cases lie around these."""
    drawn = (ds["wavenumber"] > 0.0) & (ds[name] > 0.0)
    modes = drawn.any("case")
    if not modes.any():
        raise NothingToDraw(f"no mode has both a wave number and a number in {name}")
    p, values = (ds[one].where(drawn).isel(mode=np.flatnonzero(modes)) for one in ("wavenumber", name))
    middle = p.median("case").values, values.median("case").values
    sheet = sheet_for(ax, 2, height=2.7, share="x", ratios=[1.3, 1.0])
    above, below = sheet.axes
    above.plot(*middle, linestyle="", marker="o", color=COLOURS[0], markersize=3.5)
    logarithmic(above, "y", 0.45 * middle[1].min(), 1.8 * middle[1].max())
    above.set_ylabel(axis_label(ds[name]))
    draw_bands(below, middle[0], 100.0 * (values.transpose("case", "mode").values / middle[1] - 1.0))
    logarithmic(below, "x", 0.55 * middle[0].min(), 1.3 * middle[0].max())
    below.set(xlabel=axis_label(ds["wavenumber"]), ylabel="Off the median (%)")
    lost = "" if drawn.isel(mode=np.flatnonzero(modes)).all() else "modes that grow have no frequency and are not drawn"
    return sheet.finish(ds, [f"{ds.sizes['case']} cases", _first_modes(ds), lost])


def _draw_panel(axes: Axes, panel: Panel, name: str, limits: tuple, *, alone: bool) -> None:
    """The curves of one panel, with frequencies in Hz at the right."""
    logarithmic(axes, "x", *limits[0])
    logarithmic(axes, "y", *limits[1])
    axes.set_title(panel.title)
    captured = alone and name + "_before" in panel.curves[0].data
    for curve in panel.curves:
        _draw_curve(axes, curve, name, curve.label or ("modes after the capture" if captured else "modes"))
    _draw_comparisons(axes, panel, name)
    if captured:
        p, values = _modes(panel.curves[0].data, name, "_before")
        axes.plot(p, values, linestyle="", marker="x", color="0.3", label="modes before the capture")
    if name == "angular_frequency" and alone:
        hertz = axes.secondary_yaxis("right", functions=(lambda rate: rate / (2 * np.pi), lambda f: f * (2 * np.pi)))
        hertz.set_ylabel("Frequency (Hz)")
        label_decades(hertz.yaxis, *(end / (2 * np.pi) for end in limits[1]))


def _modes(case: xr.Dataset, name: str, suffix: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Wave numbers and values of the modes of one case where both exist and fit a logarithmic axis."""
    p, values = case["wavenumber" + suffix].values, case[name + suffix].values
    drawn = np.isfinite(p) & np.isfinite(values) & (p > 0.0) & (values > 0.0)
    return p[drawn], values[drawn]


def _limits(curves: list[Curve], name: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of both axes around the modes, with room at the low end for the relation's cut-off."""
    modes = [_modes(curve.data, name) for curve in curves]
    p, values = (np.concatenate(parts) for parts in zip(*modes))
    if not p.size:
        raise NothingToDraw(f"no mode has both a wave number and a number in {name}")
    return (0.55 * p.min(), 1.3 * p.max()), (0.45 * values.min(), 1.8 * values.max())


def _draw_curve(axes: Axes, curve: Curve, name: str, label: str) -> None:
    """One case: its modes as markers, on the smooth relation where they obey it."""
    p, values = _modes(curve.data, name)
    relation = relation_of(curve.data)
    if relation is not None:
        axes.plot(*_smooth(relation, name, axes.get_xlim()[1]), zorder=1.5, **{**curve.style, "marker": ""})
    axes.plot(p, values, **{**curve.style, "linestyle": ""})
    axes.plot([], [], label=label, **(curve.style if relation is not None else {**curve.style, "linestyle": ""}))


def _draw_comparisons(axes: Axes, panel: Panel, name: str) -> None:
    """In grey the relation without tension, shear or damping of each case that obeys another one, each once."""
    obeyed = [relation_of(curve.data) for curve in panel.curves]
    others = [plain_relation(curve.data) for curve, own in zip(panel.curves, obeyed) if own is None]
    out_of_plane = turns_out_of_plane(panel.curves[0].data)
    label = f"{EQUATIONS[name]}{' without rotation' if out_of_plane else ''}, for comparison"
    for relation in dict.fromkeys(other for other in others if other not in (None, *obeyed)):
        smooth = _smooth(relation, name, axes.get_xlim()[1])
        axes.plot(*smooth, label=label, color=GREY, linewidth=0.8, linestyle=":", marker="", zorder=1.5)


def _smooth(relation: Relation, name: str, p_max: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the relation up to `p_max`, even in log β: its steep start at the cut-off stays smooth."""
    beta_max = relation.h * p_max**2
    beta = np.geomspace(LOWEST * beta_max, beta_max, SAMPLES)
    return relation.wavenumber(beta), relation.value(name, beta)


def _first_modes(ds: xr.Dataset) -> str:
    """That more modes were summed than the file holds; empty where it holds all."""
    count = ds.sizes["mode"]
    more = "mode_count" in ds and count < float(ds["mode_count"].max()) and int(ds["mode"][-1]) == count
    return f"the first {count} modes, which are in the file" if more else ""


def _growing(curves: list[Curve]) -> str:
    """Which modes are left out since they grow; of a sweep, that there are such."""
    rates = [curve.data["growth_rate"] for curve in curves if "growth_rate" in curve.data]
    growing = [rate["mode"].values[np.nan_to_num(rate.values) > 0.0] for rate in rates]
    if not any(numbers.size for numbers in growing):
        return ""
    if len(curves) > 1:
        return "modes that grow have no frequency and are not drawn"
    numbers = ", ".join(map(str, growing[0]))
    return (
        f"mode {numbers} grows and is not drawn" if growing[0].size == 1 else f"modes {numbers} grow and are not drawn"
    )
