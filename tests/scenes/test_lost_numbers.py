"""Numbers that cannot be trusted end with 4: the result is there, with fill from the first lost sample on."""

import re

import numpy as np
import results
from workplace import captured_beam

FAST = 400.0  # rad/s, above the critical angular velocity of mode 1 (121.8) and below that of mode 2 (849)
OVERFLOWING = captured_beam(
    rotation={"angular_velocity": FAST},
    response={"duration": 4.0, "samples": 4096, "velocity": True},
)
OUT_OF_REACH = r"a\.nml:\d+: modes%tolerance: 1e-12 cannot be reached .*; accepted: (\S+) or more"


def growth(result):
    return result["growth_rate"][0]


def test_an_overflowing_mode_ends_with_4_and_is_named_with_its_time(here):
    here.scene("a", OVERFLOWING)
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == 4
    notes = here.result("a").attributes["notes"]
    assert "mode 1 overflows at t = " in notes
    assert "1 of 10 modes grow" in notes
    for line in notes.splitlines():
        assert line in ended.stdout
        assert f"a.nml: warning: {line}" in ended.stderr


def test_the_histories_are_fill_from_the_first_lost_sample_on(here):
    here.scene("a", OVERFLOWING)
    result = here.run("a", status=4)
    first = int(np.argmax(results.is_fill(result["displacement"][1])))
    time = result["time"]
    # e^(|β|t) reaches the largest double, 1.8e308, at |β|t = 709.8; the amplitude is within e^±20
    assert 709.8 - 20 < growth(result) * time[first] < 709.8 + 20
    for name in ["displacement", "velocity"]:
        values = result[name]
        assert np.isfinite(values).all()
        assert not results.is_fill(values[:, :first]).any()
        assert results.is_fill(values[:, first:]).all()
    assert f"{time[first]:.6g}" in result.attributes["notes"]


def test_a_bending_moment_that_is_lost_earlier_has_its_own_note(here):
    watched = {**OVERFLOWING["response"], "bending_moment": True}
    here.scene("a", {**OVERFLOWING, "response": watched})
    here.scene("b", {**OVERFLOWING, "response": {**watched, "duration": float(709.0 / growth(here.run("a", status=4)))}})
    for name in ["a", "b"]:  # in the second only the moment is lost, EI/l² being 18 kN
        result = here.run(name, status=4) if name == "b" else here.result(name)
        lost = results.is_fill(result["bending_moment"])
        first = int(np.argmax(lost[0]))
        assert not lost[:, :first].any() and lost[:, first:].all()
        assert not results.is_fill(result["displacement"][:, : first + 1]).any()
        (note,) = re.findall(r"overflow of the bending moment: .* at t = (\S+) s; .*", result.attributes["notes"])
        np.testing.assert_allclose(float(note), result["time"][first], rtol=1e-5)


def test_what_came_before_is_what_a_shorter_run_gives(here):
    here.scene("a", OVERFLOWING)
    lost = here.run("a", status=4)
    here.scene("b", {**OVERFLOWING, "response": {"duration": 1.0, "samples": 1024, "velocity": True}})
    kept = here.run("b")
    close = {"rtol": 1e-12, "atol": 1e-15}  # |β|t ≤ 381 multiplies a rounding of β by as much
    np.testing.assert_allclose(lost["displacement"][:, :1024], kept["displacement"], **close)


def test_the_case_says_diverged_and_the_rest_of_it_stands(here):
    here.scene("a", OVERFLOWING)
    result = here.run("a", status=4)
    meanings = result.variables["case_status"].attributes["flag_meanings"].split()
    assert meanings[int(result["case_status"])] == "diverged"
    unstable = np.sqrt(FAST**2 - result["critical_angular_velocity"] ** 2)  # each a few roundings from exact
    np.testing.assert_allclose(growth(result), unstable, rtol=1e-14)
    for name in ["angular_frequency", "phase_velocity", "group_velocity"]:
        np.testing.assert_array_equal(results.is_fill(result[name]), [True] + 9 * [False])


def test_a_spectrum_of_lost_histories_is_fill_and_measures_nothing(here):
    here.scene("a", {**OVERFLOWING, "spectrum": {}})
    result = here.run("a", status=4)
    assert results.is_fill(result["amplitude"]).all()
    assert result["peak_count"] == 0
    assert results.is_fill(result["measured_angular_frequency"]).all()


def test_only_the_cases_that_overflow_are_marked(here):
    speeds = [50.0, 300.0, FAST, 100.0]
    here.scene("a", OVERFLOWING, {"parameter": "rotation%angular_velocity", "values": speeds})
    result = here.run("a", status=4)
    np.testing.assert_array_equal(result["case_status"], [0, 1, 1, 0])
    np.testing.assert_array_equal(results.is_fill(result["displacement"]).any(axis=(1, 2)), [False, True, True, False])
    assert "2 of 4 cases" in result.attributes["notes"]


def test_growth_without_overflow_is_a_result_to_trust(here):
    here.scene("a", captured_beam(rotation={"angular_velocity": FAST}, response={"duration": 0.1, "samples": 64}))
    result = here.run("a")
    assert not results.is_fill(result["displacement"]).any()
    assert "1 of 10 modes grow" in result.attributes["notes"]


def test_a_tolerance_out_of_reach_is_refused_and_one_in_reach_named(here):
    here.scene("a", by_tolerance(1e-12, impact={"mass_ratio": 1e-12}))
    refused = here.beamwave("run", "a.nml", "--quiet")  # a log of a slow machine has lines of progress
    assert refused.returncode == 2
    named = re.search(OUT_OF_REACH, refused.stderr)
    assert not (here.directory / "output/a.nc").exists()
    checked = here.beamwave("check", "a.nml")
    assert (checked.returncode, checked.stdout, checked.stderr) == (2, "", refused.stderr)
    here.scene("b", by_tolerance(float(named[1]), impact={"mass_ratio": 1e-12}))
    assert here.beamwave("check", "b.nml").returncode == 0


def test_shear_reaches_less_and_says_how_far(here):
    here.scene("a", by_tolerance(1e-12, shear={}))
    checked = here.beamwave("check", "a.nml")
    assert checked.returncode == 2
    assert 1e-10 < float(re.search(OUT_OF_REACH, checked.stderr)[1]) < 1e-8  # amplitudes fall as k^-2


def test_modes_that_cannot_be_found_are_told_beforehand(here):
    # at 1e9 rad/s bending is left to a layer of 7e-8 of the beam
    here.scene("a", by_tolerance(1e-3, rotation={"angular_velocity": 1e9}, stiffening={}))
    checked = here.beamwave("check", "a.nml")
    assert checked.returncode == here.beamwave("run", "a.nml").returncode == 4
    assert "not converged" in checked.stderr


def test_a_case_of_a_sweep_whose_tolerance_is_out_of_reach_is_not_converged(here):
    sweep = {"parameter": "impact%mass_ratio", "values": [0.2, 1e-12]}
    here.scene("a", by_tolerance(1e-12), sweep)
    result = here.run("a", status=4)
    meanings = result.variables["case_status"].attributes["flag_meanings"].split()
    assert [meanings[int(status)] for status in result["case_status"]] == ["done", "not_converged"]
    lost = results.is_fill(result["displacement"])
    assert lost[1].all() and not lost[0].any()
    assert "1e-12 cannot be reached" in result.attributes["notes"]


def by_tolerance(tolerance, **groups):
    scene = captured_beam(response={"duration": 0.1, "samples": 256}, **groups)
    return {**scene, "modes": {"tolerance": tolerance}}
