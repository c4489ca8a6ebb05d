"""The figures of the paper: `python -m beamwave_postproc.paper DIR`.

Reads DIR/fig2.nc … fig7.nc, the results of the scenes in input/paper/, and writes DIR/fig2.png … fig7.png.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Callable

import xarray as xr
from matplotlib.figure import Figure

from .draw.history import displacement
from .draw.jump import velocity_jump
from .draw.waves import dispersion, group_velocity, phase_velocity
from .files import EXIT_DONE, EXIT_FILE, draw_file

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
    words = argparse.ArgumentParser(prog="python -m beamwave_postproc.paper", description=__doc__.splitlines()[0])
    words.add_argument("directory", metavar="DIR", type=Path, help="holds fig2.nc … fig7.nc; the pictures go there")
    directory = words.parse_args(argv).directory
    done = [_draw(directory / f"{name}.nc", figure) for name, figure in FIGURES.items()]
    return EXIT_DONE if all(done) else EXIT_FILE


def _draw(source: Path, figure: Callable[[xr.Dataset], Figure]) -> bool:
    """Draw one figure beside its result; whether that went well."""
    return draw_file(source, lambda ds: {source.with_suffix(".png"): figure(ds)})


if __name__ == "__main__":
    sys.exit(main())
