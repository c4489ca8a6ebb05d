"""The Campbell diagram: frequencies over the angular velocity, and where multiples of the speed meet them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.follow import eigenvalues, followed
from ..parts.labels import value_text
from ..parts.select import Chosen, chosen, left_out, spread
from ..parts.sheet import Given, columns_for, sheet_for
from ..result import NothingToDraw, require, swept_inputs
from ..style import COLOURS, DASHES, GREY, styled

SPEED, CRITICAL = "rotation_angular_velocity", "critical_angular_velocity"
HELD = ("angular_frequency", "growth_rate", "mode_shape", CRITICAL)
RPM = 60.0 / (2.0 * np.pi)  # from rad/s
MAX_MODES, FEW_MODES, MAX_PANELS = 5, 2, 4
LEAST_SPEEDS = 3  # of a line
FINE = 400  # places between the first and the last speed
FEW_CASES = 40  # up to which each is marked
ORDERS = (1, 2, 3, 4, 6, 8)  # multiples of the speed: 1P, 2P …
GROWS = "#F3D9C9"
NAME = 10.0  # points that the name of a multiple takes


@styled
def campbell(ds: xr.Dataset, *, modes: Chosen = None, orders: Sequence[float] = ORDERS, ax: Given = None) -> Figure:
    """Frequencies (Hz) of the lowest modes, or of these `modes`, over the angular velocity (rpm) of a sweep over it.

    Modes are followed through crossings. Where the first one grows the picture is shaded, from the critical speed on;
    the `orders`, multiples of the speed, are dotted lines, and diamonds mark where they meet a mode (`crossings` has the
    numbers). A rotor of three blades wants `orders=(1, 3, 6, 9)`. Modes beyond all of these multiples are left out, but
    for the first two. A second swept input makes panels, of those of its values that come with three speeds or more:
    in a design whose rows all differ there are none.
    """
    require(ds, "angular_frequency", SPEED)
    numbers = chosen(ds, modes=modes)["mode"].values[: MAX_MODES if modes is None else None]
    names = [name for name in swept_inputs(ds) if np.unique(ds[name]).size > 1]
    other = [name for name in names if name != SPEED]
    held = _lines_of(ds, other) if SPEED in names and len(other) < 2 else []
    if not held:
        raise NothingToDraw("needs a sweep over the angular velocity: three values or more with all else equal, and at most one other input")
    drawn = chosen(ds)[[name for name in HELD if name in ds]].load()
    shown = [held[place] for place in spread(len(held), MAX_PANELS)]
    parts = [drawn.isel(case=cases) for cases in shown]
    branches = [_branches(part, numbers) for part in parts]
    if not any((values > 0.0).any() for values in branches):
        raise NothingToDraw("no mode oscillates")
    if modes is None:
        numbers = numbers[: _in_reach(branches, parts, orders)]
        branches = [values[:, : numbers.size] for values in branches]
    columns = columns_for(len(shown))
    rows = -(-len(shown) // columns)
    sheet = sheet_for(ax, rows, columns, width=6.4 if columns == 1 else 9.6, height=4.4 if rows == 1 else 3.6)
    top = highest_of(np.concatenate(branches))
    multiples = []
    for axes, part, values in zip(sheet.axes, parts, branches):
        limit, drawn_here = _draw(axes, part, numbers, values, top, orders)
        multiples += drawn_here
        axes.set_title(", ".join(filter(None, [value_text(part[other[0]][0]) if other else "", limit])))
    for axes in sheet.axes[len(shown) :]:
        axes.set_visible(False)
    of_modes = left_out(numbers.size, ds["mode"].size, "modes in the file") if modes is None else ""
    fig = sheet.finish(ds, [left_out(len(shown), len(held), "values"), of_modes])
    if sheet.own:
        fig.get_layout_engine().execute(fig)
    _thin(multiples)
    return fig


def crossings(ds: xr.Dataset, *, modes: Chosen = None, orders: Sequence[float] = ORDERS) -> pd.DataFrame:
    """Speeds at which a multiple of the speed meets a mode, of a sweep over the angular velocity alone.

    A row for each: `mode`, `order`, `angular_velocity` (rad/s), `rpm` and `frequency` (Hz), in the order of speed. Between the
    speeds of the sweep the square of the frequency is interpolated over that of the speed, in which it is nearly linear.
    """
    numbers = chosen(ds, modes=modes)["mode"].values if "mode" in ds else np.empty(0)
    speed, values = over_speed(ds, numbers)
    rows = [
        (int(number), order, at, RPM * at, frequency)
        for branch, number in enumerate(numbers)
        for order in orders
        for at, frequency in _meetings(speed, values[:, branch], order)
    ]
    table = pd.DataFrame(rows, columns=["mode", "order", "angular_velocity", "rpm", "frequency"])
    return table.sort_values(["angular_velocity", "mode"], ignore_index=True)


def over_speed(ds: xr.Dataset, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Speeds (rad/s) of a sweep over the angular velocity alone, and eigenvalues (case, mode) of the modes `numbers`, followed."""
    require(ds, "angular_frequency", SPEED)
    if [name for name in swept_inputs(ds) if np.unique(ds[name]).size > 1] != [SPEED]:
        raise NothingToDraw("needs a sweep over the angular velocity alone")
    held = _lines_of(ds, [])
    if not held:
        raise NothingToDraw("needs three values of the angular velocity or more")
    cases = chosen(ds)[[name for name in HELD if name in ds]].load().isel(case=held[0])
    return cases[SPEED].values, _branches(cases, numbers)


def _lines_of(ds: xr.Dataset, other: list[str]) -> list[np.ndarray]:
    """Cases in the order of their speeds, each speed once, for each value of the `other` input that comes with enough of them."""
    values = ds[other[0]].values if other else np.zeros(ds.sizes["case"])
    held = []
    for value in np.unique(values):
        cases = np.flatnonzero(values == value)
        _, first = np.unique(ds[SPEED].values[cases], return_index=True)
        if first.size >= LEAST_SPEEDS:
            held.append(cases[first])
    return held


def _branches(cases: xr.Dataset, numbers: np.ndarray) -> np.ndarray:
    """Eigenvalues (case, mode) of the modes `numbers`, each followed through the cases."""
    order = followed(cases, _signed(cases[SPEED].values))
    places = [int(np.flatnonzero(cases["mode"].values == number)[0]) for number in numbers]
    return np.take_along_axis(eigenvalues(cases), order, axis=1)[:, places]


def _draw(
    axes: Axes,
    cases: xr.Dataset,
    numbers: np.ndarray,
    values: np.ndarray,
    top: float,
    orders: Sequence[float],
) -> tuple[str, list[list[Artist]]]:
    """One diagram of cases that differ in their speed, which ascends; the critical speed in words, and what each multiple is drawn of.

    `values` are the eigenvalues (case, mode) of the modes `numbers`, and `top` where all axes end.
    """
    speed = cases[SPEED].values
    for branch, number in enumerate(numbers):
        _draw_mode(axes, speed, values[:, branch], f"mode {number}", branch)
    axes.set_ylim(0.0, top)
    axes.set_xlim(RPM * speed[0], RPM * speed[-1])
    multiples = [_draw_order(axes, order, speed, values) for order in sorted(orders)]
    axes.set(xlabel="Angular velocity (rpm)", ylabel="Frequency (Hz)")
    return _mark_growth(axes, cases, speed, values), list(filter(None, multiples))


def _draw_mode(axes: Axes, speed: np.ndarray, values: np.ndarray, label: str, number: int) -> None:
    """One mode: β² goes smoothly over ω², also through 0, and its root is the curve; few cases are marked."""
    known = np.isfinite(values)
    if np.count_nonzero(known) < 2:
        return
    fine, smooth = curve_of(speed, values)
    colour, dash = COLOURS[number % len(COLOURS)], DASHES[number % len(DASHES)]
    label = label if (values > 0.0).any() else f"{label}: grows at all of these speeds"
    axes.plot(RPM * fine, smooth, color=colour, linestyle=dash, linewidth=1.5, label=label)
    if speed.size <= FEW_CASES:
        axes.plot(RPM * speed, _hertz(values), linestyle="", marker="o", markersize=3, color=colour)


def curve_of(speed: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and frequencies (Hz) along the curve of one mode, of which two eigenvalues or more are known."""
    known = np.isfinite(values)
    fine = np.linspace(speed[known][0], speed[known][-1], FINE)
    return fine, _hertz(_between(speed, values)(fine))


def _between(speed: np.ndarray, values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Eigenvalues of a mode as a function of the speed, through those that are known."""
    from scipy.interpolate import PchipInterpolator  # here, since few pictures need it and it takes 0.7 s to import

    known = np.isfinite(values)
    through = PchipInterpolator(_signed(speed[known]), values[known])
    return lambda at: through(_signed(at))


def _meetings(speed: np.ndarray, values: np.ndarray, order: float) -> list[tuple[float, float]]:
    """Speeds (rad/s) other than 0 at which a mode's frequency (Hz) is that multiple of the speed, and that frequency."""
    from scipy.optimize import brentq

    known = np.isfinite(values)
    if np.count_nonzero(known) < 2:
        return []
    curve = _between(speed, values)

    def gap(at: np.ndarray) -> np.ndarray:
        return curve(at) - (order * at) ** 2

    fine = np.linspace(speed[known][0], speed[known][-1], FINE)
    above = gap(fine) > 0.0
    places = [brentq(gap, fine[i], fine[i + 1]) for i in np.flatnonzero(above[1:] != above[:-1])]
    return [(at, order * abs(at) / (2.0 * np.pi)) for at in places if at != 0.0 and curve(at) > 0.0]


def _signed(speed: np.ndarray) -> np.ndarray:
    """Squares with the sign of the speed: what eigenvalues are smooth over, and what ascends with the speed."""
    return speed * np.abs(speed)


def _hertz(values: np.ndarray) -> np.ndarray:
    """Frequencies of eigenvalues; NaN where they grow."""
    return np.sqrt(np.where(values >= 0.0, values, np.nan)) / (2.0 * np.pi)


def highest_of(values: np.ndarray) -> float:
    """Where the axis of frequencies (Hz), which begins at 0, ends for eigenvalues (case, mode)."""
    return 1.1 * float(np.nanmax(_hertz(values)))


def _in_reach(branches: list[np.ndarray], parts: list[xr.Dataset], orders: Sequence[float]) -> int:
    """How many modes, the first, some multiple of the speed meets or may come near to, and FEW_MODES in any case."""
    reach = max(abs(order) for order in orders) * max(float(np.abs(part[SPEED]).max()) for part in parts) if orders else np.inf
    lowest = [min(np.nanmin(values[:, mode], initial=np.inf) for values in branches) for mode in range(branches[0].shape[1])]
    return max(FEW_MODES, int(np.count_nonzero(np.array(lowest) < reach**2)))


def _draw_order(axes: Axes, order: float, speed: np.ndarray, values: np.ndarray) -> list[Artist]:
    """A multiple of the speed, its name where it leaves the picture, and its meetings with modes; nothing of one outside."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    fine = np.linspace(left, right, FINE)
    line = order * np.abs(fine) / 60.0
    inside = np.flatnonzero((line > bottom) & (line < top))
    if not inside.size:
        return []
    name = axes.annotate(f"{order:g}P", (fine[inside[-1]], line[inside[-1]]), xytext=(3, 0), textcoords="offset points",
                         fontsize=8, color=GREY, va="center", annotation_clip=False)  # fmt: skip
    met = np.array([place for branch in values.T for place in _meetings(speed, branch, order)]).reshape(-1, 2)
    return [
        name,
        *axes.plot(fine, line, color=GREY, linewidth=0.7, linestyle=":", zorder=1),
        *axes.plot(RPM * met[:, 0], met[:, 1], linestyle="", marker="D", markersize=5, color=GREY, fillstyle="none"),
    ]


def _thin(multiples: list[list[Artist]]) -> None:
    """Take away multiples whose names meet that of a lower one, all axes having their final places."""
    named: list[np.ndarray] = []
    for name, *others in multiples:
        end = name.axes.transData.transform(name.xy) * 72.0 / name.figure.dpi
        if all(np.abs(end - other).max() >= NAME for other in named):
            named.append(end)
            continue
        for artist in (name, *others):
            artist.remove()


def _mark_growth(axes: Axes, cases: xr.Dataset, speed: np.ndarray, values: np.ndarray) -> str:
    """A bar at the foot where each mode grows, a shade where any does, and the critical speed; that speed in words."""
    growing = np.nan_to_num(values) < 0.0
    for row, branch in enumerate(np.flatnonzero(growing.any(axis=0))):
        foot = np.where(growing[:, branch], 0.012 + 0.022 * row, np.nan)
        axes.plot(RPM * speed, foot, color=COLOURS[branch % len(COLOURS)], linewidth=4.0, solid_capstyle="butt",
                  transform=axes.get_xaxis_transform())  # fmt: skip
    if not growing.any():
        return ""
    axes.fill_between([], [], color=GROWS, linewidth=0.0, label="a mode grows: that of the bar at the foot")
    critical = cases[CRITICAL].values if CRITICAL in cases else np.full(speed.size, np.nan)
    limit = float(np.nanmin(critical, initial=np.inf))
    first = min(limit, float(np.abs(speed[growing.any(axis=1)]).min()))
    for side in (-1.0, 1.0):
        start, end = max(first, -speed[-1] if side < 0 else speed[0]), -speed[0] if side < 0 else speed[-1]
        if end > start:
            axes.axvspan(RPM * side * start, RPM * side * end, color=GROWS, linewidth=0.0, zorder=0)
        if end > limit > start - 1e-12 and np.isfinite(limit):
            axes.axvline(RPM * side * limit, color=COLOURS[2], linewidth=1.0, zorder=1)
    return f"critical speed {RPM * limit:.0f} rpm ({limit:.4g} rad/s)" if np.isfinite(limit) else ""
