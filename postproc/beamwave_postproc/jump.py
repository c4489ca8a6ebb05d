"""The jump in velocity along the beam at the impact (Fig. 3)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from .curves import curves_of, heading
from .labels import axis_label
from .legend import add_legend
from .result import require, require_numbers
from .style import markers_to_end, new_figure, styled

SHARED_INPUTS = ("modes_before", "impact_mass_ratio", "impact_mass", "impact_restitution")


@styled
def velocity_jump(ds: xr.Dataset) -> Figure:
    """Draw `velocity_jump` (case, profile) in m/s against the position ξ along the beam."""
    require(ds, "velocity_jump", "profile_position")
    fig = new_figure()
    axes = fig.axes[0]
    position = ds["profile_position"].values
    curves = curves_of(ds)
    require_numbers(np.array([c.data["velocity_jump"].values for c in curves]), "velocity_jump")
    for curve in curves:
        axes.plot(
            position,
            curve.data["velocity_jump"].values,
            label=curve.label or None,
            markevery=markers_to_end(curve.index, position.size),
            clip_on=False,  # the markers at the tip are whole
            **curve.style,
        )
    axes.set_xlim(position.min(), position.max())
    axes.set_xlabel(axis_label(ds["profile_position"]))
    axes.set_ylabel(axis_label(ds["velocity_jump"]))
    add_legend(axes, heading(ds, *SHARED_INPUTS))
    return fig
