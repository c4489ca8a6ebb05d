"""Amplitudes of a record's lines along the beam: what its sensors saw of the shapes."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.labels import axis_label
from ..parts.sensors import one_record
from ..parts.shapes import known_shape, modelled_shape
from ..parts.sheet import Given, sheet_for
from ..parts.units import with_unit
from ..result import NothingToDraw, require
from ..style import ABOVE_GRID, COLOURS, GREY, styled

MAX_LINES = 6
HALF = 0.42  # of the distance between two lines that the largest amplitude takes, at a sensor or of the shape


@styled
def record_shapes(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw the amplitude of each of the strongest lines at each sensor, with its interval, each on its own zero line.

    The sign is that of the motion when the sensor of the largest amplitude is at its crest. What is a quarter of a period
    away from that, as in a wave that travels, is drawn as an open marker. A stem joins each to its zero line. Through them goes the shape of the mode that the line is
    taken for in the beam, which may be identified; else that of the line's wave number where all but the mass at the tip is known
    of the ends. Of a sweep the first case is drawn.
    """
    case, note = one_record(ds)
    names = ["measured_amplitude", "measured_phase", "measured_amplitude_error", "measured_phase_error"]
    require(case, *names, "measured_angular_frequency")
    if case.sizes["point"] < 2:
        raise NothingToDraw("one sensor shows no shape")
    kinds = case["sensor_quantity"].values if "sensor_quantity" in case else np.zeros(1)
    if np.unique(kinds).size > 1:
        raise NothingToDraw("sensors of different quantities show no shape together")
    size, phase, size_error, phase_error = (case[name].values for name in names)
    beta = case["measured_angular_frequency"].values
    lines = np.flatnonzero(np.isfinite(beta))
    if not lines.size:
        raise NothingToDraw("the record has no lines")
    shown = np.sort(lines[np.argsort(-size[:, lines].max(axis=0))][:MAX_LINES])
    place = case["point_position"].values if "point_position" in case else np.arange(1, case.sizes["point"] + 1)
    told = np.isfinite(size_error[:, lines]).any(axis=1)  # not at a sensor that is constant
    if not told.any():
        raise NothingToDraw("the record tells no amplitudes")
    place, size, phase, size_error, phase_error = (values[told] for values in (place, size, phase, size_error, phase_error))
    order = np.argsort(place)
    sheet = sheet_for(ax, height=max(0.75 * shown.size, 1.5) + 0.7)
    axes = sheet.axes[0]
    for row, line in enumerate(shown):
        largest = int(size[:, line].argmax())
        turn = np.exp(1j * (phase[:, line] - phase[largest, line]))
        value = size[:, line] * turn
        error = np.hypot(size_error[:, line] * turn.real, size[:, line] * phase_error[:, line] * turn.imag)
        axes.axhline(row, color=GREY, linewidth=0.6, zorder=ABOVE_GRID)
        shape, words = modelled_shape(case, line, place, value.real, error), "shape of the model's mode"
        if shape is None:
            shape, words = known_shape(case, line, place, value.real, error), "shape of its wave number"
        scale = HALF / max(size[largest, line], np.abs(shape[1]).max() if shape is not None else 0.0)
        if shape is not None:
            axes.plot(shape[0], row + scale * shape[1], color=GREY, linewidth=1.0, label=words, zorder=1)
        look = {"color": COLOURS[1], "linestyle": "", "marker": "o", "capsize": 3}
        label = "in phase with the largest" if row == 0 else None
        axes.vlines(place, row, row + scale * value.real, color=COLOURS[1], linewidth=1.6, alpha=0.5)
        if shape is None and told.sum() > 2:
            axes.plot(place[order], row + scale * value.real[order], color=COLOURS[1], linewidth=0.7, linestyle=":")
        axes.errorbar(place[order], row + scale * value.real[order], scale * error[order], label=label, **look)
        if np.abs(value.imag).max() > 0.1 * size[largest, line]:
            aside = {**look, "color": COLOURS[2], "marker": "s", "markerfacecolor": "white"}
            axes.errorbar(place[order], row + scale * value.imag[order], scale * error[order], label="a quarter of a period off", **aside)
    axes.set_yticks(range(shown.size), [f"line {line + 1}\n{with_unit(beta[line] / (2.0 * np.pi), 'Hz')}" for line in shown])
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    along = "point_position" in case
    axes.set(ylim=(-0.6, shown.size - 0.35), xlabel=axis_label(case["point_position"]) if along else "Sensor")
    if along:
        axes.set_xlim(-0.02, 1.04)
    else:
        axes.xaxis.get_major_locator().set_params(integer=True)
    left = f"the {shown.size} strongest of {lines.size} lines" if shown.size < lines.size else ""
    return sheet.finish(case, [note, left])
