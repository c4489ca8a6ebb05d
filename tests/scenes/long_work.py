"""Scenes of every kind that takes long: each would take a minute and more, and some steps of it seconds."""

import random

from workplace import PAPER_BEAM, captured_beam

REBOUND = {key: value for key, value in captured_beam().items() if key != "capture"}
TENSION = {"rotation": {"angular_velocity": 50.0}, "stiffening": {"hub_radius": 0.0}}
RECORD = {"duration": 1.0, "samples": 4096}


def of_pieces(number, **groups):
    """A beam of so many pieces that each has a diameter of its own."""
    dice = random.Random(number)
    beam = {
        "length": [1.0 / number] * number,
        "diameter": [0.02 + 0.02 * dice.random() for _ in range(number)],
        "density": 7870.0,
        "youngs_modulus": 2e11,
    }
    return {"beam": beam, "impact": {"mass_ratio": 0.2}, "capture": {}, "response": RECORD, **groups}


def with_tolerance(tolerance, **groups):
    return {**captured_beam(response=RECORD, **groups), "modes": {"tolerance": tolerance}}


FEW = {
    "pieces": of_pieces(1000),
    "pieces with tension": of_pieces(400, modes={"before": 20, "after": 20}, **TENSION),
    "modes of pieces": of_pieces(50, modes={"before": 2, "after": 50_000}),
    "a release with shear": with_tolerance(1e-7, shear={}, release={"time": 0.5}),
    "a modal model": captured_beam(modes={"before": 4000, "after": 4000, "modal_model": True}, response={"duration": 1.0, "samples": 64}),
    "many sweeps with a tolerance": of_pieces(20, modes={"tolerance": 1e-5}, response={"duration": 1.0, "samples": 64}),
}
ALL = {
    **FEW,
    "pieces with shear": of_pieces(100, shear={}),
    "pieces that turn out of plane": of_pieces(100, shear={}, rotation={"angular_velocity": 50.0, "plane": "out"}),
    "a release of pieces": of_pieces(20, release={"time": 0.5}),
    "a tolerance of pieces with tension": of_pieces(20, **TENSION),
    "many modes with tension": captured_beam(stiffening={}, shear={}, modes={"before": 500, "after": 500}, response=RECORD),
    "a tolerance out of reach": with_tolerance(1e-9, stiffening={}, shear={}),
    "many modes": captured_beam(modes={"before": 5_000_000, "after": 5_000_000}),
    "many samples": captured_beam(modes={"before": 400, "after": 400}, response={"duration": 1.0, "samples": 10_000_000}),
    "a spectrum": captured_beam(
        modes={"before": 400, "after": 400}, response={"duration": 1.0, "samples": 2_000_000}, spectrum={}
    ),
    "many contacts": {
        **REBOUND,
        "modes": {"before": 3000},
        "impact": {"mass_ratio": 0.2, "restitution": 0.3},
        "recontact": {"max_contacts": 100_000},
        "response": RECORD,
    },
    "contacts of pieces": {
        **of_pieces(50, modes={"before": 500}, response=RECORD),
        "impact": {"mass_ratio": 0.2, "restitution": 0.3},
        "recontact": {"max_contacts": 1000},
    },
    "many bodies": {**of_pieces(400), "beam": PAPER_BEAM},
}
del ALL["contacts of pieces"]["capture"]
SWEPT = [
    {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": 30},
    {"parameter": "impact%mass_ratio", "first": 0.1, "last": 1.0, "count": 30},
]
SWEEPS = {name: SWEPT for name in ("pieces with tension", "many modes with tension", "a tolerance of pieces with tension")}
DIAMETERS = [{"parameter": f"beam%diameter({i})", "values": [0.02, 0.04]} for i in range(1, 17)]
SWEEPS["many sweeps with a tolerance"] = DIAMETERS
