"""Every kind of picture by name, in the order in which they are drawn."""

from __future__ import annotations

from typing import Callable

import xarray as xr
from matplotlib.figure import Figure

from . import effect_table, history, jump, measured, prices, spectrum, sweep_map, waves
from .result import NothingToDraw

KINDS: dict[str, Callable[[xr.Dataset], Figure]] = {
    "dispersion": waves.dispersion,
    "phase_velocity": waves.phase_velocity,
    "group_velocity": waves.group_velocity,
    "velocity_jump": jump.velocity_jump,
    "displacement": history.displacement,
    "velocity": history.velocity,
    "spectrum": spectrum.spectrum,
    **{f"measured_{name}": measured.measured_picture(name) for name in measured.QUANTITIES},
    "sweep_map": sweep_map.sweep_map,
    "changes": effect_table.changes,
    "work_precision": prices.work_precision,
}


def pictures(ds: xr.Dataset) -> dict[str, Figure]:
    """All pictures that `ds` holds the numbers for, by kind; raises `NothingToDraw` where it holds none."""
    drawn = {}
    for kind, draw in KINDS.items():
        try:
            drawn[kind] = draw(ds)
        except NothingToDraw:
            continue
    if not drawn:
        raise NothingToDraw("nothing in it to draw")
    return drawn
