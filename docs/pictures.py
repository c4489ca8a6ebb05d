"""Makes the pictures of beams in docs/pictures/ anew: `.venv/bin/python docs/pictures.py`, after `./run.sh`.

Those of the benches are theirs: bench/README.md.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import xarray as xr
from beamwave_postproc import (
    bending_moment,
    campbell,
    compare,
    displacement,
    motion,
    ranking,
    record_response,
    run,
    save_film,
    space_time,
    spectrogram,
    sweep_map,
    wavenumber_spectrum,
)
from matplotlib.figure import Figure

PROJECT = Path(__file__).resolve().parents[1]
PICTURES = PROJECT / "docs" / "pictures"
DPI, DPI_OF_IMAGES = 150, 100
BEAM = {"length": 1.0, "diameter": 0.037, "density": 7870.0, "youngs_modulus": 2.0e11}


def main() -> None:
    """Run the scenes and draw."""
    with tempfile.TemporaryDirectory() as scratch:
        save("fig6", displacement(result("paper/fig6", scratch), 0.5))
        save("critical_speed", sweep_map(result("critical_speed", scratch)))
        save("campbell", campbell(tension()))
        save("ranking", ranking(result("design", scratch)))
        save("tutorial_arm", bending_moment(result("tutorial/arm", scratch)))
        save("tutorial_blade", campbell(result("tutorial/blade", scratch)))
        save("tutorial_clamp", record_response(result("tutorial/clamp", scratch)))
        waves = result("waves", scratch)
        save("space_time", space_time(waves), DPI_OF_IMAGES)
        save("wavenumber_spectrum", wavenumber_spectrum(waves), DPI_OF_IMAGES)
        save("spectrogram", spectrogram(waves), DPI_OF_IMAGES)
        both = compare(result("effects/rotation", scratch), result("effects/stiffening", scratch))
        save("comparison", both["displacement"])
        save_film(motion(result("moving_beam", scratch)), PICTURES / "moving_beam.gif", overwrite=True)


def result(scene: str, scratch: str) -> xr.Dataset:
    """The result of a scene of input/."""
    return run(PROJECT / f"input/{scene}.nml", scratch)


def tension() -> xr.Dataset:
    """A beam with its mass from rest to 12 000 rpm, in the plane of rotation, with the tension that the rotation makes."""
    return run(
        {
            "scene": {"title": "Frequencies of a rotating beam with tension"},
            "beam": BEAM,
            "rotation": {"plane": "in"},
            "stiffening": {"hub_radius": 0.2},
            "impact": {"mass_ratio": 0.2},
            "capture": {},
            "modes": {"before": 4, "after": 4},
            "sweep": {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 1250.0, "count": 26},
        }
    )


def save(name: str, fig: Figure, dpi: int = DPI) -> None:
    """Write a picture as PNG."""
    fig.savefig(PICTURES / f"{name}.png", dpi=dpi, metadata={"Software": None})


if __name__ == "__main__":
    main()
