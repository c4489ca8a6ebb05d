"""`beamwave accuracy`: what it writes, what it says, and how it ends. Seconds are never judged, only that they are there."""

import re
import signal
import time

import numpy as np
import pytest
import results
from workplace import SECONDS, captured_beam, wait_until

SMALL = captured_beam(response={"duration": 0.05, "samples": 256})
TOLERANCES = 10
COUNTS = [5, 10, 20, 50, 100, 200, 500, 1000, 2000]
LADDERS = {"tolerance": 1, "counts": 2}


@pytest.fixture(scope="module")
def measured(shared):
    """A place with the study of one scene, and what the program printed."""
    place = shared("accuracy")
    place.scene("a", SMALL)
    ended = place.beamwave("accuracy", "a.nml", status=0)
    return place, ended.stdout


@pytest.fixture(scope="module")
def study(measured):
    return measured[0].dataset("a.accuracy")


def ladder(ds, name):
    return ds.isel(rung=np.flatnonzero(ds.ladder.values == LADDERS[name]))


def test_the_file_is_all_that_is_left_and_says_what_it_is(measured, study):
    assert measured[0].left() == ["a.accuracy.nc"]
    assert study.attrs["study"] == "accuracy"
    assert study.attrs["Conventions"] == "CF-1.11"
    assert "beamwave accuracy a.nml" in study.attrs["history"]
    assert study.attrs["machine"] and study.attrs["compiler"]
    for name, variable in study.data_vars.items():
        assert variable.attrs["long_name"], name
        assert variable.attrs["units"], name
    assert study.impact_mass_ratio == 0.2
    assert study.ladder.attrs["flag_meanings"].split() == list(LADDERS)


def test_the_scene_in_the_file_is_the_scene_that_was_measured(measured, study):
    place = measured[0]
    place.write("again.nml", study.attrs["scene"])
    place.scene("once", SMALL)
    assert results.differences(place.run("again"), place.run("once")) == ["given"]  # its defaults are given now


def test_the_ladders_are_whole_and_go_from_coarse_to_fine(study):
    asked = ladder(study, "tolerance")
    np.testing.assert_allclose(asked.tolerance, [10.0**-digits for digits in range(2, 2 + TOLERANCES)], rtol=1e-15)
    assert (np.diff(asked.mode_count) >= 0).all()
    assert ladder(study, "counts").mode_count.values.tolist() == COUNTS
    assert np.isnan(ladder(study, "counts").tolerance).all()
    assert (study.rung_status == 1).all()


def test_every_tolerance_is_kept_and_no_error_is_above_its_estimate(study):
    asked = ladder(study, "tolerance")
    assert (asked.true_error <= asked.tolerance).all()
    known = study.true_error > study.converged_error
    assert known.sum() >= 15
    assert (study.estimated_error >= study.true_error).where(known, True).all()
    np.testing.assert_allclose(study.error_ratio, study.estimated_error / study.true_error, rtol=1e-12)


def test_true_errors_are_those_of_the_runs_themselves(measured, study):
    place = measured[0]
    place.scene("few", captured_beam(modes={"before": 20, "after": 20}, response={"duration": 0.05, "samples": 256}))
    fine = captured_beam(modes=None, response={"duration": 0.05, "samples": 256})
    place.scene("fine", {**fine, "modes": {"tolerance": 1e-11}})
    few, fine = (place.run(name)["displacement"] for name in ("few", "fine"))
    error = np.abs(few - fine).max() / np.abs(fine).max()
    found = ladder(study, "counts").swap_dims(rung="mode_count").true_error.sel(mode_count=20)
    assert abs(found - error) <= 2e-11  # of both runs against the converged one
    np.testing.assert_allclose(study.peak_displacement, np.abs(fine).max(), rtol=1e-10)


def test_more_modes_leave_smaller_errors(study):
    errors = ladder(study, "counts").true_error.values
    assert (errors[1:] < errors[:-1]).all()


def test_the_converged_run_is_finer_than_what_it_judges(study):
    assert study.converged_error <= 1e-12
    assert study.converged_mode_count > study.mode_count.max()


def test_every_rung_has_its_seconds_stage_by_stage(study):
    assert (study.repeats >= 3).all()
    assert (study.seconds > 0).all()
    assert ((study.seconds_lower <= study.seconds) & (study.seconds <= study.seconds_upper)).all()
    assert study.stage_seconds.dims == ("rung", "stage")
    assert (study.stage_seconds >= 0).all()
    assert study.stage.attrs["flag_meanings"] == "modes events response"
    steps = ladder(study, "tolerance").seconds.diff("rung").values
    np.testing.assert_allclose(ladder(study, "tolerance").digit_seconds[:-1], steps, rtol=1e-9, atol=1e-15)
    assert np.isnan(ladder(study, "counts").digit_seconds).all()


def test_the_printed_list_holds_the_numbers_of_the_file(measured, study):
    rows = [line.split() for line in measured[1].splitlines() if re.match(r" +\S+ +\d+ +(products|transform) ", line)]
    assert len(rows) == TOLERANCES + len(COUNTS)
    asked, counted = rows[:TOLERANCES], rows[-len(COUNTS) :]
    assert [float(row[0]) for row in asked] == [10.0**-digits for digits in range(2, 2 + TOLERANCES)]
    assert [int(row[0]) for row in counted] == COUNTS
    assert [int(row[1]) for row in asked] == ladder(study, "tolerance").mode_count.values.tolist()
    shown = [float(row[3].lstrip("<")) for row in counted]
    np.testing.assert_allclose(shown, ladder(study, "counts").true_error, rtol=0.06)
    milliseconds = [float(row[6]) for row in counted]
    np.testing.assert_allclose(milliseconds, 1e3 * ladder(study, "counts").seconds, rtol=0.006)
    assert "a tenth of the error takes" in measured[1]


def test_a_study_that_is_there_is_left_alone(measured):
    place = measured[0]
    before = (place.directory / "output/a.accuracy.nc").read_bytes()
    again = place.beamwave("accuracy", "a.nml", status=0)
    assert "nothing to do" in again.stdout
    assert (place.directory / "output/a.accuracy.nc").read_bytes() == before


def test_of_a_sweep_the_first_case_is_measured_and_replaces_another_study_when_told(here):
    speeds = {"parameter": "rotation%angular_velocity", "values": [30.0, 60.0]}
    here.scene("a", {**SMALL, "rotation": {"plane": "in"}}, speeds)
    here.write("output/a.accuracy.nc", "something else")
    refused = here.beamwave("accuracy", "a.nml", status=3)
    assert "--overwrite" in refused.stderr
    assert (here.directory / "output/a.accuracy.nc").read_text(encoding="utf-8") == "something else"
    ended = here.beamwave("accuracy", "a.nml", "--overwrite", "--quiet")
    assert (ended.returncode, ended.stdout) == (0, "")
    assert ended.stderr == ""
    assert here.left() == ["a.accuracy.nc"]
    ds = here.dataset("a.accuracy")
    assert ds.rotation_angular_velocity == 30.0
    assert "Of 2 cases only the first is measured: " in ds.attrs["report"].splitlines()[1]


def test_a_result_of_a_run_is_not_taken_for_a_study(here):
    here.simulate("a.accuracy", SMALL)
    here.scene("a", SMALL)
    refused = here.beamwave("accuracy", "a.nml", status=3)
    assert "--overwrite" in refused.stderr


REFUSED = {
    "no history": (captured_beam(), "&response"),
    "a rebound": (captured_beam(capture=None, response={"duration": 0.05, "samples": 16}), "&capture"),
    "no impact": (captured_beam(capture=None, impact=None), "&response"),
}


@pytest.mark.parametrize("scene, group", REFUSED.values(), ids=REFUSED.keys())
def test_a_scene_without_a_converged_answer_is_refused(here, scene, group):
    if "modes" in scene and "capture" not in scene:
        scene = {**scene, "modes": {"before": 12}}
    here.scene("a", scene)
    ended = here.beamwave("accuracy", "a.nml", status=2)
    assert ended.stdout == ""
    assert ended.stderr.startswith(f"a.nml: {group}: ")
    assert "accepted: " in ended.stderr
    assert not (here.directory / "output").exists()


SHORT = {"duration": 2e-3, "samples": 64, "points": [0.5, 1.0]}
COUNTED_IN_RUNS = {
    "a contact": {"impact": {"mass_ratio": 0.1}, "contact": {"radius": 0.02}, "response": {**SHORT, "duration": 3e-4, "bending_moment": True}},
    "a force on a struck beam": {**captured_beam(), "force": {"shape": "sine", "amplitude": 1.0, "frequency": 100.0}, "response": SHORT},
    "a pluck": {"initial": {"force": 10.0}, "response": {**SHORT, "velocity": True}},
    "a body that leaves": {"initial": {"force": 10.0}, "body": {"position": 0.6, "mass": 1.0, "until": 1e-3}, "response": {**SHORT, "bending_moment": True}},
}


@pytest.mark.parametrize("groups", COUNTED_IN_RUNS.values(), ids=COUNTED_IN_RUNS.keys())
def test_where_runs_find_their_modes_errors_are_of_all_histories(here, groups):
    scene = {"beam": captured_beam()["beam"], **{name: group for name, group in groups.items() if name != "modes"}}
    study = here.study("accuracy", "a", scene)
    asked = ladder(study, "tolerance")
    asked = asked.isel(rung=np.flatnonzero(asked.rung_status == 1))
    assert asked.sizes["rung"] >= 3 and (asked.seconds > 0).all()
    assert study.converged_tolerance <= asked.tolerance.min()
    assert (asked.true_error <= asked.tolerance).all()
    known = study.true_error > study.converged_error
    assert (study.estimated_error >= study.true_error).where(known, True).all()
    coarse, fine = (own_run(here, scene, max(1e-12, float(study[name].max()))) for name in ("tolerance", "converged_tolerance"))
    names = [name for name in HISTORIES if name in fine.variables]
    differences = [float(np.abs(coarse[name] - fine[name]).max() / np.abs(fine[name]).max()) for name in names]
    np.testing.assert_allclose(asked.true_error.values[0], max(differences), rtol=1e-6, atol=1e-13)


HISTORIES = ["displacement", "velocity", "acceleration", "bending_moment", "shear_force"]


def own_run(here, scene, tolerance):
    name = f"at{-round(np.log10(tolerance))}"
    return here.simulate(name, {**scene, "modes": {"tolerance": tolerance}})


def test_two_scenes_are_one_too_many(here):
    here.scene("many/a", SMALL)
    here.scene("many/b", SMALL)
    for words in (["many/a.nml", "many/b.nml"], ["many"], []):
        ended = here.beamwave("accuracy", *words, status=2)
        assert "one scene" in ended.stderr
    assert not (here.directory / "output").exists()


def test_a_beam_at_rest_has_no_error_at_any_price(here):
    here.scene("a", captured_beam(impact={"mass_ratio": 0.0}, response={"duration": 0.01, "samples": 8}))
    ended = here.beamwave("accuracy", "a.nml")
    assert (ended.returncode, ended.stderr) == (0, "")
    ds = here.dataset("a.accuracy")
    assert (ds.true_error == 0.0).all() and (ds.estimated_error == 0.0).all()
    assert np.isnan(ds.work_slope)


@pytest.mark.parametrize("number, groups", [(signal.SIGINT, {}), (signal.SIGTERM, {"release": {"time": 0.5}})])
def test_a_signal_ends_in_order_and_nothing_is_left(here, number, groups):
    here.scene("a", captured_beam(response={"duration": 1.0, "samples": 100_000}, **groups))
    running = here.start("accuracy", "a.nml")
    wait_until((here.directory / "output").exists)
    time.sleep(0.3)
    running.send_signal(number)
    out, err = running.communicate(timeout=SECONDS)
    assert running.returncode == 5, err
    assert out == ""
    assert "the same command" in err
    assert here.left() == []


def test_a_place_that_cannot_be_written_is_said_before_any_work(here):
    here.scene("a", SMALL)
    here.write("file", "no directory")
    ended = here.beamwave("accuracy", "a.nml", "--output", "file/output", status=3)
    assert "file/output" in ended.stderr


def test_a_mode_that_grows_and_would_not_changes_all_of_the_displacement(here):
    ds = here.study("accuracy", "a", captured_beam(rotation={"angular_velocity": 160.0}, modes=None, response=SMALL["response"]))
    assert float(ds.model_error) >= 1.0
    assert ds.beyond_model.all()


def test_points_that_hardly_move_leave_no_tolerance_to_ask_for(here):
    still = {"duration": 1e-15, "samples": 50, "points": 1e-7}
    here.scene("a", captured_beam(modes=None, response=still))
    refused = here.beamwave("run", "a.nml", "--quiet", status=2)  # a log of a slow machine has lines of progress
    assert refused.stderr.startswith("a.nml: modes%tolerance: ")
    assert "nor can any other" in refused.stderr
