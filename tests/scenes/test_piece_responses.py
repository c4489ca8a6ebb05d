"""Beams by pieces, with bodies, springs, an elastic root, shear, rotation and blows inboard: histories of random scenes against
modes of 50 digits and overlaps by quadrature, with as many modes as the scenes count."""

import sys

import numpy as np
import pytest
from conftest import PROJECT
from workplace import PAPER_BEAM, captured_beam, group_text

sys.path.insert(0, str(PROJECT / "tests/reference"))
from piece_scenes import POINTS, SAMPLES, SCENES, scene  # noqa: E402

TOLERANCE = 1e-11  # of the peak: capture and release are sums of products of some 30 roundings each, at most 1e-13 of their terms


@pytest.fixture(scope="module")
def references():
    """Displacements, (scenes, points, samples)."""
    table = np.loadtxt(PROJECT / "tests/reference/piece_responses.txt", comments=("#", "scene"))
    values = np.zeros((SCENES, len(POINTS), SAMPLES))
    values[tuple(table[:, :3].astype(int).T)] = table[:, 3]
    return values


@pytest.fixture(scope="module")
def ran(shared):
    """All scenes, run in one call."""
    here = shared("piece_responses")
    for number in range(SCENES):
        here.write(f"all/s{number}.nml", "".join(group_text(name, values) for name, values in scene(number)))
    here.beamwave("run", "all", status=0)
    return here


@pytest.mark.parametrize("number", range(SCENES))
def test_histories_are_those_of_fifty_digits(ran, references, number):
    found = ran.result(f"s{number}")["displacement"]
    peak = np.abs(references[number]).max()
    np.testing.assert_allclose(found, references[number], rtol=0, atol=TOLERANCE * peak)


@pytest.mark.parametrize("number", range(SCENES))
def test_events_keep_their_balance(ran, number):
    result = ran.result(f"s{number}")
    assert result.attributes["method"] == "pieces"
    restitution = dict(scene(number))["impact"]["restitution"]
    # what a capture adds with restitution is told; all else is kept
    before, after = np.atleast_1d(result["momentum_before"]), np.atleast_1d(result["momentum_after"])
    for i in range(len(before)):
        if i != 1 or restitution == 0.0:
            np.testing.assert_allclose(after[i], before[i], rtol=1e-11, err_msg=str(i))
        if i != 1 or restitution == 0.0:
            assert result["energy_after"][i] <= result["energy_before"][i] * (1 + 1e-12)


@pytest.mark.parametrize("position", [0.37, 0.7, 1.0])
@pytest.mark.parametrize("groups", [{}, {"shear": {}}, {"capture": {"rotary_inertia": 1e-3}}], ids=["plain", "shear", "inertia"])
def test_a_tolerance_and_many_modes_agree_after_a_release_anywhere(here, position, groups):
    """Two ways to infinitely many modes: what the modes that are not there add to the velocity of the struck place, or their sum."""
    scene = captured_beam(body={"position": 0.3, "mass_ratio": 0.2}, impact={"position": position}, release={"time": 0.02}, **groups)
    scene |= {"response": {"duration": 0.05, "samples": 100, "points": [0.3, 0.5, 1.0]}}
    here.scene("a", {**scene, "modes": {"tolerance": 1e-3}})
    here.scene("b", {**scene, "modes": {"before": 400, "after": 400}})
    assert here.beamwave("run", "a.nml", "b.nml").returncode == 0
    one, other = here.result("a"), here.result("b")
    difference = np.abs(one["displacement"] - other["displacement"]).max(axis=1)
    assert (difference <= one["displacement_error"] + other["displacement_error"]).all()
    assert difference.max() <= 2e-3 * np.abs(other["displacement"]).max()  # the tolerance, and what 400 modes lack


@pytest.mark.parametrize("position", [0.5, 1.0])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("groups", [{}, {"shear": {}}], ids=["plain", "shear"])
def test_a_blow_on_a_body_is_that_of_two_masses(here, position, restitution, groups):
    """With infinitely many modes the beam does not take part in the blow: two masses share the momentum."""
    light, heavy = 0.2, 0.3
    scene = captured_beam(body={"position": position, "mass_ratio": heavy}, **groups)
    scene["impact"] = {"mass_ratio": light, "position": position, "restitution": restitution, "profile_points": 11}
    here.scene("a", {**scene, "modes": {"tolerance": 1e-2}, "response": {"duration": 0.01, "samples": 20, "points": [0.25]}})
    assert here.beamwave("run", "a.nml").returncode == 0
    result = here.result("a")
    beam = PAPER_BEAM["density"] * np.pi / 4 * PAPER_BEAM["diameter"] ** 2 * PAPER_BEAM["length"]
    assert result["impulse"] == pytest.approx((1 + restitution) * beam * light * heavy / (light + heavy), rel=1e-13)
    place = (1 + restitution) * light / (light + heavy)
    assert result["tip_velocity"] == pytest.approx(place, rel=1e-14)
    assert result["mass_velocity"] == pytest.approx(place - restitution, abs=1e-14)
    np.testing.assert_allclose(result["velocity_jump"], np.where(np.arange(11) == round(10 * position), place, 0.0), rtol=1e-14)
    impact, capture = 0, 1
    kept = (light + heavy * restitution**2) / (light + heavy)  # of the energy, by two masses with restitution
    assert result["energy_after"][impact] == pytest.approx(kept * result["energy_before"][impact], rel=1e-13)
    assert result["energy_after"][capture] == pytest.approx(0.5 * beam * (light + heavy) * place**2, rel=1e-13)
    assert result["momentum_after"][impact] == pytest.approx(result["momentum_before"][impact], rel=1e-14)
    assert result["momentum_after"][capture] == pytest.approx((1 + restitution) * beam * light, rel=1e-13)
