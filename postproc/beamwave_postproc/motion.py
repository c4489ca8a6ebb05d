"""The moving beam as a film: in the rotating frame, and seen from above where the hub turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from .events import Event, events_of
from .growth import grows, samples_held
from .labels import value_text
from .mass_path import Tip, mass_path, turns_out_of_plane
from .moments import MOST_FRAMES, chosen_samples
from .result import NothingToDraw, require, require_numbers, swept_inputs
from .spline import clamped_spline

FINE = 200  # places along the beam that are drawn
FEW_POINTS = 9  # a line through fewer has not the beam's form
APPROACH = 12  # frames before the impact
SAME_PLACE = 1e-9  # positions are typed as decimals


@dataclass(frozen=True)
class Motion:
    """Where everything is in each frame: what a film draws. SI units."""

    time: np.ndarray  # (frames), < 0 before the impact
    place: np.ndarray  # x along the beam, m, (fine)
    line: np.ndarray  # deflection, m, (frames, fine)
    points: np.ndarray  # x of the result's points, m
    deflection: np.ndarray  # of these, m, (frames, points)
    mass: np.ndarray | None  # deflection of the mass, m, (frames); None without one
    held: np.ndarray  # whether the tip holds it, (frames)
    events: list[list[Event]]  # that happen between the frame before and this one
    length: float  # of the beam, m
    angle: np.ndarray | None  # of the hub, rad, (frames); None where it does not turn
    out_of_plane: bool
    grows: bool
    label: str  # the scene's title and, of a sweep, the case
    remarks: list[str]  # what the film cannot show


def motion(ds: xr.Dataset, frames: int = MOST_FRAMES) -> Motion:
    """Positions of beam, mass and hub in at most `frames` moments after the impact and a few before it.

    Of a sweep the first case is shown. Raises `NothingToDraw` without histories.
    """
    require(ds, "displacement", "time", "point_position")
    case = ds.isel(case=0) if "case" in ds.dims else ds
    require_numbers(case["displacement"].values, "displacement")
    if not np.any(case["point_position"].values > SAME_PLACE):
        raise NothingToDraw("the only point is the clamped root")
    order = _moving_points(case)
    xi, length = case["point_position"].values[order], float(case["beam_length"])
    time = case["time"].values[: samples_held(case, "displacement")]
    history = case["displacement"].values[order, : time.size].T
    chosen = chosen_samples(time, _period(case), [event.time for event in events_of(case)], frames)
    lead = _lead(case, time[chosen])
    moments = np.concatenate((lead, time[chosen]))
    deflection = np.vstack((np.zeros((lead.size, xi.size)), history[chosen]))
    fine = np.linspace(0.0, xi[-1], FINE)
    mass, held = _mass(case, order, time, moments)
    return Motion(
        time=moments,
        place=fine * length,
        line=deflection @ clamped_spline(xi, fine).T,
        points=xi * length,
        deflection=deflection,
        mass=mass,
        held=held,
        events=_events_by_frame(case, moments),
        length=length,
        angle=_angle(case, moments),
        out_of_plane=turns_out_of_plane(case),
        grows=grows(case),
        label=_label(ds, case),
        remarks=_remarks(ds, xi),
    )


def _moving_points(case: xr.Dataset) -> np.ndarray:
    """Indices of the points that move, by their place, each place once."""
    positions = case["point_position"].values
    places, order = np.unique(np.round(positions / SAME_PLACE), return_index=True)
    return order[places > 0.5]


def _period(case: xr.Dataset) -> float:
    """Period (s) of the slowest mode that oscillates; NaN where that is not known."""
    if "angular_frequency" not in case:
        return float("nan")
    frequency = case["angular_frequency"].values
    frequency = frequency[np.isfinite(frequency) & (frequency > 0.0)]
    return float(2.0 * np.pi / frequency.min()) if frequency.size else float("nan")


def _lead(case: xr.Dataset, time: np.ndarray) -> np.ndarray:
    """Moments before the impact, at the pace of those after it; none without an impact."""
    if not any(event.kind == "impact" for event in events_of(case)) or time.size < 2:
        return np.empty(0)
    return (time[1] - time[0]) * np.arange(-APPROACH, 0)


def _mass(case: xr.Dataset, order: np.ndarray, time: np.ndarray, moments: np.ndarray) -> tuple[np.ndarray | None, np.ndarray]:
    """Position of the mass, and whether it is held; None without a mass, or where the tip is not among the points."""
    none = None, np.zeros(moments.size, dtype=bool)
    tip = order[-1]
    if not events_of(case) or abs(float(case["point_position"][tip]) - 1.0) > SAME_PLACE or time.size < 3:
        return none
    velocity = case["velocity"].values[tip, : time.size] if "velocity" in case else None
    return mass_path(case, Tip(time, case["displacement"].values[tip, : time.size], velocity), moments)


def _events_by_frame(case: xr.Dataset, moments: np.ndarray) -> list[list[Event]]:
    """Each event at the first frame that is not before it; those that fall into a gap between parts are not shown."""
    shown: list[list[Event]] = [[] for _ in moments]
    steps = np.diff(moments, prepend=moments[0])
    usual = np.median(steps[1:]) if moments.size > 1 else 0.0
    for event in events_of(case):
        frame = int(np.searchsorted(moments, event.time))
        if frame < moments.size and moments[frame] - event.time <= 1.5 * usual:
            shown[frame].append(event)
    return shown


def _angle(case: xr.Dataset, moments: np.ndarray) -> np.ndarray | None:
    """Angle of the hub, 0 at the impact."""
    rate = float(case.get("rotation_angular_velocity", 0.0))
    return rate * moments if rate != 0.0 else None


def _label(ds: xr.Dataset, case: xr.Dataset) -> str:
    """Title of the scene, and which case of a sweep is shown."""
    inputs = ", ".join(value_text(case[name]) for name in swept_inputs(ds)) if "case" in ds.dims else ""
    return "; ".join(filter(None, (str(ds.attrs.get("title", "")), inputs)))


def _remarks(ds: xr.Dataset, xi: np.ndarray) -> list[str]:
    """What a user would miss in the film, and what to do about it."""
    found = []
    if xi.size < FEW_POINTS:
        found.append(
            f"the beam's line is drawn through {xi.size} moving point{'s' * (xi.size > 1)} and the root only; "
            "for its form give more, as &response points = 0.05, 0.1, … 1.0"
        )
    if abs(xi[-1] - 1.0) > SAME_PLACE:
        found.append("the tip, 1.0, is not among the points: the beam ends at the last of them, and no mass is drawn")
    if "case" in ds.dims and ds.sizes["case"] > 1:
        found.append(f"the film shows the first of {ds.sizes['case']} cases")
    return found
