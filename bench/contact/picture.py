"""The work–precision diagram, from the measured rows alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from beamwave_postproc.style import COLOURS
from peers.picture import diagram, save_figure

LOOKS = {  # colour, dash, marker
    "beamwave": (COLOURS[2], "-", "o"),
    "beamwave, whole process": (COLOURS[2], (0, (4, 2)), "o"),
    "OpenSees, Newmark": (COLOURS[4], "-", "P"),
    "Exudyn, Newmark": (COLOURS[3], "-", "^"),
    "Exudyn, DOPRI5": (COLOURS[3], (0, (4, 2)), "v"),
}
LABELS = {  # words, at which of the curve's sizes, how far from it in points, and how they are aligned
    "beamwave": ("beamwave", 0, (-8, 0), "right"),
    "beamwave, whole process": ("beamwave, whole\nprocess with files", -1, (9, 0), "left"),
    "OpenSees, Newmark": ("OpenSees, Newmark", -1, (8, 0), "left"),
    "Exudyn, Newmark": ("Exudyn, Newmark", 0, (-8, 0), "right"),
    "Exudyn, DOPRI5": ("Exudyn, DOPRI5", -1, (8, 0), "left"),
}


def save(measured: dict[str, Any], path: Path) -> None:
    """Write the PNG."""
    words = f"A mass of 1 kg strikes the tip through a stop of 1e6 N/m: midpoint and tip at {measured['problem']['samples']} times"
    save_figure(diagram(measured["rows"], list(LOOKS), LOOKS, LABELS, words), path)
