"""Every kind of picture by name, in the order in which they are drawn."""

from __future__ import annotations

from functools import partial
from typing import Callable

import xarray as xr
from matplotlib.figure import Figure

from .draw import (
    campbell,
    contact_force,
    effect_table,
    frequency_response,
    history,
    identified,
    impulses,
    jump,
    lines,
    measured,
    mode_shapes,
    outcome_map,
    outcomes,
    prices,
    ranking,
    record_dispersion,
    record_envelopes,
    record_fit,
    record_model,
    record_repeats,
    record_response,
    record_shapes,
    record_spectrum,
    record_windows,
    space_time,
    spectrogram,
    spectrum,
    sweep_map,
    transmission,
    wavenumber,
    waves,
)
from .result import NothingToDraw

KINDS: dict[str, Callable[[xr.Dataset], Figure]] = {
    "dispersion": waves.dispersion,
    "phase_velocity": waves.phase_velocity,
    "group_velocity": waves.group_velocity,
    "campbell": campbell.campbell,
    "sweep_map": sweep_map.sweep_map,
    "ranking": ranking.ranking,
    "outcomes": outcomes.outcomes,
    "outcome_map": outcome_map.outcome_map,
    "mode_shapes": mode_shapes.mode_shapes,
    "velocity_jump": jump.velocity_jump,
    "impulses": impulses.impulses,
    "contact_force": contact_force.contact_force,
    "displacement": history.displacement,
    "velocity": history.velocity,
    "acceleration": history.acceleration,
    "bending_moment": history.bending_moment,
    "shear_force": history.shear_force,
    "hub_angle": history.hub_angle,
    "space_time": space_time.space_time,
    "space_time_moment": space_time.space_time_moment,
    "wavenumber_spectrum": wavenumber.wavenumber_spectrum,
    "spectrogram": spectrogram.spectrogram,
    "spectrum": spectrum.spectrum,
    "frequency_response": frequency_response.frequency_response,
    "transmission": transmission.transmission,
    **{f"measured_{name}": partial(measured.measured, name=name) for name in measured.QUANTITIES},
    "record_fit": record_fit.record_fit,
    "record_spectrum": record_spectrum.record_spectrum,
    "record_envelopes": record_envelopes.record_envelopes,
    "record_response": record_response.record_response,
    "lines": lines.lines,
    "record_windows": record_windows.record_windows,
    "record_repeats": record_repeats.record_repeats,
    "record_shapes": record_shapes.record_shapes,
    "record_dispersion": record_dispersion.record_dispersion,
    "record_model": record_model.record_model,
    "identified": identified.identified,
    "changes": effect_table.changes,
    "work_precision": prices.work_precision,
}


def pictures(ds: xr.Dataset, kinds: dict[str, Callable[[xr.Dataset], Figure]] | None = None) -> dict[str, Figure]:
    """All pictures, or those of `kinds`, that `ds` holds the numbers for; raises `NothingToDraw` where it holds none."""
    drawn = {}
    for kind, draw in (KINDS if kinds is None else kinds).items():
        try:
            drawn[kind] = draw(ds)
        except NothingToDraw:
            continue
    if not drawn:
        raise NothingToDraw("nothing in it to draw")
    return drawn
