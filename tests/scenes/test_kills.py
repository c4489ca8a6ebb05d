"""Finished cases survive kill -9 at any moment, and the same command ends with the bits of an uninterrupted run."""

import contextlib
import os
import random
import re
import signal
import time
from pathlib import Path

import pytest
import results
from journals import cases_in, journals_in
from workplace import SECONDS, captured_beam

CASES = 400
SCENE = captured_beam(modes={"before": 30, "after": 30}, response={"duration": 4.0, "samples": 1024})
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 150.0, "last": 0.0, "count": CASES // 8}
RATIOS = {"parameter": "impact%mass_ratio", "first": 0.1, "last": 1.0, "count": 8}
KILLS = 25  # with each number of processes
SEED = int(os.environ.get("BEAMWAVE_SEED", "20261121"))


@pytest.fixture(scope="module")
def uninterrupted(shared):
    """The result, its exit status, and how long it took: slow builds are killed as far on as fast ones."""
    place = shared("uninterrupted")
    place.scene("a", SCENE, SPEEDS, RATIOS)
    began = time.perf_counter()
    ended = place.beamwave("run", "a.nml", "--quiet")
    return place.result("a"), ended.returncode, time.perf_counter() - began


def children(process):
    """Process ids of the processes that this one has started; none where it is gone."""
    try:
        text = Path(f"/proc/{process}/task/{process}/children").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return []
    return [int(word) for word in text.split()]


def is_alive(process):
    """Whether a process runs: what nobody has waited for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def wait_until(is_so):
    until = time.perf_counter() + SECONDS
    while not is_so():
        assert time.perf_counter() < until
        time.sleep(0.002)


def kill_at_random(here, dice, seconds):
    """Run, and kill a process of the run after up to so many seconds of work. True if it came in time."""
    partial, final = here.directory / "output/a.partial", here.directory / "output/a.nc"
    before = len(journals_in(partial))
    running = here.start("run", "a.nml", "--quiet")
    wait_until(lambda: len(journals_in(partial)) > before or final.exists() or running.poll() is not None)
    time.sleep(dice.uniform(0.0, seconds))
    family = [running.pid, *children(running.pid)]
    victim = dice.choice(family)
    with contextlib.suppress(ProcessLookupError):  # a process may end by itself before it is struck
        os.kill(victim, signal.SIGKILL)
    running.communicate(timeout=SECONDS)
    wait_until(lambda: not any(map(is_alive, family)))
    return not final.exists()


@pytest.mark.parametrize("number", [1, 2])
def test_no_finished_case_is_lost_by_a_kill(processes, uninterrupted, number):
    whole, status, seconds = uninterrupted
    here = processes(number)
    dice = random.Random(f"{SEED} {number}")
    print(f"seed {SEED}, {number} processes, an uninterrupted run takes {seconds:.2f} s")
    here.scene("a", SCENE, SPEEDS, RATIOS)
    kills = 0
    while kills < KILLS:
        saved = set()
        # a part of the run at a time, so that several kills fall into one run, its first and its last cases
        while kills < KILLS and kill_at_random(here, dice, seconds * dice.choice([0.05, 0.2, 0.5]) / number):
            kills += 1
            now = cases_in(here.directory / "output/a.partial")
            assert now >= saved
            saved = now
        ended = here.beamwave("run", "a.nml")
        assert ended.returncode in ([status, 0] if not saved else [status]), ended.stderr
        if saved and "nothing to do" not in ended.stdout:
            taken = re.search(r"(\d+) cases were taken over from an earlier run", ended.stdout)
            assert int(taken[1]) == len(saved)
        assert results.differences(here.result("a"), whole) == []
        assert here.left() == ["a.nc"]
        (here.directory / "output/a.nc").unlink()
