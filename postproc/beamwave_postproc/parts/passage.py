"""How long waves take along the beam, and a force acts: what a picture of a whole record is too coarse to show."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .events import events_of
from .moving import half_the_sampling_rate, last_modes, sampled_frequencies
from .relation import relation_of

PASSAGES = 1.5  # of the waves of mode 2 along the beam, that the first part of a record is long
LEAST_SAMPLES = 60  # in that part, that it is worth a picture
MOST = 0.4  # of the record: a longer first part is the record
SPAN = 25.0  # frequencies down to this part of the highest are given the time to arrive
WAVES = (
    4.0  # that pass in the time of one length at the highest frequency, at least: with fewer nothing arrives sharply
)
RETURNS = 2.5  # lengths of the beam that they run in that time
SHORT = 0.05  # of the record: a force that acts no longer is less than half a centimetre of a column of a journal
MOSTLY = 0.9  # of its impulse: what is given later does not count
AFTER = 1.5  # times as long as the force acts: what is seen of the motion
LOWEST = 1e-5  # of the highest frequency: where a smooth relation starts


def first_part(case: xr.Dataset) -> float | None:
    """Time (s) in which the first waves run to and fro, where the record is much longer and resolves it; else None."""
    if "group_velocity" not in case:
        return None
    velocity = case["group_velocity"].values
    velocity = velocity[np.isfinite(velocity) & (velocity > 0.0)]
    if not velocity.size:
        return None
    end = PASSAGES * length_of(case) / velocity[min(1, velocity.size - 1)]
    return float(end) if _is_resolved(case, end) and end < MOST * _duration(case) else None


def acted_part(cases: list[xr.Dataset]) -> tuple[float, float] | None:
    """Times (s) between which contacts and forces act on each of `cases` and the first waves run, where that is too short to be seen in the record.

    None where nothing lasting acts, where it acts in a fair part of the record, and where the samples do not resolve it.
    """
    acting = [found for found in map(_acting, cases) if found]
    if not acting or len(acting) < len(cases):
        return None
    begin, end = min(begin for begin, _ in acting), max(end for _, end in acting)
    step = float(cases[0]["time"][1] - cases[0]["time"][0])
    length = max(AFTER * (end - begin), LEAST_SAMPLES * step, *(first_part(case) or 0.0 for case in cases))
    record = _duration(cases[0])
    seen = end - begin > SHORT * record or length > MOST * record or begin + length > float(cases[0]["time"][-1])
    return None if seen else (begin, begin + length)


def _acting(case: xr.Dataset) -> tuple[float, float] | None:
    """When (s) contacts and forces begin to act on a case, and have given most of their impulse; None where that is not known or takes no time."""
    if "time" not in case or case["time"].size < 2:
        return None
    spans = [(event.time, event.end, abs(event.impulse)) for event in events_of(case) if event.kind == "contact"]
    if "applied_impulse" in case and {"force_start", "force_duration"} <= set(case.variables):
        start, duration, impulse = (np.atleast_1d(case[name].values) for name in ("force_start", "force_duration", "applied_impulse"))
        spans += list(zip(start, start + duration, np.abs(impulse)))
    spans = [span for span in spans if float(case["time"][0]) <= span[0] <= float(case["time"][-1])]
    if not spans or not np.isfinite(spans).all():
        return None
    begin, end, impulse = np.array(sorted(spans)).T
    most = int(np.searchsorted(np.cumsum(impulse), MOSTLY * impulse.sum()))
    last = float(end[: most + 1].max())
    return (float(begin[0]), last) if last > begin[0] else None


def arrivals(case: xr.Dataset) -> float | None:
    """Time (s) in which waves of most frequencies arrive and return, at most that of the record.

    None where the samples are too coarse to tell, or the modes' wave velocities are not there.
    """
    if not {"angular_frequency", "group_velocity", "wavenumber"} <= set(case.variables):
        return None
    beta, velocity, _ = group_velocities(case)
    if beta.size < 2:
        return None
    highest, frequency, length = highest_frequency(case), beta / (2.0 * np.pi), length_of(case)
    if highest * length < WAVES * np.interp(highest, frequency, velocity):
        return None
    end = min(RETURNS * length / float(np.interp(highest / SPAN, frequency, velocity)), _duration(case))
    return end if _is_resolved(case, end) else None


def highest_frequency(case: xr.Dataset) -> float:
    """Highest frequency (Hz) that a history holds: of its samples, or of its modes where those are all in the file.

    After a release those of the beam alone count as well.
    """
    nyquist = half_the_sampling_rate(case)
    frequencies = sampled_frequencies(case)
    all_there = "mode_count" in case and int(case["mode_count"]) <= case["angular_frequency"].size
    there = all_there and last_modes(case) is not None and frequencies.size > 0
    return min(nyquist, float(frequencies[-1])) if there else nyquist


def _is_resolved(case: xr.Dataset, end: float) -> bool:
    return case.sizes["time"] > 1 and end > LEAST_SAMPLES * float(case["time"][1] - case["time"][0])


def _duration(case: xr.Dataset) -> float:
    return float(case["time"][-1] - case["time"][0])


def length_of(case: xr.Dataset) -> float:
    """Length of the beam (m), of all its pieces together; 1 where it is not known."""
    return float(case["beam_length"].sum()) if "beam_length" in case else 1.0


def way_times(case: xr.Dataset, xi: float, ways: int) -> tuple[np.ndarray, list[np.ndarray], bool]:
    """Frequencies (Hz) and, for each of the shortest `ways` from the blow to ξ, the time (s) that their waves take.

    The ways are straight, then by reflections at root and tip, at `group_velocities`, whose last value is handed on.
    """
    beta, velocity, smooth = group_velocities(case)
    length = length_of(case)
    return beta / (2.0 * np.pi), [way * length / velocity for way in ways_to(blow_at(case), xi)[:ways]], smooth


def group_velocities(case: xr.Dataset) -> tuple[np.ndarray, np.ndarray, bool]:
    """Angular frequencies (rad/s), ascending, their group velocities (m/s), and whether they are a smooth relation's.

    Of the dispersion relation where the modes obey it, up to the highest that samples can hold, else of the modes. The
    relation is the beam's, whatever is at its tip: modes with the mass tell it up to a release and after it.
    """
    relation = relation_of(case)
    if relation is not None:
        highest = np.pi / float(case["time"][1] - case["time"][0])
        beta = np.geomspace(LOWEST * highest, highest, 400)
        return beta, relation.value("group_velocity", beta), True
    beta, velocity = case["angular_frequency"].values, case["group_velocity"].values
    known = np.flatnonzero(np.isfinite(beta) & (beta > 0.0) & np.isfinite(velocity))
    known = known[np.argsort(beta[known])]
    return beta[known], velocity[known], False


def ways_to(start: float, xi: float) -> list[float]:
    """Lengths of the ways from `start` to `xi` (both ξ), by reflections at 0 and 1; the shortest first, without 0."""
    images = [2.0 * turn + side * start for turn in range(-2, 3) for side in (-1.0, 1.0)]
    return sorted({round(abs(image - xi), 12) for image in images} - {0.0})


def blow_at(case: xr.Dataset) -> float:
    """Where the mass strikes, ξ; of a sweep over that, in the first case."""
    return float(case["impact_position"].values.flat[0]) if "impact_position" in case else 1.0
