"""Records of struck, shaken and let-go beams: lines missed, lines that are none, and what intervals hold.

    python -m records.struck PROGRAM DRAWS [CLASS …]

from `bench/`. A line has to be found where its gain exceeds three times what noise alone reaches; a line that drifts is held by an
interval that holds it from its beginning to its end.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from .cells import nearest_pairs
from .draws import Draw, Shaken, Struck
from .tools import write_record

CLASSES = {
    kind.words: kind
    for kind in (
        Struck("plain"),
        Struck("coloured", colour=0.9),
        Struck("quiet", quiet=0.1),
        Struck("blows", quiet=0.05, blows=5),
        Struck("clipped", clipped=0.005),
        Struck("crests", clipped=0.2),
        Struck("missing", missing=0.01),
        Struck("drift", drift=0.02),
        Struck("tone", quiet=0.05, tone=True),
        Struck("damped", ratios=(0.05, 0.1), decibels=(40, 40)),
        Shaken("ambient"),
    )
}
SECONDS = 60  # that a record may take
RADIUS = 5.0  # bounds of a frequency, within which a line is the one that was drawn

Found = np.ndarray  # frequency [Hz], half its interval, decay [1/s], half its interval, whether it drifts: (5, lines)


def by_program(program: Path, drawn: Draw, directory: Path) -> Found:
    """The lines that beamwave finds."""
    from netCDF4 import Dataset

    write_record(directory / "record.csv", drawn.times, drawn.values)
    (directory / "scene.nml").write_text("&record\n  file = 'record.csv'\n/\n&spectrum\n  max_peaks = 40\n/\n")
    words = [program, "run", directory / "scene.nml", "--output", directory, "--quiet"]
    subprocess.run(words, capture_output=True, timeout=SECONDS, check=False)
    names = ("angular_frequency", "angular_frequency_error", "decay_rate", "decay_rate_error")
    with Dataset(directory / "scene.nc") as data:
        count = int(data["peak_count"][:])
        rows = [np.ma.filled(data[f"measured_{name}"][:].astype(float), np.inf)[:count] for name in names]
        drifts = (np.ma.filled(data["peak_status"][:], 0)[:count].astype(int) & 8) > 0
    return np.array([rows[0] / (2 * np.pi), rows[1] / (2 * np.pi), rows[2], rows[3], drifts])


def pairs_of(drawn: Draw, found: Found) -> np.ndarray:
    """The place among the found lines of each that was drawn, −1 for none; the nearest first."""
    low, high = np.minimum(drawn.frequencies, drawn.ends), np.maximum(drawn.frequencies, drawn.ends)
    away = np.maximum(0, np.maximum(low[:, None] - found[0], found[0] - high[:, None]))
    away = away + 1e-9 * np.abs((low + high)[:, None] / 2 - found[0])
    radius = np.maximum(drawn.resolution(), RADIUS * drawn.bounds[0])[:, None] + 0 * found[1]
    radius = np.maximum(radius, np.where(found[1] < 50 * radius, found[1], 0))
    away[away > radius] = np.inf
    pairs = -np.ones(len(low), int)
    for line, place in nearest_pairs(away):
        pairs[line] = place
    return pairs


class Tally:
    """What is counted over the draws of a class."""

    def __init__(self) -> None:
        self.needed = self.missed = self.false = self.failed = self.draws = 0
        self.inside: list[tuple[bool, bool]] = []  # of frequency and decay
        self.squares: list[float] = []  # errors of frequencies over their bounds, squared

    def add(self, drawn: Draw, found: Found | None) -> None:
        """One record; no lines where the program failed or took too long."""
        self.draws += 1
        self.failed += found is None
        found = np.zeros((5, 0)) if found is None else found
        if not len(drawn.gains):
            self.false += found.shape[1] > 0
            return
        pairs, needed = pairs_of(drawn, found), drawn.needed()
        self.needed += needed.sum()
        self.missed += (needed & (pairs < 0)).sum()
        self.false += found.shape[1] > (pairs >= 0).sum()
        for line in np.flatnonzero(needed & (pairs >= 0)):
            frequency, half, decay, decay_half, drifts = found[:, pairs[line]]
            ends = (drawn.frequencies[line], drawn.ends[line]) if drifts else (drawn.steady[0, line],) * 2
            true_decay = drawn.decays[line] if drifts else drawn.steady[1, line]
            self.inside.append((max(abs(frequency - end) for end in ends) <= half, abs(decay - true_decay) <= decay_half))
            self.squares.append(((frequency - drawn.steady[0, line]) / drawn.bounds[0, line]) ** 2)

    def __str__(self) -> str:
        words = f"missed {self.missed} of {self.needed}, false lines in {self.false} of {self.draws}, failed {self.failed}"
        if self.inside:
            frequency, decay = 100 * np.mean(self.inside, axis=0)
            words += f", inside {frequency:.0f} and {decay:.0f} %, median square error {np.median(self.squares) / 0.455:.2f}"
        return words


def main(program: str, draws: str, *names: str) -> int:
    """Print a line for each class."""
    path = Path(program).resolve()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for name in names or CLASSES:
        tally = Tally()
        for number in range(int(draws)):
            drawn = CLASSES[name].draw(number)
            with tempfile.TemporaryDirectory() as directory:
                try:
                    found = by_program(path, drawn, Path(directory))
                except (subprocess.SubprocessError, OSError, ValueError):
                    found = None
            tally.add(drawn, found)
        print(f"{name:10s} {tally}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
