"""What a report says of a result, as tables: modes, events, histories, measured peaks."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from ..parts.describe import effects_of
from ..parts.events import events_of
from ..parts.labels import quantity
from ..parts.outcome import CRITICAL, OUTCOMES, SPEED
from ..parts.sensors import status_words
from ..parts.units import number_text, unit_text, units_of

MAX_ROWS, MAX_MODES = 20, 10
DIGITS = 7


class Table(NamedTuple):
    """Title, names of the columns with their units, rows of words, and what is left out."""

    title: str
    columns: list[str]
    rows: list[list[str]]
    note: str = ""


def tables_of(case: xr.Dataset) -> list[Table]:
    """The tables of one case that its result has the numbers for."""
    found = [_modes(case), _outcomes(case), _events(case), _histories(case), _peaks(case)]
    return [table for table in found if table is not None and table.rows]


def number(value: float) -> str:
    """A number as in a report; a dash for what does not exist."""
    return number_text(value, DIGITS)


def _modes(case: xr.Dataset) -> Table | None:
    """Wave number, frequency in both units, growth and wave velocities of the first modes."""
    names = [name for name in ("wavenumber", "growth_rate", "phase_velocity", "group_velocity") if name in case]
    names = [name for name in names if np.nan_to_num(case[name].values).any()]
    if "angular_frequency" not in case:
        return None
    beta = case["angular_frequency"].values
    columns = ["mode", "frequency (Hz)", f"angular frequency ({_unit(case, 'angular_frequency')})"]
    columns += [f"{name.replace('_', ' ')} ({_unit(case, name)})" for name in names]
    rows = [
        [str(mode), number(beta[i] / (2.0 * np.pi)), number(beta[i]), *(number(float(case[name][i])) for name in names)]
        for i, mode in enumerate(case["mode"].values[:MAX_MODES])
    ]
    note = f"{MAX_MODES} of {beta.size} modes" if beta.size > MAX_MODES else ""
    title = "Modes after the capture" if "capture" in effects_of(case) else "Modes"
    return Table(title, columns, rows, note)


def _outcomes(case: xr.Dataset) -> Table | None:
    """What the impact leaves, the largest values with their places and times, and the critical speed of a beam that rotates."""
    words = {name: quantity(case[name]) for name in (*OUTCOMES, "largest_indentation") if name in case}
    words |= {
        "impulse": "impulse of the impact",
        "mass_velocity": "velocity of the mass just after the impact",
        "tip_velocity": "velocity of the tip just after the impact",
    }
    words |= {CRITICAL: "critical angular velocity"} if SPEED in case else {}
    rows = []
    for name, text in words.items():
        if name not in case or not np.isfinite(case[name].values).any():
            continue
        values = np.atleast_1d(case[name].values)
        most, along = int(np.nanargmax(values)), "point" in case[name].dims
        time = f"{name}_time"
        when = number(float(case[time].values.flat[most])) if time in case else "–"
        place = f"{float(case['point_position'][most]):.4g}" if along else "–"
        rows.append([text[:1].lower() + text[1:], number(float(values[most])), _unit(case, name), place, when])
    return Table("Outcomes", ["quantity", "value", "unit", "at ξ", "time (s)"], rows)


def _events(case: xr.Dataset) -> Table | None:
    """Times, impulses, energies and momenta of the events."""
    events = events_of(case)
    names = [name for name in ("event_force", "energy_before", "energy_after", "momentum_before", "momentum_after") if name in case]
    rows = [
        [
            event.kind,
            number(event.time),
            number(event.end),
            number(event.impulse),
            *(number(float(case[name][i])) for name in names),
        ]
        for i, event in enumerate(events[:MAX_ROWS])
    ]
    columns = [
        "event",
        "time (s)",
        "end (s)",
        "impulse (N s)",
        *(f"{name.replace('event_', 'largest ').replace('_', ' ')} ({_unit(case, name)})" for name in names),
    ]
    return Table("Events", columns, rows, f"{MAX_ROWS} of {len(events)} events" if len(events) > MAX_ROWS else "")


def _histories(case: xr.Dataset) -> Table | None:
    """Peak and estimated error of each history at each point, and what is proved of it.

    Of many rows those stay that hold the largest of each quantity, as many of one as of another.
    """
    rows: list[list[str]] = []
    peaks: list[list[float]] = []
    for name in ("displacement", "velocity", "acceleration", "bending_moment", "shear_force"):
        peaks.append([])
        for point in range(case.sizes.get("point", 0) if name in case else 0):
            peak = float(np.nanmax(np.abs(case[name][point].values), initial=0.0))
            peaks[-1].append(peak)
            error = float(case[f"{name}_error"][point]) if f"{name}_error" in case else math.nan
            share = number_text(error / peak if peak > 0.0 else math.nan, 2)
            place = f"{float(case['point_position'][point]):.4g}"
            rows.append(
                [
                    name.replace("_", " "),
                    place,
                    number(peak),
                    _unit(case, name),
                    number_text(error, 2),
                    share,
                    number_text(float(case[f"{name}_bound"][point]), 2, up=True) if f"{name}_bound" in case else "–",
                ]
            )
    columns = ["history", "at ξ", "largest", "unit", "estimated error", "error over the largest", "surely below"]
    ranks = np.concatenate([np.argsort(np.argsort(-np.array(found), kind="stable")) for found in peaks])
    shown = np.sort(np.argsort(ranks, kind="stable")[:MAX_ROWS])
    note = f"{MAX_ROWS} of {len(rows)}, those of the largest of each quantity" if len(rows) > MAX_ROWS else ""
    return Table("Histories", columns, [rows[i] for i in shown], note)


def _peaks(case: xr.Dataset) -> Table | None:
    """What was measured, each number with its error."""
    names = [str(name) for name in case.variables if str(name).startswith("measured_") and case[name].dims == ("peak",)]
    names = [name for name in names if not name.endswith(("_error", "_bound"))]
    if "measured_angular_frequency" not in names:
        return None
    beta = case["measured_angular_frequency"].values
    told = "peak_status" in case
    columns = [
        "peak",
        "frequency (Hz)",
        *(f"{name.removeprefix('measured_').replace('_', ' ')} ({_unit(case, name)})" for name in names),
    ]
    rows = []
    for i in np.flatnonzero(np.isfinite(beta))[:MAX_ROWS]:
        values = [_with_error(case, name, i) for name in names]
        status = [status_words(case["peak_status"], int(case["peak_status"][i]))] if told else []
        rows.append([str(int(case["peak"][i])), number(beta[i] / (2.0 * np.pi)), *values, *status])
    return Table("Measured in the histories", columns + (["status"] if told else []), rows)


def _with_error(case: xr.Dataset, name: str, i: int) -> str:
    """A number and, where the file has it, its error."""
    value = float(case[name][i])
    error = float(case[f"{name}_error"][i]) if f"{name}_error" in case else math.nan
    return number(value) + (f" ± {number_text(error, 2)}" if math.isfinite(value) and math.isfinite(error) else "")


def _unit(case: xr.Dataset, name: str) -> str:
    return unit_text(units_of(case[name])) or "1"
