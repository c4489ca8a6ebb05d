"""A record's lines beside the modes of a beam, and the numbers of the beam that were found from them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..parts.curves import Curve, panels_of
from ..parts.sheet import Given, sheet_for
from ..parts.units import number_text
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, styled

MODEL = "modelled_angular_frequency"


@styled
def record_model(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw by how much the measured frequencies of the modes differ from the modelled ones, and both decay rates.

    Bars are the intervals of the lines. The lower axes are empty without `&damping`. Lines that are no modes are left out.
    """
    require(ds, MODEL, "peak_mode", "measured_angular_frequency", "measured_angular_frequency_error")
    drawn = panels_of(ds, MODEL, panels=1)
    sheet = sheet_for(ax, 2, 1, height=2.7, share="x")
    above, below = sheet.axes
    for number, curve in enumerate(drawn.curves):
        _draw_differences(above, curve, 0.12 * (number - 0.5 * (len(drawn.curves) - 1)))
        _draw_decays(below, curve, 0.12 * (number - 0.5 * (len(drawn.curves) - 1)))
    above.axhline(0.0, color=GREY, linewidth=0.8, zorder=0)
    above.set_ylabel("Measured − modelled\nfrequency (%)")
    below.set(xlabel="Mode", ylabel="Decay rate (1/s)")
    below.xaxis.get_major_locator().set_params(integer=True)
    return sheet.finish(ds, [*drawn.notes, "bars: intervals of the lines", *_verdict(ds)])


def _paired(case: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """The lines that are modes, and the numbers of these."""
    mode = case["peak_mode"].values
    lines = np.flatnonzero((mode > 0) & np.isfinite(case[MODEL].values))
    return lines, mode[lines].astype(float)


def _draw_differences(axes: Axes, curve: Curve, aside: float) -> None:
    lines, mode = _paired(curve.data)
    modelled = curve.data[MODEL].values[lines]
    away = 100.0 * (curve.data["measured_angular_frequency"].values[lines] / modelled - 1.0)
    bar = 100.0 * curve.data["measured_angular_frequency_error"].values[lines] / modelled
    axes.errorbar(mode + aside, away, bar, capsize=2, label=curve.label, **{**curve.style, "linestyle": ""})


def _draw_decays(axes: Axes, curve: Curve, aside: float) -> None:
    """Measured ones with bars; modelled ones as open marks."""
    if "measured_decay_rate" not in curve.data:
        return
    lines, mode = _paired(curve.data)
    values = curve.data["measured_decay_rate"].values[lines]
    bar = curve.data["measured_decay_rate_error"].values[lines]
    axes.errorbar(mode + aside, values, bar, capsize=2, **{**curve.style, "linestyle": ""})
    modelled = curve.data["modelled_decay_rate"].values[lines]
    if (modelled > 0.0).any():
        axes.plot(mode + aside, modelled, linestyle="", marker="_", markersize=14, color=COLOURS[2])


def _verdict(ds: xr.Dataset) -> list[str]:
    """Whether noise explains the differences."""
    if "misfit_probability" not in ds or ds["misfit_probability"].ndim or int(ds["misfit_freedom"]) < 1:
        return []
    if float(ds["misfit_probability"]) >= 1e-3:
        return ["noise explains the differences"]
    return [f"noise does not explain the differences: frequencies are off by {number_text(100 * float(ds['model_scatter']), 2)} %"]


@styled
def identified(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw the identified numbers with their intervals over their ranges, and the correlations of each two."""
    require(ds, "identified", "identified_low", "identified_high", "identified_correlation")
    if "identified_first" not in ds or not np.isfinite(ds["identified"].values).any():
        raise NothingToDraw("no range of what was identified")
    count = ds.sizes["unknown"]
    sheet = sheet_for(ax, 1, 2, width=9.0, height=1.8 + 0.5 * count)
    left, right = sheet.axes
    names = [_name(ds, i) for i in range(count)]
    for i in range(count):
        _draw_interval(left, ds, i)
    left.set(xlim=(0.0, 1.0), ylim=(count - 0.5, -0.5), yticks=range(count), xticks=[0.0, 1.0])
    left.set_yticklabels(names)
    left.set_xticklabels(["first", "last"])
    left.set_xlabel("Range")
    correlation = ds["identified_correlation"].values
    right.imshow(correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0)
    for i in range(count):
        for j in range(count):
            dark = abs(correlation[i, j]) > 0.6
            right.text(j, i, f"{correlation[i, j]:.2f}", ha="center", va="center", color="white" if dark else "black")
    right.set(xticks=range(count), yticks=range(count))
    right.grid(False)
    right.set_xticklabels(range(1, count + 1))
    right.set_yticklabels(range(1, count + 1))
    right.set_xlabel("Correlation")
    return sheet.finish(ds, _verdict(ds))


def _text(value: object) -> str:
    """A text of the file, which may be bytes."""
    return (value.decode() if isinstance(value, bytes) else str(value)).strip()


def _name(ds: xr.Dataset, i: int) -> str:
    """Number, name, value and interval of an unknown."""
    name, unit = (_text(ds[f"identified_{word}"].values[i]) for word in ("parameter", "unit"))
    numbers = [float(ds[f"identified{end}"].values[i]) for end in ("", "_low", "_high")]
    value, low, high = (number_text(number, _digits(number, numbers[2] - numbers[1])) for number in numbers)
    unit = "" if unit == "1" else f" {unit}"
    return f"{i + 1}  {name}\n{value} ({low} … {high}){unit}"


def _digits(number: float, width: float) -> int:
    """How many digits of a number an interval of this width tells, two of its own at least."""
    if not (width > 0.0 and np.isfinite(number) and number != 0.0):
        return 15
    return max(2, min(15, 3 + int(np.floor(np.log10(abs(number))) - np.floor(np.log10(width)))))


def _draw_interval(axes: Axes, ds: xr.Dataset, i: int) -> None:
    """Where value and interval are in the range, by logarithms where that spans a factor of 10."""
    first, last = (float(ds[f"identified_{word}"].values[i]) for word in ("first", "last"))
    ends = np.array([float(ds[name].values[i]) for name in ("identified_low", "identified", "identified_high")])
    if first > 0.0 and last >= 10.0 * first:
        ends, first, last = np.log(ends), np.log(first), np.log(last)
    low, value, high = (ends - first) / (last - first)
    axes.errorbar([value], [i], xerr=[[max(0.0, value - low)], [max(0.0, high - value)]], capsize=4, marker="o", color=COLOURS[1])
