"""The moving beam as a film: in the rotating frame, and seen from above where the hub turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from ..parts.describe import brief_of, title_of, turns_out_of_plane
from ..parts.events import Event, events_of
from ..parts.growth import grows, samples_held
from ..parts.line import FEW_POINTS, SAME_PLACE, beam_line, is_clamped, moving_points, places_of_line
from ..parts.passage import blow_at, length_of
from ..parts.places import turn_of_line
from ..parts.points import error_warning
from ..parts.select import one_case
from ..result import require, require_numbers
from .carried import Carried, carried_in, first_mode, named
from .mass_path import Tip, mass_path
from .moments import MOST_FRAMES, chosen_samples

FINE = 200  # places along the beam that are drawn
APPROACH = 12  # frames before the impact


@dataclass(frozen=True)
class Motion:
    """Where everything is in each frame: what a film draws. SI units."""

    time: np.ndarray  # (frames), < 0 before the impact
    place: np.ndarray  # x along the beam, m, (fine)
    line: np.ndarray  # deflection, m, (frames, fine)
    points: np.ndarray  # x of the result's points, m
    deflection: np.ndarray  # of these, m, (frames, points)
    mass: np.ndarray | None  # deflection of the mass, m, (frames); None without one
    held: np.ndarray  # whether the beam holds it, (frames)
    events: list[list[Event]]  # that happen between the frame before and this one
    flashes: list[np.ndarray]  # x of these, m
    length: float  # of the beam, m
    clamped: bool  # the root
    angle: np.ndarray | None  # of the hub, rad, (frames); None where it does not turn
    out_of_plane: bool
    grows: bool
    struck: float  # x of the blow, m
    carried: Carried  # by the beam
    first_mode: list[str]  # its frequency in words, where it changes
    title: str  # of the scene
    scene: list[str]  # its file, effects and inputs, of a sweep those of the case
    warning: str  # of a motion that may be nothing but error
    remarks: list[str]  # what the film cannot show


def motion(ds: xr.Dataset, frames: int = MOST_FRAMES) -> Motion:
    """Positions of beam, mass and hub in at most `frames` moments after the impact and a few before it.

    Of a sweep the first case is shown. Raises `NothingToDraw` without histories.
    """
    require(ds, "displacement", "time", "point_position")
    case, _ = one_case(ds)
    require_numbers(case["displacement"].values, "displacement")
    order = moving_points(case)
    xi, length = case["point_position"].values[order], length_of(case)
    time = case["time"].values[: samples_held(case, "displacement")]
    history = case["displacement"].values[order, : time.size].T
    chosen = chosen_samples(time, _period(case), [event.time for event in events_of(case)], frames)
    lead = _lead(case, time[chosen])
    moments = np.concatenate((lead, time[chosen]))
    deflection = np.vstack((np.zeros((lead.size, xi.size)), history[chosen]))
    fine = places_of_line(case, xi, FINE)
    mass, held = _mass(case, order, time, moments)
    events, flashes = _events_by_frame(case, moments)
    return Motion(
        time=moments,
        place=fine * length,
        line=beam_line(case, xi, deflection)(fine).T,
        points=xi * length,
        deflection=deflection,
        mass=mass,
        held=held,
        events=events,
        flashes=[length * places for places in flashes],
        length=length,
        clamped=is_clamped(case),
        angle=_angle(case, moments),
        out_of_plane=turns_out_of_plane(case),
        grows=grows(case),
        struck=blow_at(case) * length,
        carried=carried_in(case, moments, length),
        first_mode=first_mode(case, moments),
        title=title_of(ds),
        scene=brief_of(case),
        warning=error_warning([case], "displacement"),
        remarks=_remarks(ds, xi),
    )


def _period(case: xr.Dataset) -> float:
    """Period (s) of the slowest mode that oscillates, in any configuration; NaN where that is not known."""
    names = [name for name in ("angular_frequency", "configuration_angular_frequency") if name in case]
    frequency = np.concatenate([np.empty(0), *(case[name].values.ravel() for name in names)])
    frequency = frequency[np.isfinite(frequency) & (frequency > 0.0)]
    return float(2.0 * np.pi / frequency.min()) if frequency.size else float("nan")


def _lead(case: xr.Dataset, time: np.ndarray) -> np.ndarray:
    """Moments before the impact, at the pace of those after it; none without an impact."""
    if not any(event.kind == "impact" for event in events_of(case)) or time.size < 2:
        return np.empty(0)
    return (time[1] - time[0]) * np.arange(-APPROACH, 0)


def _mass(
    case: xr.Dataset, order: np.ndarray, time: np.ndarray, moments: np.ndarray
) -> tuple[np.ndarray | None, np.ndarray]:
    """Position of the mass from the beam's straight line, and whether the beam holds it; None without one, or without a
    point where it strikes."""
    near = order[np.abs(case["point_position"].values[order] - blow_at(case)) < SAME_PLACE]
    if not _is_struck(case) or not events_of(case) or not near.size or time.size < 3:
        return None, np.zeros(moments.size, dtype=bool)
    velocity = case["velocity"].values[near[0], : time.size] if "velocity" in case and "hub_angle" not in case else None
    turn = turn_of_line(case, int(near[0]))[: time.size]
    position, held = mass_path(case, Tip(time, case["displacement"].values[near[0], : time.size] + turn, velocity), moments)
    return position - np.interp(moments, time, turn), held


def _is_struck(ds: xr.Dataset) -> bool:
    """Whether a mass strikes the beam."""
    return any(name in ds for name in ("impact_mass", "impact_mass_ratio"))


def _events_by_frame(case: xr.Dataset, moments: np.ndarray) -> tuple[list[list[Event]], list[np.ndarray]]:
    """Each event at the first frame that is not before it, and the places ξ of all; those that fall into a gap between parts are not shown."""
    shown: list[list[Event]] = [[] for _ in moments]
    places: list[list[float]] = [[] for _ in moments]
    steps = np.diff(moments, prepend=moments[0])
    usual = np.median(steps[1:]) if moments.size > 1 else 0.0
    for event in events_of(case):
        frame = int(np.searchsorted(moments, event.time))
        if frame < moments.size and moments[frame] - event.time <= 1.5 * usual:
            told, own = named(case, event)
            shown[frame].append(told)
            places[frame] += [blow_at(case)] if own is None else own
    return shown, [np.unique(there) for there in places]


def _angle(case: xr.Dataset, moments: np.ndarray) -> np.ndarray | None:
    """Angle of the hub, 0 at the impact."""
    rate = float(case.get("rotation_angular_velocity", 0.0))
    return rate * moments if rate != 0.0 else None


def _remarks(ds: xr.Dataset, xi: np.ndarray) -> list[str]:
    """What a user would miss in the film, and what to do about it."""
    found = []
    if xi.size < FEW_POINTS:
        found.append(
            f"the beam's line is drawn through {xi.size} moving point{'s' * (xi.size > 1)} and the root only; "
            "for its form give more, as &response points = 0.05, 0.1, … 1.0"
        )
    if abs(xi[-1] - 1.0) > SAME_PLACE:
        found.append("the tip, 1.0, is not among the points: the beam ends at the last of them")
    if _is_struck(ds) and not np.any(np.abs(xi - blow_at(ds)) < SAME_PLACE):
        found.append(f"the place of the blow, {blow_at(ds):g}, is not among the points: no mass is drawn")
    if "case" in ds.dims and ds.sizes["case"] > 1:
        found.append(f"the film shows the first of {ds.sizes['case']} cases")
    return found
