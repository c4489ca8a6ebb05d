"""Each line of a record by itself over time."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..parts.envelope import is_thinned, recorded_part
from ..parts.sensors import one_record, sensor_label, sensor_name
from ..parts.sheet import Given, columns_for, sheet_for
from ..parts.units import with_unit
from ..result import NothingToDraw, require
from ..style import COLOURS, logarithmic, styled

MAX_LINES = 6
NARROW = 3.0  # periods of the distance to the nearest line, or of the lowest frequency, over which is averaged
LEAST_LIVES = 4.0  # averages in the record, below which there is nothing to see


@styled
def record_envelopes(ds: xr.Dataset, *, ax: Given = None) -> Figure:
    """Draw the envelope of each of the strongest lines at the sensor that shows it best: A e^(−δt) from the blow on.

    Beside it stands what the record itself shows there: shifted by the line's frequency, and averaged over some periods of its
    distance to the next line; where samples are left out, the lines take their place. A line that decays as fitted is straight. Of a
    sweep the first case is drawn.
    """
    case, note = one_record(ds)
    names = ["angular_frequency", "decay_rate", "decay_rate_error", "amplitude", "blow_time"]
    require(case, "recorded", "fitted", "time", *(f"measured_{name}" for name in names))
    time, recorded = case["time"].values, case["recorded"].values
    part = recorded_part(recorded)
    time, recorded = time[part], np.where(np.isfinite(recorded), recorded, case["fitted"].values)[:, part]
    if time.size < 64 or np.ptp(np.diff(time)) > 0.01 * (time[-1] - time[0]) / time.size:
        raise NothingToDraw("the samples are not in the file, or uneven")
    beta, decay, decay_error, size = (case[f"measured_{name}"].values for name in names[:4])
    blow, lines = float(case["measured_blow_time"]), np.flatnonzero(np.isfinite(beta))
    if not lines.size or not np.isfinite(blow) or is_thinned(recorded):
        raise NothingToDraw("the record has no lines, or its samples are not in the file")
    shown = np.sort(lines[np.argsort(-np.nanmax(size[:, lines], axis=0))][:MAX_LINES])
    left = f"the {shown.size} strongest of {lines.size} lines" if shown.size < lines.size else ""
    columns = columns_for(shown.size)
    sheet = sheet_for(ax, -(-shown.size // columns), columns, width=4.8 * columns, height=2.3, share="x")
    drawn = time >= blow
    for axes, line in zip(sheet.axes, shown):
        sensor = int(np.nan_to_num(size[:, line]).argmax())
        seen = _demodulated(time[drawn], recorded[sensor, drawn], beta, line)
        if seen is not None:
            axes.plot(*seen, color="0.7", linewidth=4.0, label="record about the line")
        since = time[drawn] - blow
        envelope = size[sensor, line] * np.exp(-decay[line] * since)
        axes.plot(time[drawn], envelope, color=COLOURS[2], linewidth=1.2, label=r"line, $A\,\mathrm{e}^{-\delta t}$")
        if np.isfinite(decay_error[line]):
            spread = np.exp(decay_error[line] * since)
            axes.fill_between(time[drawn], envelope / spread, envelope * spread, color=COLOURS[2], alpha=0.25, linewidth=0)
        top = 2.0 * envelope[0]
        low = 0.5 * np.nanpercentile(seen[1], 5) if seen is not None else envelope[-1]
        logarithmic(axes, "y", max(low, 1e-5 * top), top)
        axes.set_xlim(time[0], time[-1])
        axes.set_title(f"line {line + 1}, {with_unit(beta[line] / (2.0 * np.pi), 'Hz')}; {sensor_name(case, sensor)}")
        axes.set_ylabel(sensor_label(case, sensor).splitlines()[-1])
    for axes in list(sheet.axes)[shown.size :]:
        axes.set_visible(False)
    for axes in list(sheet.axes)[shown.size - columns : shown.size]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("Time since the first sample (s)")
    return sheet.finish(case, [note, left])


def _demodulated(time: np.ndarray, values: np.ndarray, beta: np.ndarray, line: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Times and size of the motion about a line: shifted to frequency 0, and averaged under a Hann window."""
    others = np.delete(beta, line)
    away = np.abs(others[np.isfinite(others)] - beta[line])
    nearest = min([beta[line], *away])
    width = NARROW * 2.0 * np.pi / nearest
    step = time[1] - time[0]
    count = 2 * int(width / step / 2) + 1
    if count * LEAST_LIVES > time.size or count < 3:
        return None
    window = np.hanning(count + 2)[1:-1]
    shifted = (values - values.mean()) * np.exp(-1j * beta[line] * time)
    middle = 2.0 * np.abs(np.convolve(shifted, window / window.sum(), "valid"))
    half = count // 2
    return time[half : time.size - half], middle
