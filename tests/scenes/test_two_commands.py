"""Of two commands for one result at once one runs and the other says so, on file systems with locks and without; there is
never a wrong file. BEAMWAVE_PAIRS sets how many pairs of each kind are started."""

import os
import random
import subprocess
import time

import pytest
import results
from drafts import wait_for_cases
from faults import NO_LOCKS
from workplace import ENDLESS, RATIOS, SECONDS, captured_beam, wait_until

PAIRS = int(os.environ.get("BEAMWAVE_PAIRS", "4"))
SEED = int(os.environ.get("BEAMWAVE_SEED", "20261122"))
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": 40}
SCENE = captured_beam(modes={"before": 20, "after": 20}, response={"duration": 0.2, "samples": 2048})
SAYS_SO = ["another run is at work on this scene", "nothing to do", "a result was put there meanwhile"]


@pytest.mark.parametrize("locks", ["with locks", "without locks"])
@pytest.mark.parametrize("kind", ["sweep", "one case", "effects"])
def test_one_runs_and_the_other_says_so(here, injector, kind, locks):
    here.scene("a", SCENE, *([SPEEDS] if kind == "sweep" else []))
    words = ["effects" if kind == "effects" else "run", "a.nml"]
    result = here.directory / ("output/a.effects.nc" if kind == "effects" else "output/a.nc")
    began = time.perf_counter()
    assert here.beamwave(*words, "--output", "alone").returncode == 0
    seconds = time.perf_counter() - began
    expected = results.read(here.directory / "alone" / result.name)
    if locks == "without locks":
        here.environment = injector.environment(here, NO_LOCKS)
    dice = random.Random(f"{SEED} {kind} {locks}")
    for pair in range(PAIRS):
        result.unlink(missing_ok=True)
        first = here.start(*words)
        time.sleep(dice.choice([0.0, 0.05, dice.uniform(0.0, 1.2 * seconds)]))
        second = here.start(*words)
        ended = [finish(first), finish(second)]
        statuses = sorted(status for status, _ in ended)
        assert statuses in ([0, 0], [0, 3]), (pair, ended)
        assert any(phrase in said for _, said in ended for phrase in SAYS_SO), (pair, ended)
        found = results.read(result)
        if kind != "effects":
            assert results.differences(found, expected) == [], pair
        assert [name for name in here.left() if not name.startswith("alone")] == [result.name], pair


def finish(running):
    out, err = running.communicate(timeout=SECONDS)
    return running.returncode, out + err


def test_what_a_killed_run_left_without_locks_is_taken_over_on_its_host(here, injector):
    here.scene("a", SCENE, SPEEDS)
    ended, _ = injector.run(here, "run", "a.nml", fault="fdatasync:3:kill")  # all are saved, the result has no name
    assert ended.returncode == -9
    here.environment = injector.environment(here, NO_LOCKS)
    assert "cases were taken over" in here.beamwave("run", "a.nml").stdout
    assert here.left() == ["a.nc"]


def test_a_lock_of_another_host_is_told_where_there_is_no_way_to_ask(here, injector):
    here.scene("a", SCENE)
    lock = here.directory / here.write("output/a.partial/lock", "elsewhere 4711 1\n")
    here.environment = injector.environment(here, NO_LOCKS)
    ended = here.beamwave("run", "a.nml", status=3)
    assert "process 4711 on host elsewhere" in ended.stderr
    assert "if it is no longer there, remove this file" in ended.stderr
    lock.unlink()
    assert here.beamwave("run", "a.nml").returncode == 0


def test_a_lock_that_names_no_run_is_called_that(here, injector):
    here.scene("a", SCENE)
    here.write("output/a.partial/lock", "rubbish\n")
    here.environment = injector.environment(here, NO_LOCKS)
    ended = here.beamwave("run", "a.nml", status=3)
    assert "output/a.partial/lock: is a lock that names no run; once no run is at work on this scene, remove it" in ended.stderr


@pytest.mark.parametrize("overwrite", [True, False], ids=["with --overwrite", "without"])
def test_a_result_that_was_put_there_meanwhile_is_replaced_only_if_asked(here, overwrite):
    here.scene("a", ENDLESS, {**RATIOS, "count": 400})
    running = here.start("run", "a.nml", *(["--overwrite"] if overwrite else []))
    wait_for_cases(here)
    result = here.directory / here.write("output/a.nc", "somebody's")
    status, said = finish(running)
    if overwrite:
        assert (status, len(here.result("a")["case"])) == (0, 400)
    else:
        assert status == 3 and "a result was put there meanwhile; --overwrite replaces it" in said
        assert result.read_text() == "somebody's"
        assert "400 of 400 cases are saved; the same command with --overwrite goes on from there" in said
        assert here.beamwave("run", "a.nml", "--overwrite").returncode == 0
        assert len(here.result("a")["case"]) == 400


def test_a_run_whose_lock_is_taken_away_does_not_place_its_result(here):
    here.scene("a", ENDLESS, {**RATIOS, "count": 400})
    running = subprocess.Popen(
        here.command(["run", "a.nml"]), cwd=here.directory, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    lock = here.directory / "output/a.partial/lock"
    wait_until(lock.exists)
    lock.unlink()
    lock.write_text("elsewhere 1 1\n")
    status, said = finish(running)
    assert status == 3
    assert "a.partial/lock: is gone or another run's" in said
    assert "a.nc" not in here.left()
    assert "400 cases were taken over" in here.beamwave("run", "a.nml").stdout
