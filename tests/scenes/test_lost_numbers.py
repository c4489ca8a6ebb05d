"""Numbers that cannot be trusted end with 4: the result is there, with fill from the first lost sample on."""

import re

import numpy as np
import pytest
import results
from workplace import captured_beam, unwrapped

FAST = 400.0  # rad/s, above the critical angular velocity of mode 1 (121.8) and below that of mode 2 (849)
OVERFLOWING = captured_beam(
    rotation={"angular_velocity": FAST},
    response={"duration": 4.0, "samples": 4096, "velocity": True},
)
WEAK_UNDER_TENSION = {  # a mass that hardly counts: what is missing falls slowly, and the basis ends at some hundred modes
    **captured_beam(stiffening={}, impact={"mass_ratio": 1e-9}, modes=None),
    "response": {"duration": 0.1, "samples": 256},
}
OUT_OF_REACH = r"a\.nml:\d+: modes%tolerance: 1e-12 cannot be reached .*; accepted: (\S+) or more"


def growth(result):
    return result["growth_rate"][0]


def test_an_overflowing_mode_ends_with_4_and_is_named_with_its_time(here):
    here.scene("a", OVERFLOWING)
    ended = here.beamwave("run", "a.nml", status=4)
    notes = here.result("a").attributes["notes"]
    assert "mode 1 overflows at t = " in notes
    assert "1 of 10 modes grow" in notes
    for line in notes.splitlines():
        assert f"warning: {line}" in unwrapped(ended.stdout)
        assert f"a.nml: warning: {line}" in ended.stderr


def test_the_histories_are_fill_from_the_first_lost_sample_on(here):
    result = here.simulate("a", OVERFLOWING, status=4)
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


@pytest.mark.parametrize("count", [8, 64])
def test_a_history_that_the_last_octave_of_modes_decides_is_fill(here, count):
    """Where no wave has come yet, modes only cancel: their sum is less than what the last of them add to it."""
    watched = {"duration": 1e-5, "samples": 64, "points": [0.2, 1.0], "velocity": True}
    scene = captured_beam(rotation=None, modes={"before": count, "after": count}, response=watched)
    result = here.simulate("a", {**scene, "impact": {**scene["impact"], "profile_points": 6}}, status=4)
    assert result.attributes["notes"].splitlines()[0].startswith("error of the displacement: at xi = 0.2")
    assert f"not converged: the displacement at xi = 0.2 is smaller than the contribution of modes {count // 2 + 1} to {count}, and is missing" in result.attributes["notes"]
    beta, rate = result["angular_frequency"][:, None], result["modal_velocity"][:, None]
    for point, profile in [(0, 1), (1, 5)]:
        moved = result["mode_shape"][:, profile, None] * rate * np.sin(beta * result["time"]) / beta
        decided = np.abs(moved[count // 2 :].sum(axis=0)).max() > np.abs(moved.sum(axis=0)).max()
        assert decided == (point == 0)
        assert (results.is_fill(result["displacement"][point]) == decided).all()


def test_a_tolerance_is_one_of_the_largest_displacement(here):
    """A point that has hardly moved yet is no reason to take a history for lost that keeps the tolerance."""
    watched = {"duration": 1e-5, "samples": 64, "points": [0.05, 1.0]}
    here.scene("a", {**captured_beam(rotation=None, response=watched), "modes": {"tolerance": 1e-3}})
    assert not results.is_fill(here.run("a")["displacement"]).any()


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
    lost = here.simulate("a", OVERFLOWING, status=4)
    kept = here.simulate("b", {**OVERFLOWING, "response": {"duration": 1.0, "samples": 1024, "velocity": True}})
    close = {"rtol": 1e-12, "atol": 1e-15}  # |β|t ≤ 381 multiplies a rounding of β by as much
    np.testing.assert_allclose(lost["displacement"][:, :1024], kept["displacement"], **close)


def test_the_case_says_diverged_and_the_rest_of_it_stands(here):
    result = here.simulate("a", OVERFLOWING, status=4)
    meanings = result.variables["case_status"].attributes["flag_meanings"].split()
    assert meanings[int(result["case_status"])] == "diverged"
    unstable = np.sqrt(FAST**2 - result["critical_angular_velocity"] ** 2)  # each a few roundings from exact
    np.testing.assert_allclose(growth(result), unstable, rtol=1e-14)
    for name in ["angular_frequency", "phase_velocity", "group_velocity"]:
        np.testing.assert_array_equal(results.is_fill(result[name]), [True] + 9 * [False])


def test_a_spectrum_of_lost_histories_is_fill_and_measures_nothing(here):
    result = here.simulate("a", {**OVERFLOWING, "spectrum": {}}, status=4)
    assert results.is_fill(result["amplitude"]).all()
    assert result["peak_count"] == 0
    assert results.is_fill(result["measured_angular_frequency"]).all()


def test_only_the_cases_that_overflow_are_marked(here):
    speeds = [50.0, 300.0, FAST, 100.0]
    result = here.simulate("a", OVERFLOWING, {"parameter": "rotation%angular_velocity", "values": speeds}, status=4)
    np.testing.assert_array_equal(result["case_status"], [0, 1, 1, 0])
    np.testing.assert_array_equal(results.is_fill(result["displacement"]).any(axis=(1, 2)), [False, True, True, False])
    assert "2 of 4 cases" in result.attributes["notes"]


def test_growth_without_overflow_is_a_result_to_trust(here):
    result = here.simulate("a", captured_beam(rotation={"angular_velocity": FAST}, response={"duration": 0.1, "samples": 64}))
    assert not results.is_fill(result["displacement"]).any()
    assert "1 of 10 modes grow" in result.attributes["notes"]


def test_a_tolerance_out_of_reach_is_refused_and_one_in_reach_named(here):
    here.scene("a", by_tolerance(1e-12, impact={"mass_ratio": 1e-12}))
    refused = here.beamwave("run", "a.nml", "--quiet", status=2)  # a log of a slow machine has lines of progress
    named = re.search(OUT_OF_REACH, refused.stderr)
    assert not (here.directory / "output/a.nc").exists()
    checked = here.beamwave("check", "a.nml")
    assert (checked.returncode, checked.stdout, checked.stderr) == (2, "", refused.stderr)
    here.scene("b", by_tolerance(float(named[1]), impact={"mass_ratio": 1e-12}))
    assert here.beamwave("check", "b.nml").returncode == 0


def test_shear_reaches_less_and_says_how_far(here):
    here.scene("a", by_tolerance(1e-12, shear={}))
    checked = here.beamwave("check", "a.nml", status=2)
    assert 1e-11 < float(re.search(OUT_OF_REACH, checked.stderr)[1]) < 1e-8  # amplitudes fall as k^-2, and so the bound as 1/n


def test_bending_that_is_left_to_thin_layers_is_found(here):
    # at 1e9 rad/s to 7e-8 of the beam
    here.scene("a", by_tolerance(1e-3, rotation={"angular_velocity": 1e9}, stiffening={}))
    checked = here.beamwave("check", "a.nml", status=0)
    assert "outside linear theory" in checked.stderr
    assert here.run("a")["case_status"] == 0


@pytest.mark.parametrize("parameter, values", [("impact%mass_ratio", [0.2, 1e-12, 0.3]), ("modes%tolerance", [1e-3, 1e-12])])
def test_a_sweep_is_refused_where_an_outermost_case_alone_would_be(here, parameter, values):
    here.scene("a", by_tolerance(1e-12, impact={"mass_ratio": 1e-12}), {"parameter": parameter, "values": values})
    for command in ["check", "run"]:
        ended = here.beamwave(command, "a.nml", status=2)
        assert re.match(OUT_OF_REACH, ended.stderr)
        assert ended.stderr.endswith(f" (in the case {parameter} = 1e-12)\n")
    assert not (here.directory / "output").exists()


def test_a_case_within_a_sweep_whose_tolerance_is_out_of_reach_is_not_converged(here):
    # of so light a mass ten million modes have amplitudes that are nearly alike; what has grown by e^38 dwarfs them
    speeds = {"parameter": "rotation%angular_velocity", "values": [-FAST, 0.0, FAST]}
    result = here.simulate("a", by_tolerance(1e-11, impact={"mass_ratio": 1e-12}), speeds, status=4)
    meanings = result.variables["case_status"].attributes["flag_meanings"].split()
    assert [meanings[int(status)] for status in result["case_status"]] == ["done", "not_converged", "done"]
    lost = results.is_fill(result["displacement"])
    assert lost[1].all() and not lost[[0, 2]].any()
    assert "case 2: tolerance: 1e-11 cannot be reached" in result.attributes["notes"]


def test_a_default_out_of_reach_relaxes_and_the_resolved_scene_holds_what_was_used(here):
    here.scene("a", WEAK_UNDER_TENSION)
    checked = here.beamwave("check", "a.nml")
    assert checked.returncode == 0 and "the default tolerance 1e-6 is out of reach" in checked.stdout
    result = here.run("a")
    used = float(result["modes_tolerance"])
    assert 1e-6 < used < 0.01
    (said,) = re.findall(r"remark: tolerance: .* to (\S+) of its peak; the default 1e-6 is out of reach", result.attributes["notes"])
    assert float(said) == used
    assert result["case_status"] == 0 and not results.is_fill(result["displacement"]).any()
    peak = np.abs(result["displacement"]).max()
    assert result["displacement_error"].max() < used * peak
    here.write("b.nml", result.attributes["scene"])
    differing = results.differences(result, here.run("b"))
    assert sorted(differing) == ["given", "notes"]  # what was asked for is not remarked
    assert "nothing to do" in here.beamwave("run", "a.nml").stdout
    assert "nothing to do" in here.beamwave("run", "a.nml", "--overwrite").stdout


@pytest.mark.parametrize("more", [{}, {"shear": {}}, {"release": {"time": 0.07}}], ids=["tension", "shear", "release"])
def test_near_the_limit_a_tolerance_is_refused_or_kept_and_the_one_named_is_kept(here, more):
    # 400 modes under tension, 256 with shear: how far their phases agree only their sum tells
    scene = captured_beam(rotation={"angular_velocity": 50}, stiffening={}, response={"duration": 0.25, "samples": 512}, modes=None)
    here.scene("a", {**scene, **more, "modes": {"tolerance": 1e-12}})
    named = float(re.match(OUT_OF_REACH, here.beamwave("run", "a.nml").stderr)[1])
    for part in [0.9, 1.0]:
        tolerance = float(f"{part * named:.2e}")
        here.scene("a", {**scene, **more, "modes": {"tolerance": tolerance}})
        checked, ended = here.beamwave("check", "a.nml"), here.beamwave("run", "a.nml", "--overwrite")
        assert checked.returncode == ended.returncode in ([0] if part >= 1 else [0, 2]), (tolerance, ended.stderr)
        if ended.returncode == 0:
            result = here.result("a")
            assert result["displacement_error"].max() <= tolerance * np.abs(result["displacement"]).max()


def test_each_case_of_a_sweep_relaxes_the_default_by_itself(here):
    masses = [0.2, 1e-9]
    result = here.simulate("a", WEAK_UNDER_TENSION, {"parameter": "impact%mass_ratio", "values": masses})
    assert (result["case_status"] == 0).all()
    assert re.search("case 2: tolerance: .* of its peak; the default 1e-6 is out of reach", result.attributes["notes"])
    assert "tolerance" not in result.attributes["scene"] and "modes_tolerance" not in result.variables
    here.write("b.nml", result.attributes["scene"])
    assert results.differences(result, here.run("b")) == ["given"]  # its defaults are given now
    for case, mass in enumerate(masses):
        alone = here.simulate("c", {**WEAK_UNDER_TENSION, "impact": {"mass_ratio": mass}}, options=["--overwrite"])
        np.testing.assert_array_equal(alone["displacement"], result["displacement"][case])


def by_tolerance(tolerance, **groups):
    scene = captured_beam(response={"duration": 0.1, "samples": 256}, **groups)
    return {**scene, "modes": {"tolerance": tolerance}}
