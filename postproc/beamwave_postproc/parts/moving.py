"""Which of a result's modes move in its samples: those with the mass, and after a release those of the beam alone."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .events import events_of
from .units import with_unit

ALONE = "_before"  # ends the names of the modes of the beam alone, where the file has them beside those with the mass
OF_MODES = ("alpha", "wavenumber", "angular_frequency", "growth_rate", "phase_velocity", "group_velocity")
BEYOND = 1.0 + 1e-9  # times half the sampling rate: a mode above it is aliased


def is_released(case: xr.Dataset) -> bool:
    """Whether the mass leaves the beam within the record of one case."""
    return any(event.kind == "release" for event in events_of(case))


def last_modes(case: xr.Dataset) -> xr.Dataset | None:
    """The modes that move after the last event, in which waves are measured, under the names without an ending.

    After a release they are those of the beam alone; None where the file lacks these, as with a tolerance.
    """
    if not is_released(case):
        return case[[name for name in (*OF_MODES, "mode") if name in case]]
    names = [name for name in OF_MODES if name + ALONE in case]
    if "angular_frequency" not in names:
        return None
    alone = case[[name + ALONE for name in names]].rename({name + ALONE: name for name in names})
    return alone.rename(mode_before="mode")


def sampled_frequencies(case: xr.Dataset) -> np.ndarray:
    """Frequencies (Hz) of the modes in the file that move at any time in the record, ascending."""
    sets = [case["angular_frequency"].values] if "angular_frequency" in case else []
    last = last_modes(case)
    if is_released(case) and last is not None:
        sets.append(last["angular_frequency"].values)
    beta = np.concatenate([np.ravel(values) for values in sets]) if sets else np.empty(0)
    return np.unique(beta[np.isfinite(beta) & (beta > 0.0)]) / (2.0 * np.pi)


def half_the_sampling_rate(case: xr.Dataset) -> float:
    """In Hz: a line above it is aliased below; infinite without samples to tell."""
    return 0.5 / float(case["time"][1] - case["time"][0]) if "time" in case and case["time"].size > 1 else np.inf


def folded_frequencies(case: xr.Dataset) -> np.ndarray:
    """Where (Hz, ascending) the samples show those of the last modes that lie above half the sampling rate."""
    last, half = last_modes(case), half_the_sampling_rate(case)
    if last is None or "angular_frequency" not in last or not np.isfinite(half):
        return np.empty(0)
    frequency = np.ravel(last["angular_frequency"].values) / (2.0 * np.pi)
    above = frequency[np.isfinite(frequency) & (frequency > BEYOND * half)]
    return np.sort(np.abs(above - 2.0 * half * np.round(above / (2.0 * half))))


def folding_note(cases: list[xr.Dataset], mark: str = "") -> str:
    """That lines are aliased, where modes of `cases` lie above half the sampling rate, and by which `mark`."""
    folding = [case for case in cases if _is_folding(case)]
    if not folding:
        return ""
    half = half_the_sampling_rate(folding[0])
    words = f"lines of modes above half the sampling rate ({with_unit(half, 'Hz')}) are aliased"
    marked = [case for case in folding if folded_frequencies(case).size]
    if not mark or not marked:
        return words
    all_there = all(not _has_more_modes(case) and last_modes(case) is not None for case in folding)
    there = last_modes(marked[0]).sizes["mode"]
    return f"{words}; {mark} marks " + ("them" if all_there else f"those of the {there} modes in the file")


def _is_folding(case: xr.Dataset) -> bool:
    """Whether a mode lies above half the sampling rate: one in the file, or one that its notes tell of."""
    half, frequencies = half_the_sampling_rate(case), sampled_frequencies(case)
    if not np.isfinite(half) or not frequencies.size:
        return False
    return bool(frequencies[-1] > BEYOND * half) or (
        (_has_more_modes(case) or last_modes(case) is None) and "aliased" in str(case.attrs.get("notes", ""))
    )


def _has_more_modes(case: xr.Dataset) -> bool:
    return "mode_count" in case and float(case["mode_count"]) > case["angular_frequency"].size
