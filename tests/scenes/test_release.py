"""A captured mass leaves again: what is continuous, what is kept, what is lost, and the limits of its time."""

import re

import numpy as np
import pytest
import results
from closed_form import CapturedBeam, roots, shapes
from conftest import PROJECT
from workplace import captured_beam

RESPONSE = {"duration": 0.25, "samples": 1000, "points": [0.5, 1.0], "velocity": True}
LEAVES = 0.1  # s: sample 400 exactly
COUNTS = {"before": 30, "after": 20}


def released_beam(**groups):
    return captured_beam(**{"modes": COUNTS, "response": RESPONSE, "release": {"time": LEAVES}, **groups})


def gauss(count=500):
    point, weight = np.polynomial.legendre.leggauss(count)
    return (point + 1) / 2, weight / 2


def motion(position, time):
    """Displacement (position, time) after the release: the projection by quadrature, then free modes."""
    before = CapturedBeam(0.2, 50.0, before=30, after=20)
    free = roots(30, 0.0)
    point, weight = gauss()
    beta = before.frequency(before.alpha)
    q = before.modal_velocity() / beta * np.sin(beta * LEAVES)
    rate = before.modal_velocity() * np.cos(beta * LEAVES)
    onto = (shapes(free, point) * weight[:, np.newaxis]).T @ shapes(before.alpha, point)  # free masses are 1
    p, p_rate = onto @ q, onto @ rate
    beta = before.frequency(free)
    modal = p[:, np.newaxis] * np.cos(np.outer(beta, time)) + (p_rate / beta)[:, np.newaxis] * np.sin(np.outer(beta, time))
    return shapes(free, position) @ modal


@pytest.mark.parametrize("groups", [{"impact": {"mass_ratio": 0.0}}, {"impact": {"mass_ratio": 0.2, "approach_velocity": 0.0}}])
def test_what_stands_still_meets_any_tolerance_through_a_release(here, groups):
    here.scene("a", captured_beam(modes=None, response={"duration": 0.02, "samples": 9}, release={"time": 0.01}, **groups))
    result = here.run("a")
    assert (result["displacement"] == 0.0).all() and (result["displacement_error"] == 0.0).all()


def test_a_single_sample_by_tolerance_knows_what_the_mass_takes_along(here):
    """The energy of beam and mass before the release is what the capture left: ½m_j V² of the continuum."""
    one = {"duration": 0.02, "samples": 1}
    result = here.simulate("a", captured_beam(modes=None, response=one, release={"time": 0.01}, impact={"mass_ratio": 0.2}))
    assert result["displacement"].tolist() == [[0.0]] * len(result["displacement"])
    np.testing.assert_allclose(result["energy_before"][2], result["energy_after"][1], rtol=1e-5)


def test_before_it_the_motion_is_that_of_the_capture_and_after_it_that_of_the_beam_alone(here):
    kept, left = here.simulate("a", captured_beam(modes=COUNTS, response=RESPONSE)), here.simulate("b", released_beam())
    np.testing.assert_allclose(left["displacement"][:, :400], kept["displacement"][:, :400], atol=1e-16)
    late = left["time"] >= LEAVES
    assert late.sum() == 600  # the sample at exactly its time is the first of them
    expected = motion([0.5, 1.0], left["time"][late] - LEAVES)
    # 1000 rad of phase in numpy's mode 30, which is 1e-4 of the whole
    np.testing.assert_allclose(left["displacement"][:, late], expected, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("plane", ["in", "out"])
def test_generalised_momentum_is_kept_and_energy_lost_by_truncation_alone(here, plane):
    lost = []
    for count in [20, 80, 320]:
        modes = {"before": count, "after": 20}
        here.scene("a", released_beam(modes=modes, rotation={"angular_velocity": 50.0, "plane": plane}))
        result = here.run("a", "--overwrite")
        np.testing.assert_array_equal(result["event_kind"], [1, 2, 3])
        np.testing.assert_array_equal(result["event_time"], [0.0, 0.0, LEAVES])
        # the integrals of 20 modes, each to 1e-13 of the largest
        np.testing.assert_allclose(result["momentum_after"][2], result["momentum_before"][2], rtol=1e-11)
        np.testing.assert_allclose(result["energy_before"][2], result["energy_after"][1], rtol=1e-12)
        lost.append(1 - result["energy_after"][2] / result["energy_before"][2])
    assert lost[0] > lost[1] > lost[2] > 0
    # strain: sum of (force/alpha^2)^2, so n^-3 in the end; velocities of 20 smooth shapes fall no more slowly
    assert lost[2] < lost[1] / 16
    assert lost[2] < 1e-6


LEAVING = {  # what else the body takes with it, and how fast the loss falls with the count
    "tension": ({"stiffening": {"hub_radius": 0.2}}, 2.0),
    "shear": ({"shear": {}}, 0.7),
    "spin": ({"capture": {"rotary_inertia": 0.01}}, 0.7),
    "all": ({"stiffening": {}, "shear": {}, "capture": {"rotary_inertia": 1e-3}}, 0.7),
}


@pytest.mark.parametrize("plane", ["in", "out"])
@pytest.mark.parametrize("effect", LEAVING)
def test_spin_and_the_work_against_tension_leave_with_the_body(here, effect, plane):
    """Then nothing is lost but by truncation: as n^-3, or as n^-1 where the tip's moment or shear ends of a sudden."""
    groups, power = LEAVING[effect]
    lost = []
    for count in [20, 80]:
        modes = {"before": count, "after": 20}
        here.scene("a", released_beam(modes=modes, rotation={"angular_velocity": 50.0, "plane": plane}, **groups))
        result = here.run("a", "--overwrite")
        np.testing.assert_allclose(result["energy_before"][2], result["energy_after"][1], rtol=1e-11)
        np.testing.assert_allclose(result["momentum_after"][2], result["momentum_before"][2], rtol=1e-10)
        lost.append(1 - result["energy_after"][2] / result["energy_before"][2])
    assert 0 < lost[1] < lost[0] / 4**power


def test_out_of_plane_a_body_that_turns_takes_no_part_of_the_centrifugal_force(here):
    """It is isotropic: what the modes of the beam alone lose falls to nothing, though J omega^2 psi^2 is a third of the energy."""
    fast = {"angular_velocity": 150.0, "plane": "out"}
    lost = []
    for count in [20, 80, 320]:
        groups = {"rotation": fast, "stiffening": {}, "capture": {"rotary_inertia": 1.0}, "release": {"time": 0.01}}
        result = here.simulate("a", released_beam(modes={"before": count, "after": 10}, **groups), options=["--overwrite"])
        lost.append(1 - result["energy_after"][2] / result["energy_before"][2])
    assert 0 < lost[2] < lost[1] / 2.6 < lost[0] / 2.6**2  # as n^-1 in the end: the moment at the tip ends of a sudden


@pytest.mark.parametrize("modes", [{"before": 10, "after": 10}, {"tolerance": 1e-6}])
@pytest.mark.parametrize("ratio", [0.0, 1e-9])
def test_the_energy_of_a_motion_that_has_grown_is_what_it_was_less_what_is_damped(here, modes, ratio):
    """By e^26: motion and centrifugal force are 1e22 times their difference."""
    fast = {"angular_velocity": 150.0}
    scene = released_beam(rotation=fast, release={"time": 0.3}, response={"duration": 0.4, "samples": 100})
    result = here.simulate("a", {**scene, "modes": modes, "damping": {"ratio": ratio}})
    assert np.abs(result["displacement"]).max() > 1e8
    if ratio == 0:
        np.testing.assert_allclose(result["energy_before"][2], result["energy_after"][1], rtol=1e-14)
    else:  # the integral of M c q'^2 of mode 1, q' = q'(0) cosh |beta|t; the rest is 1e-9 of 0.8 J
        rate, growth = 2 * ratio * 46.6304239974881 * result["wavenumber"][0] ** 2, result["growth_rate"][0]
        taken = result["modal_mass"][0] * rate * result["modal_velocity"][0] ** 2 * np.exp(0.6 * growth) / (8 * growth)
        np.testing.assert_allclose(result["energy_before"][2], -taken, rtol=1e-6)
    assert result["energy_after"][2] <= result["energy_before"][2]


def test_an_energy_that_rounding_has_eaten_is_fill_and_is_told(here):
    """Of 1e22 J the modes of the beam alone lack n^-3, and that is the energy that is left: too little beside rounding."""
    fast = {"angular_velocity": 150.0}
    scene = released_beam(rotation=fast, release={"time": 0.3}, response={"duration": 0.4, "samples": 100})
    result = here.simulate("a", {**scene, "modes": {"before": 3000, "after": 40}})
    assert results.is_fill(result["energy_after"][2])
    np.testing.assert_allclose(result["energy_before"][2], result["energy_after"][1], rtol=1e-14)
    assert "energy lost in rounding" in result.attributes["notes"]


def test_an_energy_larger_than_any_number_is_fill_and_is_told(here):
    grown = {"rotation": {"angular_velocity": 150.0}, "release": {"time": 2.5}, "impact": {"approach_velocity": 1e100}}
    here.scene("a", released_beam(**grown, response={"duration": 2.6, "samples": 100}, modes={"before": 10, "after": 10}))
    result = here.run("a")
    assert results.is_fill(result["energy_after"][2])
    np.testing.assert_allclose(result["energy_before"][2], result["energy_after"][1], rtol=1e-14)
    assert "energy of the release: too large" in result.attributes["notes"]


def test_a_release_at_the_last_sample_or_later_changes_nothing_before_it(here):
    kept = here.simulate("a", captured_beam(modes=COUNTS, response=RESPONSE))
    here.scene("b", released_beam(release={"time": 0.24975}))
    np.testing.assert_allclose(here.run("b")["displacement"][:, :-1], kept["displacement"][:, :-1], atol=1e-16)
    late = here.simulate("c", released_beam(release={"time": 0.25}))
    np.testing.assert_array_equal(late["displacement"], kept["displacement"])
    np.testing.assert_array_equal(late["event_kind"], [1, 2, 0])
    assert "after the end of the histories" in late.attributes["notes"]


@pytest.mark.parametrize("modes", [None, {"tolerance": 1e-4}, COUNTS])
def test_a_release_after_the_last_sample_is_an_event_that_no_sample_shows(here, modes):
    """All histories, spectra and errors are those of the capture; only the waves have no samples left."""
    response = {"duration": 0.02, "samples": 40, "points": [0.5, 1.0], "velocity": True}
    scene = captured_beam(modes=None, response=response, spectrum={}) | ({"modes": modes} if modes else {})
    kept, late = here.simulate("a", scene), here.simulate("b", {**scene, "release": {"time": 0.0199999}})
    for name in ["displacement", "velocity", "displacement_error", "velocity_error", "amplitude"]:
        np.testing.assert_allclose(late[name], kept[name], rtol=1e-4, atol=1e-9 * np.abs(kept[name]).max())
    np.testing.assert_array_equal(late["event_kind"], [1, 2, 3])
    np.testing.assert_allclose(late["energy_before"][2], late["energy_after"][1], rtol=1e-3)
    assert late["peak_count"] == 0 and "no sample comes after the last event" in late.attributes["notes"]


@pytest.mark.parametrize(("mass_ratio", "speed"), [(0.0, 1e184), (0.2, 1e-200)])
def test_of_no_mass_and_of_next_to_no_speed_all_energies_are_zero(here, mass_ratio, speed):
    """Also where the square of the speed is beyond the range of numbers."""
    result = here.simulate("a", released_beam(impact={"mass_ratio": mass_ratio, "approach_velocity": speed}))
    for name in ["energy_before", "energy_after"]:
        assert (result[name][:3] == 0.0).all()
    assert np.isfinite(result["momentum_after"]).all() and np.isfinite(result["displacement"]).all()


def test_a_light_mass_takes_nothing(here):
    here.scene("a", released_beam(impact={"mass_ratio": 1e-9}))
    left, kept = here.run("a"), here.simulate("b", captured_beam(impact={"mass_ratio": 1e-9}, modes=COUNTS, response=RESPONSE))
    late = np.abs(kept["displacement"]).max()
    # 20 modes with it, 30 without: the same shapes but for 1e-9
    np.testing.assert_allclose(left["displacement"], kept["displacement"], atol=1e-6 * late)


def test_estimates_hold_against_many_more_modes(here):
    few, many = here.simulate("a", released_beam()), here.simulate("b", released_beam(modes={"before": 1500, "after": 1500}))
    error = np.abs(few["displacement"] - many["displacement"]).max(axis=1)
    assert (few["displacement_error"] >= error).all()
    assert (few["displacement_error"] <= 10 * error).all()


def test_the_report_says_when_events_come_where_not_all_are_at_the_start(here):
    here.scene("a", released_beam())
    lines = here.beamwave("run", "a.nml").stdout.splitlines()
    head = next(i for i, line in enumerate(lines) if re.match(r"  event +time +impulse +energy before", line))
    times = {line.split()[0]: float(line.split()[1]) for line in lines[head + 2 : head + 5]}
    assert times == {"impact": 0.0, "capture": 0.0, "release": LEAVES}
    here.scene("b", captured_beam(modes=COUNTS, response=RESPONSE))
    assert re.search(r"^  event +impulse +energy before", here.beamwave("run", "b.nml").stdout, re.MULTILINE)


def by_tolerance(tolerance, **groups):
    return {**released_beam(**groups), "modes": {"tolerance": tolerance}}


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_with_a_tolerance_a_release_loses_nothing(here, tolerance):
    """Errors of the histories are in test_tails.py."""
    result = here.simulate("a", by_tolerance(tolerance))
    assert (result["displacement_error"] <= tolerance * np.abs(result["displacement"]).max()).all()
    np.testing.assert_allclose(result["energy_before"][2], result["energy_after"][1], rtol=1e-14)
    np.testing.assert_allclose(result["momentum_after"][2], result["momentum_before"][2], rtol=1e-7)


def test_a_release_that_a_tolerance_cannot_follow_names_one_that_it_can(here):
    """A few hundred modes with tension know the velocity of the tip to 1e-3."""
    here.scene("a", by_tolerance(1e-4, stiffening={}))
    refused = here.beamwave("run", "a.nml", status=2)
    named = re.search(r"modes%tolerance: 1e-4 cannot be reached .*; accepted: (\S+) or more", refused.stderr)
    assert 1e-4 < float(named[1]) < 1e-2


def test_the_scene_shows_what_its_head_says(here):
    here.beamwave("run", PROJECT / "input/effects/release.nml", status=0)
    result = here.result("release")
    periods = 2e3 * np.pi / np.array([result["angular_frequency"][0], result["angular_frequency_before"][0]])
    assert [f"{period:.1f}" for period in periods] == ["56.6", "40.2"]
    tip = result["displacement"][1]
    late = result["time"] > 0.1
    turns = np.diff(np.sign(np.convolve(tip[late], np.ones(400) / 400, "valid"))) != 0  # 20 ms smooth out the rest
    assert abs(np.mean(np.diff(np.flatnonzero(turns))) * (0.4 / 8192) * 2e3 - 40.2) < 2


def test_a_history_that_may_be_nothing_but_error_is_told_first(here):
    text = (PROJECT / "input/effects/release.nml").read_text()
    here.write("a.nml", text.replace("samples = 8192", "samples = 8192, velocity = .true."))
    assert here.beamwave("run", "a.nml").returncode == 0
    first = here.result("a").attributes["notes"].splitlines()[0]
    assert float(re.search(r"error of the velocity: at xi = 0.5 it may be off by (\d+) % of its largest value", first)[1]) > 90
