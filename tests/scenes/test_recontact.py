"""A mass that bounces off, and one that comes back: contacts in the result, the histories through them, and what is said."""

import re

import numpy as np
import pytest
import results
from conftest import PROJECT
from workplace import captured_beam

RESPONSE = {"duration": 0.02, "samples": 4000, "points": [0.5, 1.0], "velocity": True}


BEAM_MASS = 7870.0 * np.pi / 4 * 0.037**2  # kg


def struck_beam(e, **groups):
    impact = {"mass_ratio": 0.2, "restitution": e}
    scene = captured_beam(capture=None, modes=None, impact=impact, response=RESPONSE, **groups)
    return {**scene, "modes": {"before": 5}}


def contacts(result):
    """Kinds, starts and ends of the contacts after the impact."""
    there = result["event_kind"] == 4
    return result["event_time"][there], result["event_end"][there]


@pytest.mark.parametrize("scene", ["rebound", "recontact"])
def test_the_scenes_show_what_their_heads_say(here, scene):
    here.beamwave("run", PROJECT / f"input/effects/{scene}.nml", status=0)
    result = here.result(scene)
    if scene == "rebound":
        assert f"{2e3 * np.pi / result['angular_frequency'][0]:.1f}" == "40.2"
        assert [f"{result[name]:.1f}" for name in ["mass_velocity", "tip_velocity"]] == ["0.7", "1.2"]
        np.testing.assert_array_equal(result["event_kind"], [1])
        return
    start, end = contacts(result)
    assert (start < 0.302e-3).sum() == 7
    assert f"{1e3 * end[6]:.3f}" == "1.106"
    assert (np.diff(start[:7])[1:] < np.diff(start[:7])[:-1]).all()


@pytest.mark.parametrize("e", [0.0, 0.3, 0.9, 1.0])
@pytest.mark.parametrize("plane", ["in", "out"])
def test_energy_never_grows_and_histories_are_continuous(here, e, plane):
    result = here.simulate("a", struck_beam(e, recontact={}, rotation={"angular_velocity": 50.0, "plane": plane}))
    count = (result["event_kind"] > 0).sum()
    before, after = result["energy_before"][:count], result["energy_after"][:count]
    slack = 1e-12 * before[0]
    assert (after <= before + slack).all()
    np.testing.assert_allclose(before[1:], after[:-1], atol=slack)  # nothing is lost in flight
    if e == 1.0:
        np.testing.assert_allclose(after, before[0], atol=slack)
    assert results.is_fill(result["energy_after"][count:]).all()
    step = RESPONSE["duration"] / RESPONSE["samples"]
    fastest = np.abs(result["velocity"]).max() * 1.5
    assert np.abs(np.diff(result["displacement"], axis=1)).max() < fastest * step


@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("speed", [150.0, 180.0])
def test_a_contact_that_grows_keeps_its_energy(here, e, speed):
    """Beam and mass grow together by a factor of 1e9 and more, and what is left of their energy is that of the contact."""
    scene = struck_beam(e, recontact={"max_contacts": 1000}, rotation={"angular_velocity": speed})
    result = here.simulate("a", {**scene, "response": {"duration": 0.3, "samples": 100}})
    start, end = contacts(result)
    last = len(start)
    assert end[-1] == 0.3 and end[-1] - start[-1] > 0.2
    assert np.abs(result["displacement"]).max() > 1e5
    # the blow that ends the approach takes 0.1 of it at most, the contact itself nothing
    assert 0.9 * result["energy_before"][last] < result["energy_after"][last] <= result["energy_before"][last]


@pytest.mark.parametrize("effect", [{}, {"damping": {"ratio": 0.3}}, {"damping": {"ratio": 100.0}}, {"stiffening": {}}])
@pytest.mark.parametrize("mass_ratio, e, count", [(0.2, 0.0, 5), (0.2, 0.2, 5), (0.2, 0.9, 20), (0.005, 0.9, 5), (0.05, 1.0, 12)])
def test_a_mass_that_is_not_followed_is_said_to_be_back_when_it_would_strike(here, mass_ratio, e, count, effect):
    """To a sample: a contact may begin between two of them, and one that ends before the next is not seen."""
    groups = {"impact": {"mass_ratio": mass_ratio, "restitution": e}, "rotation": {"angular_velocity": 50.0}}
    scene = {**captured_beam(capture=None, modes=None, response=RESPONSE, **groups, **effect), "modes": {"before": count}}
    here.scene("without", scene)
    here.scene("with", {**scene, "recontact": {"max_contacts": 1}})
    said = re.search(r"remark: recontact: the rebounded mass would return at about t = (\S+) s", here.run("without").attributes["notes"])
    here.beamwave("run", "with.nml")
    start, end = contacts(here.result("with"))
    assert (said is not None) == (len(start) > 0)
    if said:
        step = RESPONSE["duration"] / RESPONSE["samples"]
        assert start[0] * 0.9995 <= float(said[1]) <= (start[0] + 2 * step) * 1.0005  # of four digits


def test_until_the_first_contact_the_mass_might_not_be_there(here):
    alone, again = here.simulate("a", struck_beam(0.9)), here.simulate("b", struck_beam(0.9, recontact={}))
    first = again["event_time"][1]
    early = again["time"] < first
    assert 10 < early.sum() < 4000
    np.testing.assert_allclose(again["displacement"][:, early], alone["displacement"][:, early], atol=1e-16)
    assert np.abs(again["displacement"] - alone["displacement"]).max() > 1e-5


def test_in_a_lasting_contact_the_tip_obeys_the_mass(here):
    """Between start and end of the contact at e = 0 momentum of mode 1 obeys its own equation with the mass on the tip."""
    result = here.simulate("a", struck_beam(0.0, recontact={}))
    start, end = contacts(result)
    assert start[0] == 0.0
    assert end[0] > 1e-3
    # one blow without rebound and the contact that follows keep the energy that the blow left
    np.testing.assert_allclose(result["energy_after"][1], result["energy_after"][0], rtol=1e-12)
    np.testing.assert_allclose(result["velocity"][1, 0], result["tip_velocity"], rtol=1e-12)


@pytest.mark.parametrize("omega", [0.0, 50.0])
@pytest.mark.parametrize("mass_ratio", [1e15, 1e30, 1e200, 1e300])
def test_a_mass_beyond_all_weights_moves_on_as_if_nothing_were_there(here, mass_ratio, omega):
    """V sinh ωt/ω, and so does the tip that it presses against; with 1/γ what the beam does to it goes to zero."""
    scene = {**struck_beam(0.0, recontact={}), "response": {**RESPONSE, "duration": 0.05}}
    rotation = {"rotation": {"angular_velocity": omega}} if omega else {}
    scene = {name: group for name, group in scene.items() if name != "rotation"} | rotation
    result = here.simulate("a", {**scene, "impact": {"mass_ratio": mass_ratio}})
    start, end = contacts(result)
    assert end[-1] == 0.05
    held = np.any([(result["time"] >= a) & (result["time"] < b) for a, b in zip(start, end)], axis=0)
    assert held.sum() > 2000
    expected = np.sinh(omega * result["time"][held]) / omega if omega else result["time"][held]
    np.testing.assert_allclose(result["displacement"][1, held], expected, rtol=1e-12)
    for name in ["displacement", "velocity", "energy_before", "energy_after", "event_impulse", "event_time_error"]:
        assert np.isfinite(result[name]).all()
    energies = result["energy_after"][result["event_kind"] > 0]
    np.testing.assert_allclose(energies, mass_ratio * BEAM_MASS / 2, rtol=1e-13)  # it keeps what it brought
    assert (result["displacement_error"] < 1e-12 * np.abs(result["displacement"]).max(axis=1)).all()


@pytest.mark.parametrize(("e", "damping"), [(0.0, 0.5), (0.7, 1 - 1e-8), (0.7, 1.0)])
def test_a_mass_beyond_all_weights_flies_out_through_thirty_orders(here, e, damping):
    """Damping holds the beam, the mass drives it: 1e30 m on, energies and momenta are out of the range of numbers, and fill."""
    omega, impact = 150.0, {"mass_ratio": 1e300, "restitution": e}
    scene = {**struck_beam(e, recontact={}), "impact": impact, "rotation": {"angular_velocity": omega}}
    response = {"duration": 0.5, "samples": 400, "points": [0.5, 1.0], "velocity": True}
    result = here.simulate("a", {**scene, "response": response, "damping": {"ratio": damping}, "modes": {"before": 4}})
    start, end = contacts(result)
    held = np.any([(result["time"] >= a) & (result["time"] < b) for a, b in zip(start, end)], axis=0)
    assert held.sum() > 300 and end[-1] == 0.5
    expected = np.sinh(omega * result["time"][held]) / omega
    np.testing.assert_allclose(result["displacement"][1, held], expected, rtol=1e-12)
    assert results.is_fill(result["momentum_after"][(result["event_kind"] > 0).sum() - 1])


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_of_two_masses_beyond_all_weights_the_heavier_makes_no_difference(here, e):
    """Within what is known of both; 1e307 beam masses are all but out of the range of numbers."""
    results_of = []
    for mass_ratio in [1e60, 1e200, 1e307]:
        impact = {"mass_ratio": mass_ratio, "restitution": e}
        here.scene("a", {**struck_beam(e, recontact={}), "impact": impact, "response": {**RESPONSE, "duration": 0.04}})
        results_of.append(here.run("a", "--overwrite", status=4 if e == 0.5 else 0))
        numbers = [variable.values for variable in results_of[-1].variables.values() if variable.values.dtype.kind == "f"]
        assert all(np.isfinite(values).all() for values in numbers)
    lighter = results_of[0]
    for heavier in results_of[1:]:
        np.testing.assert_array_equal(heavier["event_kind"], lighter["event_kind"])
        error = lighter["displacement_error"][:, None]
        assert (np.abs(heavier["displacement"] - lighter["displacement"]) <= error).all()
        assert (np.abs(heavier["event_time"] - lighter["event_time"]) <= lighter["event_time_error"]).all()


def test_an_energy_keeps_its_digits_while_beam_and_mass_grow_together(here):
    """By 1e45, pressed together: of the Jacobi energy's parts, which cancel, no digit is left. A trace of damping takes more than
    there was of it, and yet less than a rounding of the parts: −a∫∫ρA v̇² dx dt."""
    impact, rotation = {"mass_ratio": 3.0, "restitution": 0.3}, {"angular_velocity": 120.0}
    scene = {**struck_beam(0.3, recontact={}), "impact": impact, "rotation": rotation}
    scene["response"] = {**RESPONSE, "duration": 1.0, "samples": 100}
    result = here.simulate("a", scene)
    last = (result["event_kind"] > 0).sum() - 1
    assert np.abs(result["displacement"]).max() > 1e40
    assert (np.diff(result["energy_after"][: last + 1]) <= 0).all()
    assert result["energy_after"][last] == pytest.approx(result["energy_before"][last], rel=1e-6)  # rebounds that are left out
    xi = np.linspace(0, 1, 101)
    response = {**scene["response"], "samples": 2000, "points": xi.tolist()}
    damped = here.simulate("b", {**scene, "response": response, "damping": {"mass_proportional": 1e-38}})
    last = (damped["event_kind"] > 0).sum() - 1
    power = 1e-38 * BEAM_MASS * np.trapezoid(damped["velocity"] ** 2, xi, axis=0)
    lost = np.trapezoid(power, damped["time"]) * power[-1] / power[-2]  # grows on through the step after the last sample
    assert lost > 1e10 * damped["energy_before"][0]
    assert damped["energy_after"][last] == pytest.approx(-lost, rel=2e-2)  # the rule between samples


def test_the_smallest_restitution_is_none(here):
    """As e goes to 0 contacts go to those of e = 0, but for rebounds that are shorter and shorter."""
    start, end = contacts(here.simulate("a", struck_beam(0.0, recontact={})))
    for e in [1e-3, 1e-6, 1e-8, 1e-10, 1e-13, 1e-60]:
        here.scene("b", struck_beam(e, recontact={}))
        here.beamwave("run", "--overwrite", "b.nml", status=0)
        starts, ends = contacts(here.result("b"))
        for a, b in zip(start, end):
            assert np.abs(starts - a).min() < 0.02 * e**0.5 + 1e-12
            assert np.abs(ends - b).min() < 0.1 * e + 1e-12


def test_where_contacts_leave_nothing_that_is_known_it_is_said_and_the_rest_is_fill(here):
    """Twelve modes, e = 1: 36 contacts amplify the last of 16 digits to the third."""
    impact = {"mass_ratio": 2.0, "restitution": 1.0}
    scene = {**struck_beam(1.0, recontact={"max_contacts": 1000}), "impact": impact, "modes": {"before": 12}}
    here.scene("a", {**scene, "response": {**RESPONSE, "duration": 0.2}})
    ended = here.beamwave("run", "a.nml", status=4)
    result = here.result("a")
    flags = dict(zip(result.variables["case_status"].attributes["flag_meanings"].split(), range(9)))
    assert result["case_status"] == flags["ill_conditioned"]
    said = re.search(r"after (\d+) contacts, .* the motion is unknown from t = (\S+) s on", result.attributes["notes"])
    start, _ = contacts(result)
    assert len(start) == int(said[1]) > 30
    known = result["time"] < float(said[2])
    assert 0 < known.sum() < len(known)
    errors = result["event_time_error"][1 : 1 + len(start)]
    assert start[-1] - errors[-1] <= float(said[2]) * 1.00001  # six digits
    for name in ["displacement", "velocity"]:
        assert (results.is_fill(result[name]) == ~known).all()
    # of the tip's displacement three digits are asked for; of a velocity its whole jump may be in doubt
    assert (result["displacement_error"] < 1e-2 * np.abs(result["displacement"][:, known]).max(axis=1)).all()
    assert (result["velocity_error"] < np.abs(result["velocity"][:, known]).max(axis=1)).all()
    assert results.is_fill(result["event_time"][1 + len(start) :]).all()
    assert errors[0] < 1e-15 * start[0] * 10
    assert errors[-1] > 1e-9
    assert "amplify every change of the data" in result.attributes["notes"]
    assert ended.stderr.count("warning") == 4  # and that a velocity is in doubt by a jump, and peaks between samples


@pytest.mark.parametrize("most", [1, 3, 6])
@pytest.mark.parametrize("damping", [{}, {"damping": {"ratio": 0.01}}])
def test_from_the_first_contact_that_is_not_counted_on_nothing_is_told(here, most, damping):
    """Up to there the motion is that of as many contacts as come; from there on it is not that of a mass that is gone."""
    asked = {"duration": 0.0015, "samples": 4000, "points": [0.5, 1.0], "velocity": True, "bending_moment": True}
    for name, count in [("few", most), ("all", 200)]:
        scene = {**struck_beam(0.2, recontact={"max_contacts": count}, **damping), "spectrum": {}}
        here.scene(name, {**scene, "response": asked})
    whole, part = here.run("all"), here.run("few", status=4)
    start, end = contacts(whole)
    known = whole["time"] < start[most]
    assert 0 < known.sum() < asked["samples"]
    for name in ["displacement", "velocity", "bending_moment"]:
        np.testing.assert_array_equal(part[name][:, known], whole[name][:, known])
        assert results.is_fill(part[name][:, ~known]).all()
    for name in ["event_time", "event_end", "event_kind", "event_impulse"]:
        np.testing.assert_array_equal(part[name], whole[name][: 1 + most])
    assert part["case_status"] == 2 and whole["case_status"] == 0
    assert results.is_fill(part["amplitude"]).all()
    said = re.search(r"max_contacts is (\d+), and the mass strikes once more at t = (\S+) s", part.attributes["notes"])
    assert int(said[1]) == most and float(said[2]) == float(f"{start[most]:.6g}")
    assert "max_contacts" not in whole.attributes["notes"]


def test_the_report_lists_the_first_eight_events_and_their_times(here):
    here.scene("a", struck_beam(0.2, recontact={}))
    report = here.beamwave("run", "a.nml").stdout
    start, end = contacts(here.result("a"))
    heading = next(line for line in report.splitlines() if line.startswith("  event "))
    assert heading.split()[1:4] == ["time", "+/-", "until"]
    rows = [line.split()[1:] for line in report.splitlines() if line.startswith("  contact ")]
    assert len(rows) == 7 < len(start)
    assert f"...  {1 + len(start) - 8} more" in report
    for row, begins, ends in zip(rows, start, end):
        assert float(row[0]) == float(f"{begins:.7g}")
        assert float(row[1]) < 1e-15
        assert (len(row) == 8) == (ends > begins)


def test_a_sweep_holds_cases_with_different_numbers_of_contacts(here):
    sweep = {"parameter": "impact%restitution", "values": [0.0, 0.2, 0.9]}
    result = here.simulate("a", struck_beam(0.0, recontact={}), sweep)
    assert result["event_kind"].shape == (3, 101)
    counts = (result["event_kind"] > 0).sum(axis=1)
    assert len(set(counts)) > 1
    for case, count in enumerate(counts):
        assert not results.is_fill(result["event_time"][case, :count]).any()
        assert results.is_fill(result["event_time"][case, count:]).all()


def test_of_a_beam_so_thin_that_its_time_is_long_all_contacts_are_known(here):
    """l²/h above a second: what is never lost is told by no time in seconds."""
    beam, response = {"diameter": 1e-5}, {"duration": 100.0, "samples": 1}
    here.scene("a", {**struck_beam(0.5, recontact={"max_contacts": 3}, beam=beam, rotation=None), "response": response})
    result = here.run("a", status=4)  # for want of a fourth contact
    assert (result["event_kind"] == 4).sum() == 3 and "ill-conditioned" not in result.attributes["notes"]


def test_next_to_no_mass_makes_next_to_no_motion(here):
    """A blow of 1e-67 V, on a thin beam that grows by it: nothing of it is known, or all of it."""
    scene = struck_beam(0.0, recontact={"max_contacts": 3}, beam={"diameter": 1e-3}, rotation={"angular_velocity": 1005.329})
    response = {"duration": 0.02, "samples": 2, "points": [0.5, 1.0], "velocity": True}
    impact = {"mass_ratio": 1.4093e-66, "approach_velocity": -0.03}
    here.scene("a", {**scene, "impact": impact, "response": response, "modes": {"before": 1}})
    assert here.beamwave("run", "a.nml").returncode in (0, 4)
    result = here.result("a")
    known = ~results.is_fill(result["displacement"])
    assert (np.abs(result["displacement"][known]) < 1e-60).all()


def test_no_mass_and_no_velocity_make_no_contact(here):
    for name, impact in [("a", {"mass_ratio": 0.0}), ("b", {"mass_ratio": 0.2, "approach_velocity": 0.0})]:
        result = here.simulate(name, {**struck_beam(0.0, recontact={}), "impact": impact})
        assert (result["event_kind"][1:] == 0).all()
        assert not result["displacement"].any()
