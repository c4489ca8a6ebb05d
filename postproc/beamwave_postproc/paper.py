"""The figures of the paper: `python -m beamwave_postproc.paper DIR`.

Reads DIR/fig2.nc … fig7.nc, the results of the scenes in input/paper/, and writes DIR/fig2.png … fig7.png.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Callable

import xarray as xr
from matplotlib.figure import Figure

from .draw.history import displacement
from .draw.jump import velocity_jump
from .draw.waves import dispersion, group_velocity, phase_velocity
from .files import draw_one
from .terminal import Words
from .tool import Tool, command

MIDPOINT = 0.5

FIGURES: dict[str, Callable[[xr.Dataset], Figure]] = {
    "fig2": dispersion,
    "fig3": velocity_jump,
    "fig4": phase_velocity,
    "fig5": group_velocity,
    "fig6": partial(displacement, points=MIDPOINT),
    "fig7": partial(displacement, points=MIDPOINT),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Draw the six figures; 0, or 3 if any of them could not be drawn."""
    words = Words(prog="python -m beamwave_postproc.paper", description=__doc__.splitlines()[0])
    words.add_argument("directory", metavar="DIR", type=Path, help="holds fig2.nc … fig7.nc; the pictures go there")
    words.add_argument("--overwrite", action="store_true", help="replace files that are there and are not its own")
    return command(words, _run, argv)


def _run(given: Namespace, tool: Tool) -> int:
    """Draw each figure beside its result; the highest exit status of any."""
    where = given.directory
    return max(draw_one(tool, where / f"{name}.nc", where / f"{name}.png", figure) for name, figure in FIGURES.items())


if __name__ == "__main__":
    sys.exit(main())
