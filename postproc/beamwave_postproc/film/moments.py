"""Which samples of a long record are shown one after another, as the frames of a film."""

from __future__ import annotations

import numpy as np

MOST_FRAMES = 160
FRAMES_PER_PERIOD = 24  # of the slowest mode, so that its motion is smooth
MOST_SCENES = 4  # parts of a record that are shown, each around an event
LEAD = 0.2  # of a part's frames that come before its event


def chosen_samples(time: np.ndarray, period: float, events: list[float], frames: int = MOST_FRAMES) -> np.ndarray:
    """Indices into `time`, ascending: all of a short record; of a long one the parts around its `events`.

    A record is short when `frames` show the slowest mode's `period` (s, NaN where unknown) often enough.
    """
    even = -(-time.size // frames)
    if time.size < 2 or not (even * (time[1] - time[0]) > period / FRAMES_PER_PERIOD):
        return np.arange(0, time.size, even)
    stride = max(int(period / FRAMES_PER_PERIOD / (time[1] - time[0])), 1)
    starts = _starts(time, [0.0, *events], stride * frames)
    length = frames // len(starts)
    parts = [start + stride * np.arange(length) for start in starts]
    chosen = np.unique(np.concatenate(parts))
    return chosen[chosen < time.size]


def _starts(time: np.ndarray, events: list[float], samples: int) -> list[int]:
    """First sample of each part, `samples` being those of all parts together."""
    for count in range(MOST_SCENES, 0, -1):
        length = samples // count
        starts: list[int] = []
        for event in sorted(event for event in events if event <= time[-1]):
            first = max(int(np.searchsorted(time, event) - LEAD * length), 0)
            if not starts or first > starts[-1] + (1.0 - 2.0 * LEAD) * length:
                starts.append(first)
        if len(starts) >= count:
            return starts[:count]
    return [0]
