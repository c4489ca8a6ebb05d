"""Frequency responses of a record whose blow was measured."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.describe import effects_of
from ..parts.labels import flag_words
from ..parts.sensors import one_record, sensor_name, shown_sensors
from ..parts.sheet import Given, sheet_for
from ..result import NothingToDraw, require
from ..style import COLOURS, GREY, logarithmic, styled

DERIVATIVE = {"displacement": 0, "velocity": 1, "acceleration": 2}
KIND = {"displacement": "Receptance (m/N)", "velocity": "Mobility (m/s/N)", "acceleration": "Accelerance (m/s²/N)"}
BEYOND = 1.5  # times the highest line, up to where there is something to see
PALE = "#A6CEE6"
ROOM = 1e-5  # of the largest response, to which the axis goes down


@styled
def record_response(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw the size of each sensor's response over the force, the sum of the lines' modal constants, and the beam's model.

    Of repeats it is H1 over all of them, with H2 and their coherence beside it; else that of the record.
    """
    case, note = one_record(ds)
    require(case, "frequency_response_real", "frequency_response_imag", "frequency")
    pooled = "pooled_coherence" in case and np.isfinite(case["pooled_coherence"].values).any()
    first = _complex(case, "pooled_response_h1" if pooled else "frequency_response")
    if not np.isfinite(first).any():
        raise NothingToDraw("the frequency response is not in the file")
    frequency = case["frequency"].values
    lines = np.nanmax(case["measured_angular_frequency"].values, initial=0.0) / (2.0 * np.pi)
    shown = (frequency > 0.0) & (frequency <= (BEYOND * lines if lines else np.inf))
    sensors, left = shown_sensors(case)
    sheet = sheet_for(ax, len(sensors), 2 if pooled else 1, width=9.6 if pooled else 7.0, height=2.4, share="x")
    known = _modal_sum(case, frequency)
    damped = "damping" in effects_of(ds)
    for row, sensor in zip(sheet.grid, sensors):
        if pooled:  # H2 is nowhere below H1, and stands behind it
            other = np.abs(_complex(case, "pooled_response_h2"))[sensor, shown]
            row[0].plot(frequency[shown], other, color=PALE, linewidth=0.8, label="H2")
            coherence = case["pooled_coherence"].values[sensor, shown]
            row[1].plot(frequency[shown], coherence, color=COLOURS[1], linewidth=0.8)
            row[1].set(ylim=(0.0, 1.03), ylabel="Coherence")
        words = "H1 over the repeats" if pooled else "response over force"
        row[0].plot(frequency[shown], np.abs(first[sensor, shown]), color=GREY, linewidth=0.8, label=words)
        if np.isfinite(known[sensor]).all():
            row[0].plot(frequency[shown], np.abs(known[sensor, shown]), color=COLOURS[2], linewidth=0.9, label="modal constants")
        highest = [first[sensor, shown], np.nan_to_num(known[sensor, shown])]
        if "modelled_response_real" in case:
            modelled = np.abs(_complex(case, "modelled_response")[sensor])
            seen = shown & np.isfinite(modelled)
            row[0].plot(frequency[seen], modelled[seen], color=COLOURS[3], linewidth=0.9, linestyle="--", label=f"model of the beam{'' if damped else ', undamped'}")
            highest += [np.where(seen, modelled, 0.0)[shown]] if damped else []  # else its peaks have no end
        top = 3.0 * np.nanmax(np.abs(highest))
        logarithmic(row[0], "y", max(ROOM * top, 0.3 * np.nanmin(np.abs(first[sensor, shown]))), top)
        row[0].set_ylabel(f"{sensor_name(case, sensor)}\n{KIND.get(_quantity(case, sensor), '')}")
        for axes in row:
            axes.set_xlim(0.0, frequency[shown][-1])
    for axes in sheet.grid[-1]:
        axes.set_xlabel("Frequency (Hz)")
    return sheet.finish(case, [note if not pooled else "", left])


def _complex(case: xr.Dataset, name: str) -> np.ndarray:
    return case[f"{name}_real"].values + 1j * case[f"{name}_imag"].values


def _quantity(case: xr.Dataset, sensor: int) -> str:
    return flag_words(case["sensor_quantity"]).get(int(case["sensor_quantity"].values[sensor]), "")


def _modal_sum(case: xr.Dataset, frequency: np.ndarray) -> np.ndarray:
    """The response of the lines alone: Σ (iω)^q Im [C/(β (iω − z))], as complex conjugates go with it; nan without constants."""
    constant = _complex(case, "measured_modal_constant")
    known = np.isfinite(case["measured_angular_frequency"].values)
    beta, decay = case["measured_angular_frequency"].values[known], case["measured_decay_rate"].values[known]
    at, pole = 2j * np.pi * frequency[:, None], -decay + 1j * beta
    total = np.full((case.sizes["point"], frequency.size), np.nan, complex)
    for sensor in range(case.sizes["point"]):
        own = constant[sensor, known]
        if not own.size or not np.isfinite(own).all():
            continue
        sums = own / (2j * beta * (at - pole)) - own.conj() / (2j * beta * (at - pole.conj()))
        total[sensor] = (sums * at ** DERIVATIVE.get(_quantity(case, sensor), 0)).sum(axis=1)
    return total
