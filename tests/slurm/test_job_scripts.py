"""Each script of jobs/ does on a Slurm what its head says, and the job's state tells the truth."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import results
from ring_downs import FREQUENCY, text_of
from slurm import PROJECT, TESTS, needs_mpi
from workplace import captured_beam, wait_until

SPEED = "rotation%angular_velocity"
RESPONSE = {"duration": 1.0, "samples": 4096}
SOME = {"parameter": SPEED, "first": 0.0, "last": 100.0, "count": 8}
PROBE, LONG = 50, 8.0  # cases that are timed, start-up being a small part, and the seconds that a long run is to take
PART = 58  # s that a run of continue.sh has to spare: of the minute that Slurm gives at least, it uses two seconds
SINGLE, ARRAY, PARTS, MPI, RECORDS, CONTINUE, POSTPROCESS = (
    PROJECT / f"jobs/{name}.sh" for name in ["single", "array", "parts", "mpi", "records", "continue", "postprocess"]
)


def log(place, job, name="beamwave"):
    return (place.directory / f"{name}-{job}.log").read_text()


def sweep_of(count):
    """The sweep over so many speeds that takes long."""
    waves = {"response": {"duration": 0.25, "samples": 1024}, "spectrum": {}}  # long to find, small in a file
    scene = captured_beam(modes={"before": 20, "after": 20}, **waves)
    return scene, {"parameter": SPEED, "first": 0.0, "last": 100.0, "count": count}


@pytest.fixture(scope="module")
def uninterrupted(shared):
    """A sweep that takes some seconds in this build, and its result."""
    place = shared("uninterrupted")
    place.scene("probe", *sweep_of(PROBE))
    place.scene("long", *sweep_of(int(PROBE * LONG / min(seconds_of(place, "probe") for _ in range(3)))))
    place.run("long")
    return place


def seconds_of(place, name):
    """Processor time of a run from its beginning, which other work on the machine changes least."""
    before = os.times()
    place.run(name, "--overwrite")
    shutil.rmtree(place.directory / "output")
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


@pytest.fixture(scope="module", autouse=True)
def near_its_limit(jobs, shared, uninterrupted):
    """A run that does not end within the shortest time limit, submitted first: Slurm looks at limits now and then."""
    place = shared("near its limit")
    place.scene("long", *sweep_of(5000))
    return place, jobs.submit(place, "--time=1", SINGLE, "long.nml")


@pytest.fixture(scope="module", autouse=True)
def post_processed(jobs, shared):
    """A run and the post-processing that depends on it, submitted early: pictures take their time."""
    place = shared("post-processed")
    waves = {"response": {"duration": 0.25, "samples": 16384}, "spectrum": {"max_peaks": 5}}
    place.scene("a b", captured_beam(modes={"before": 20, "after": 20}, **waves))
    run = jobs.submit(place, SINGLE, "a b.nml")
    return place, jobs.submit(place, f"--dependency=afterok:{run}", POSTPROCESS, "output/a b.nc")


@pytest.fixture
def sweep(here, uninterrupted):
    """The directory of a test, with the scene of the sweep."""
    shutil.copy(uninterrupted.directory / "long.nml", here.directory)
    return here


def is_under_way(place):
    """Wait until a run has begun to save, and longer."""
    wait_until(lambda: list(place.directory.glob("output/long.partial/*")))
    time.sleep(0.5)


def test_a_single_run_gives_what_it_gives_without_slurm(jobs, here):
    here.scene("a scene", captured_beam(response=RESPONSE))
    assert jobs.ended(here, SINGLE, "a scene.nml", "--output", "by Slurm")[1] == ("COMPLETED", 0)
    assert results.differences(here.result("a scene", "by Slurm"), here.run("a scene")) == []


def test_a_bad_scene_is_a_failed_job_whose_log_says_why(jobs, here):
    here.scene("bad", captured_beam(beam={"length": -1.0}))
    job, state = jobs.ended(here, SINGLE, "bad.nml")
    assert state == ("FAILED", 2)
    assert "bad.nml:2: beam%length" in log(here, job)


def test_an_array_shares_out_a_directory_and_shows_which_task_had_a_bad_scene(jobs, here):
    for ratio in [1, 2, 3, 4, 5]:
        here.scene(f"scenes/mass {ratio}", captured_beam(impact={"mass_ratio": ratio / 10}))
    here.scene("scenes/mass 2", captured_beam(impact={"mass_ratio": -1.0}))
    job, _ = jobs.ended(here, "--array=1-3", ARRAY, "scenes")
    assert jobs.states(job) == [("COMPLETED", 0), ("FAILED", 2), ("COMPLETED", 0)]
    assert here.left() == [f"mass {ratio}.nc" for ratio in [1, 3, 4, 5]]
    assert "mass 2.nml:" in log(here, f"{job}_2")

    here.scene("scenes/mass 2", captured_beam(impact={"mass_ratio": 0.2}))
    job, _ = jobs.ended(here, "--array=1-3", ARRAY, "scenes")
    assert jobs.states(job) == 3 * [("COMPLETED", 0)]
    assert "nothing to do" in log(here, f"{job}_1")
    assert here.result("mass 2")["impact_mass_ratio"] == 0.2


def test_an_array_with_gaps_or_without_scenes_is_refused(jobs, here):
    here.scene("scenes/a", captured_beam())
    job, _ = jobs.ended(here, "--array=1,3", ARRAY, "scenes")
    assert jobs.states(job) == 2 * [("FAILED", 2)]
    assert "without gaps" in log(here, f"{job}_3")
    job, _ = jobs.ended(here, "--array=1-1", ARRAY, "nowhere")
    assert jobs.states(job) == [("FAILED", 2)]
    assert "no such scenes: nowhere/*.nml" in log(here, f"{job}_1")
    assert not (here.directory / "output").exists()


def test_an_array_shares_out_a_sweep(jobs, here):
    here.scene("a", captured_beam(response=RESPONSE), SOME)
    job, _ = jobs.ended(here, "--array=2-4", PARTS, "a.nml", "--output", "by parts")
    assert jobs.states(job) == 3 * [("COMPLETED", 0)]
    assert results.differences(here.result("a", "by parts"), here.run("a")) == []
    job, _ = jobs.ended(here, "--array=1,3", PARTS, "a.nml", "--output", "by parts")
    assert jobs.states(job) == 2 * [("FAILED", 2)]
    assert "without gaps" in log(here, f"{job}_3")


def test_a_sweep_over_ranks_has_the_bits_of_one_process(jobs, here):
    needs_mpi(jobs)
    here.scene("a", captured_beam(response=RESPONSE), SOME)
    assert jobs.ended(here, "--ntasks=2", MPI, "a.nml", "--output", "by ranks")[1] == ("COMPLETED", 0)
    assert results.differences(here.result("a", "by ranks"), here.run("a")) == []


def test_a_directory_of_records_is_one_result(jobs, here):
    needs_mpi(jobs)
    for seed in [1, 2, 3]:
        here.write(f"the rings/it's {seed}.csv", text_of(seed))
    here.write("ask.nml", "&record\n  quantity = 'acceleration'\n/\n&spectrum /\n")
    assert jobs.ended(here, "--ntasks=2", RECORDS, "ask.nml", "the rings")[1] == ("COMPLETED", 0)
    assert here.result("ask")["record_file"].tolist() == [1, 2, 3]
    assert (here.result("ask")["peak_count"] == FREQUENCY.size).all()


def test_a_sweep_over_ranks_that_is_asked_to_stop_goes_on_from_there(jobs, sweep, uninterrupted):
    needs_mpi(jobs)
    job = jobs.submit(sweep, "--ntasks=2", MPI, "long.nml")
    is_under_way(sweep)
    jobs.call("scancel", "--batch", "--signal=USR1", job)
    jobs.wait(job)
    assert jobs.states(job) == [("FAILED", 5)], log(sweep, job)
    assert jobs.ended(sweep, "--ntasks=2", MPI, "long.nml")[1] == ("COMPLETED", 0)
    assert results.differences(sweep.result("long"), uninterrupted.result("long")) == []


@pytest.mark.parametrize("words", [["beamwave"], ["mpirun", "beamwave-mpi"]], ids=["one process", "ranks"])
def test_a_run_that_is_longer_than_its_limit_continues_until_it_is_done(jobs, sweep, uninterrupted, words):
    tasks = len(words)
    if tasks > 1:
        needs_mpi(jobs)
    command = [CONTINUE, *words, "run", "long.nml"]
    job = jobs.submit(sweep, "--time=1", f"--ntasks={tasks}", *command, BEAMWAVE_MARGIN=str(PART))
    after = jobs.submit(sweep, f"--dependency=afterok:{job}", "--wrap", "test -e output/long.nc")
    jobs.wait(job)
    assert jobs.states(job) == [("COMPLETED", 0)], log(sweep, job)
    restarts = int(jobs.tasks(job)[0]["Restarts"])
    assert restarts >= 2 // tasks
    assert log(sweep, job).count("the same command goes on from there") == restarts
    assert results.differences(sweep.result("long"), uninterrupted.result("long")) == []
    jobs.wait(after)
    assert jobs.states(after) == [("COMPLETED", 0)]


def test_a_run_that_never_ends_is_given_up(jobs, sweep):
    limits = {"BEAMWAVE_MARGIN": str(PART), "BEAMWAVE_RESTARTS": "0"}
    job, state = jobs.ended(sweep, "--time=1", CONTINUE, "beamwave", "run", "long.nml", **limits)
    assert state == ("FAILED", 5)
    assert "not done after 0 restarts" in log(sweep, job)


def test_a_time_limit_within_the_margin_is_refused(jobs, here):
    job, state = jobs.ended(here, "--time=1", CONTINUE, "beamwave", "run", "a.nml")
    assert state == ("FAILED", 2)
    assert "longer than the margin of 120 s" in log(here, job)


@pytest.mark.parametrize("script", [SINGLE, CONTINUE], ids=lambda script: script.stem)
def test_a_cancelled_run_stays_cancelled_and_the_same_command_goes_on(jobs, sweep, uninterrupted, script):
    words = ["long.nml"] if script == SINGLE else ["beamwave", "run", "long.nml"]
    job = jobs.submit(sweep, "--time=5", script, *words)
    is_under_way(sweep)
    jobs.call("scancel", job)
    jobs.wait(job, "CANCELLED")
    wait_until(lambda: "the same command goes on from there" in log(sweep, job))
    assert jobs.tasks(job)[0]["Restarts"] == "0"
    again, state = jobs.ended(sweep, SINGLE, "long.nml")
    assert state == ("COMPLETED", 0)
    assert "taken over from an earlier run" in log(sweep, again)
    assert results.differences(sweep.result("long"), uninterrupted.result("long")) == []


def test_post_processing_does_not_follow_a_run_that_failed(jobs, here):
    here.scene("bad", captured_beam(beam={"length": -1.0}))
    run = jobs.submit(here, SINGLE, "bad.nml")
    job = jobs.submit(here, f"--dependency=afterok:{run}", "--kill-on-invalid-dep=yes", POSTPROCESS, "output/bad.nc")
    jobs.wait(job, "CANCELLED")


def test_the_spectral_post_processing_follows_the_run_it_depends_on(jobs, post_processed):
    place, job = post_processed
    jobs.wait(job)
    said = log(place, job, "postprocess")
    assert jobs.states(job) == [("COMPLETED", 0)], said
    assert {"output/a b_spectrum.png", "output/a b_measured_wavenumber.png"} <= set(said.splitlines())
    table = (place.directory / "output/a b_peaks.csv").read_text().splitlines()
    assert len(table) == 1 + place.result("a b")["peak_count"]


def test_slurm_stops_a_run_in_order_before_its_time_limit(jobs, near_its_limit):
    place, job = near_its_limit
    jobs.wait(job)
    assert jobs.states(job) == [("FAILED", 5)]
    assert "the same command goes on from there" in log(place, job)
    assert "long.partial" in place.left() and "long.nc" not in place.left()


STARTS_AND_WAITS = """
import os, sys, time
sys.path.insert(0, sys.argv[1])
from slurm import Jobs, Slurm
with Slurm() as slurm:
    jobs = Jobs({**os.environ, "SLURM_CONF": str(slurm.configuration)})
    jobs.call("sbatch", "--output=/dev/null", "--wrap", "sleep 1234")
    print(slurm.directory, flush=True)
    time.sleep(1000)
"""


def processes_that_name(text):
    """Command lines of running processes that hold the text."""
    found = []
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            named = text.encode() in path.read_bytes() + path.with_name("cmdline").read_bytes()
        except OSError:  # gone, or of another user
            continue
        if named:
            found.append(path.with_name("cmdline").read_bytes())
    return found


def test_nothing_is_left_of_slurm_when_a_test_is_killed():
    command = [sys.executable, "-c", STARTS_AND_WAITS, str(TESTS)]
    test = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    directory = Path(test.stdout.readline().strip())
    assert directory.exists()
    assert len(processes_that_name(str(directory))) >= 4
    test.send_signal(signal.SIGKILL)
    test.wait()
    wait_until(lambda: not processes_that_name(str(directory)) and not directory.exists())
