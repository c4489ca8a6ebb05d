"""Which of a result's modes move in its samples: those with the mass, and after a release those of the beam alone."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .events import events_of

ALONE = "_before"  # ends the names of the modes of the beam alone, where the file has them beside those with the mass
OF_MODES = ("alpha", "wavenumber", "angular_frequency", "growth_rate", "phase_velocity", "group_velocity")


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
