"""Tension in beams by pieces: scenes that must agree with those of a uniform beam under tension, and of pieces without it."""

import re

import numpy as np
import pytest
from workplace import group_text

LENGTH = 0.9
SECTION = {"density": 2700.0, "youngs_modulus": 7e10, "diameter": 0.02}
ROTATION = {"angular_velocity": 60.0}
STRUCK = {
    "impact": {"mass_ratio": 0.3, "approach_velocity": 0.7, "restitution": 0.25},
    "capture": {"rotary_inertia": 2e-4},
    "release": {"time": 0.11},
    "modes": {"before": 24, "after": 24},
    "response": {"duration": 0.3, "samples": 400, "points": [0.3, 0.55, 1.0], "velocity": True, "bending_moment": True},
}
THIN = {
    "beam": {"length": LENGTH, **SECTION, "diameter": 1e-4},
    "rotation": {"angular_velocity": 400.0},
    "capture": {"rotary_inertia": 1e-8},
}
STEPPED = {
    "beam": {"length": [0.5, 0.4], "density": 2700.0, "youngs_modulus": 7e10, "diameter": [0.02, 0.016]},
    "support": {"rotational_stiffness": 4e4},
    "body": {"position": 0.7, "mass": 0.05, "rotary_inertia": 1e-5},
}


def text_of(groups):
    return "".join(group_text(name, values) for name, values in groups.items())


@pytest.fixture(scope="module")
def ran(shared):
    here = shared("piece_tension")
    uniform = {"beam": {"length": LENGTH, **SECTION}, "rotation": ROTATION, "stiffening": {"hub_radius": 0.15}, **STRUCK}
    stepped = {**STEPPED, **STRUCK, "impact": {**STRUCK["impact"], "position": 0.85}}
    scenes = {
        "uniform": uniform,
        "cut": {**uniform, "beam": {"length": [0.3, 0.6], **SECTION}},
        "cut_with_shear": {**uniform, "beam": {"length": [0.3, 0.6], **SECTION}, "shear": {}},
        "uniform_with_shear": {**uniform, "shear": {}},
        "uniform_thin": {**uniform, **THIN},
        "cut_thin": {**uniform, **THIN, "beam": {**THIN["beam"], "length": [0.3, 0.6]}},
        "still": stepped,
        "at_rest": {**stepped, "rotation": {"angular_velocity": 0.0}, "stiffening": {"hub_radius": 0.15}},
        "nearly_still": {**stepped, "rotation": {"angular_velocity": 1e-5}, "stiffening": {"hub_radius": 0.15}},
    }
    for name, groups in scenes.items():
        here.write(f"all/{name}.nml", text_of(groups))
    here.beamwave("run", "all", status=0)
    return here


def assert_alike(one, other, tolerance):
    for name in ("displacement", "velocity", "bending_moment"):
        np.testing.assert_allclose(one[name], other[name], rtol=0, atol=tolerance * np.abs(one[name]).max(), err_msg=name)
    for name in ("energy_before", "energy_after", "momentum_before", "momentum_after"):
        np.testing.assert_allclose(one[name], other[name], rtol=tolerance, err_msg=name)


def test_phases_of_a_long_record_under_tension_drift_within_the_errors(ran):
    # two ways to the same beam, whose frequencies are rounded differently: after 1e11 s that is what histories differ by
    long = {**STRUCK, "response": {"duration": 1e11, "samples": 100, "points": [0.3, 0.55, 1.0]}}
    del long["release"]
    for name, length in (("one", LENGTH), ("two", [0.3, 0.6])):
        groups = {"beam": {"length": length, **SECTION}, "rotation": ROTATION, "stiffening": {"hub_radius": 0.15}, **long}
        ran.write(f"long/{name}.nml", text_of({**groups, "modes": {"tolerance": 1e-4}}))
        refused = ran.beamwave("run", f"long/{name}.nml")
        named = re.search(r"rounding of their frequencies under tension; accepted: (\S+) or more", refused.stderr)
        assert refused.returncode == 2 and named, refused.stderr
        ran.write(f"long/{name}.nml", text_of({**groups, "modes": {"tolerance": float(named[1])}}))
        ran.beamwave("run", f"long/{name}.nml", status=0)
    one, two = ran.result("one"), ran.result("two")
    difference = np.abs(one["displacement"] - two["displacement"]).max(axis=-1)
    errors = np.array(one["displacement_error"]) + np.array(two["displacement_error"])
    assert np.all(difference < errors)
    assert np.all(difference > 0.01 * errors)


@pytest.mark.parametrize("kind", ["", "_with_shear", "_thin"])
def test_a_cut_changes_nothing_of_a_uniform_beam_under_tension(ran, kind):
    # shapes are good to rounding over the gap between neighbouring values; thin layers are pieces of their own where there is a cut
    assert_alike(ran.result("uniform" + kind), ran.result("cut" + kind), 1e-9)


def test_tension_goes_to_nothing_with_the_square_of_the_speed(ran):
    # (omega l^2/h)^2 is 1e-13 of the first frequency's square; both ways of finding modes have their own rounding
    assert_alike(ran.result("still"), ran.result("nearly_still"), 1e-9)
    assert_alike(ran.result("still"), ran.result("at_rest"), 1e-9)
