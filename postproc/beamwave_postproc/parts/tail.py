"""The amplitude spectrum of what moves freely to the end of a record."""

from __future__ import annotations

import numpy as np
import xarray as xr

from .events import events_of
from .units import with_unit

LEAST_SAMPLES = 64  # of a spectrum


def spectrum_after_events(case: xr.Dataset) -> tuple[np.ndarray, np.ndarray, str]:
    """Frequencies (Hz), amplitudes (point, frequency) in m, and what they are of where that is not the whole record.

    Where an event changes the beam, or a contact ends, within the record, the samples after the last of them are transformed under
    Hann's window: `amplitude` has the lines of what the beam was before, too. Elsewhere they are those of the file.
    """
    whole = case["frequency"].values, case["amplitude"].values, ""
    last = max((end for event in events_of(case) for end in (event.time, event.end) if np.isfinite(end)), default=0.0)
    time = case["time"].values if "time" in case and "displacement" in case else np.empty(0)
    after = time > last
    if last <= 0.0 or np.count_nonzero(after) < LEAST_SAMPLES or not np.isfinite(case["amplitude"].values).any():
        return whole
    history = case["displacement"].values[:, after]
    window = np.hanning(history.shape[1] + 1)[:-1]
    amplitude = 2.0 * np.abs(np.fft.rfft(window * history)) / window.sum()
    frequency = np.fft.rfftfreq(history.shape[1], float(time[1] - time[0]))
    return frequency, amplitude, f"of the samples after the last event, at {with_unit(last, 's', 3)}"
