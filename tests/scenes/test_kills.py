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
from drafts import cases_in, files_in
from ring_downs import text_of
from workplace import SECONDS, captured_beam, wait_until

CASES = 400
SCENE = captured_beam(modes={"before": 30, "after": 30}, response={"duration": 4.0, "samples": 1024})
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 150.0, "last": 0.0, "count": CASES // 8}
RATIOS = {"parameter": "impact%mass_ratio", "first": 0.1, "last": 1.0, "count": 8}
RECORDS = 12
STARTS = {"parameter": "record%start", "values": [0.0, 0.05, 0.1]}
KILLS = int(os.environ.get("BEAMWAVE_KILLS", "12"))  # in each situation
SEED = int(os.environ.get("BEAMWAVE_SEED", "20261121"))


def write(here, what):
    """The scene, and the records that it reads."""
    if what == "sweep":
        here.scene("a", SCENE, SPEEDS, RATIOS)
        return
    for number in range(RECORDS):
        here.write(f"{number}.csv", text_of(number, samples=400))
    here.scene("a", {"record": {"file": [f"{number}.csv" for number in range(RECORDS)]}, "spectrum": {}}, STARTS)


@pytest.fixture(scope="module")
def uninterrupted(shared):
    """The results, their exit status, and how long they took: slow builds are killed as far on as fast ones."""
    made = {}
    for what in ("sweep", "records"):
        place = shared(what)
        write(place, what)
        began = time.perf_counter()
        ended = place.beamwave("run", "a.nml", "--quiet")
        made[what] = place.result("a"), ended.returncode, time.perf_counter() - began
    return made


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


def start(here, words):
    """A command for each, all at once."""
    return [here.start("run", "a.nml", "--quiet", *more) for more in words]


def kill_at_random(here, dice, seconds, words):
    """Run, and kill a process of the run after up to so many seconds of work. True if it came in time."""
    partial, final = here.directory / "output/a.partial", here.directory / "output/a.nc"
    before = locks_in(partial)
    running = start(here, words)
    wait_until(lambda: locks_in(partial) - before or final.exists() or any(one.poll() is not None for one in running))
    time.sleep(dice.uniform(0.0, seconds))
    family = [process for one in running for process in (one.pid, *children(one.pid))]
    victim = dice.choice(family)
    with contextlib.suppress(ProcessLookupError):  # a process may end by itself before it is struck
        os.kill(victim, signal.SIGKILL)
    if len(running) > 1:
        for one in running:  # the other part ends with all of its own
            one.communicate(timeout=SECONDS)
    running[0].communicate(timeout=SECONDS)
    wait_until(lambda: not any(map(is_alive, family)))
    return not final.exists()


def locks_in(partial):
    """The locks that runs have taken there, each a file of its own."""
    locks = set()
    for path in files_in(partial, "lock"):
        with contextlib.suppress(FileNotFoundError):
            locks.add(path.stat().st_ino)
    return locks


SITUATIONS = {
    "one process": ("sweep", 1, [()]),
    "two processes": ("sweep", 2, [()]),
    "a part alone": ("sweep", 1, [("--part", "2/3")]),
    "two parts": ("sweep", 1, [("--part", "1/2"), ("--part", "2/2")]),
    "records": ("records", 1, [()]),
}


@pytest.mark.parametrize("situation", SITUATIONS)
def test_no_finished_case_is_lost_by_a_kill(processes, uninterrupted, situation):
    what, number, words = SITUATIONS[situation]
    whole, status, seconds = uninterrupted[what]
    here = processes(number)
    dice = random.Random(f"{SEED} {situation}")
    print(f"seed {SEED}, {situation}, an uninterrupted run takes {seconds:.2f} s")
    write(here, what)
    kills = 0
    while kills < KILLS:
        saved = set()
        # a part of the run at a time, so that several kills fall into one run, its first and its last cases
        while kills < KILLS and kill_at_random(here, dice, seconds * dice.choice([0.05, 0.2, 0.5]) / number, words):
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
