"""Places along the beam that a picture marks: attached bodies, and where the mass strikes."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from ..style import ABOVE_GRID

TIP = 1.0
BODY: dict[str, Any] = {"color": "0.35", "linewidth": 0.9, "linestyle": (0, (6, 2, 1.5, 2))}
STRUCK: dict[str, Any] = {"color": "0.35", "linewidth": 0.9, "linestyle": (0, (1, 2))}


def body_places(ds: xr.Dataset) -> np.ndarray:
    """Places ξ of the attached bodies, each once, ascending; of a sweep over them none."""
    if "body_position" not in ds or "case" in ds["body_position"].dims:
        return np.empty(0)
    places = np.unique(ds["body_position"].values)
    return places[np.isfinite(places)]


def bodies_there(ds: xr.Dataset, times: np.ndarray) -> np.ndarray:
    """Whether something is attached at each of `body_places` at times (s) of a single case, (times, places)."""
    places = body_places(ds)
    if places.size == 0:
        return np.ones((times.size, 0), dtype=bool)
    position = ds["body_position"].values
    begin = ds["body_from"].fillna(-np.inf).values if "body_from" in ds else np.full(position.size, -np.inf)
    end = ds["body_until"].fillna(np.inf).values if "body_until" in ds else np.full(position.size, np.inf)
    here = (times[:, np.newaxis] >= begin) & (times[:, np.newaxis] < end)
    return np.stack([here[:, position == place].any(axis=1) for place in places], axis=1)


def struck_inside(ds: xr.Dataset) -> float | None:
    """Where the mass strikes, ξ; None at the tip, without an impact, and where cases differ in it."""
    if "impact_position" not in ds:
        return None
    places = np.unique(ds["impact_position"].values)
    return float(places[0]) if places.size == 1 and places[0] < TIP else None


def bodies_at_first(ds: xr.Dataset) -> np.ndarray:
    """Those of `body_places` at which something is attached at t = 0, the time of the modes; of a sweep over it all."""
    if any("case" in ds[name].dims for name in ("body_from", "body_until") if name in ds):
        return body_places(ds)
    return body_places(ds)[bodies_there(ds, np.zeros(1))[0]]


def mark_places(axes: Axes, ds: xr.Dataset, along: Literal["x", "y"], *, first: bool = False) -> None:
    """Lines across the axes at the bodies and at the struck place, ξ being on the axis `along`; named in the legend.

    With `first` the bodies are those at t = 0.
    """
    draw = axes.axvline if along == "x" else axes.axhline
    bodies, struck = bodies_at_first(ds) if first else body_places(ds), struck_inside(ds)
    for place in bodies:
        draw(place, label="body" if bodies.size == 1 else "bodies", zorder=ABOVE_GRID if along == "x" else 2.0, **BODY)
    if struck is not None:
        draw(struck, label="struck place", zorder=ABOVE_GRID if along == "x" else 2.0, **STRUCK)


def turn_of_line(case: xr.Dataset, point: int) -> np.ndarray:
    """By how much the line of a hub that is free, from which displacements are measured, has moved a point (m, over the samples)."""
    if "hub_angle" not in case:
        return np.zeros(case.sizes["time"])
    arm = float(case["hub_radius"]) + float(case["point_position"][point]) * float(np.sum(case["beam_length"].values))
    return arm * case["hub_angle"].values
