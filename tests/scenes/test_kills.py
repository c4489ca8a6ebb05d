"""Finished cases survive kill -9 at any moment, and the same command ends with the bits of an uninterrupted run."""

import os
import random
import re
import shutil
import signal
import time
from pathlib import Path

import pytest
import results
from journals import cases_in
from places import case_places
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
    before = len(list(partial.glob("*.cases")))
    running = here.start("run", "a.nml", "--quiet")
    wait_until(lambda: len(list(partial.glob("*.cases"))) > before or final.exists() or running.poll() is not None)
    time.sleep(dice.uniform(0.0, seconds))
    family = [running.pid, *children(running.pid)]
    victim = dice.choice(family)
    if is_alive(victim):
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


@pytest.fixture(scope="module")
def killed(shared, uninterrupted):
    """A run that was killed: its directory, and the cases that it had finished."""
    place = shared("killed")
    place.scene("a", SCENE, SPEEDS, RATIOS)
    partial = place.directory / "output/a.partial"
    seconds = uninterrupted[2] / 2
    while not (0 < len(cases_in(partial)) < CASES):
        shutil.rmtree(place.directory / "output", ignore_errors=True)
        running = place.start("run", "a.nml", "--quiet")
        wait_until((partial / "000001.cases").exists)
        time.sleep(seconds)
        running.kill()
        running.communicate(timeout=SECONDS)
        seconds /= 2
    return place.directory, cases_in(partial)


def write(path, place, data):
    with path.open("r+b") as file:
        file.seek(place)
        file.write(data)


def kill_between_history_and_record(partial, saved):
    """Cases without a record have histories, whole or half."""
    begin, length = case_places(partial, "displacement")
    for case in set(range(1, CASES + 1)) - saved:
        write(partial / "result.nc", begin + (case - 1) * length, b"\x3c" * (length // 2 if case % 2 else length))
    return 0


def kill_while_the_end_is_written(partial, _):
    """All that is not a case's may be anything then."""
    begin, _ = case_places(partial, "displacement")
    write(partial / "result.nc", 0, b"half a head" * (begin // 11))
    return 0


def kill_while_the_head_is_written(partial, _):
    (partial / "head.nc").rename(partial / "head.nc.new")
    write(partial / "head.nc.new", 0, b"nothing yet")
    (partial / "000001.cases").unlink()
    return "all"


def kill_while_a_record_is_written(partial, _):
    journal = partial / "000001.cases"
    os.truncate(journal, journal.stat().st_size - 3)
    return 1


def damage_one_history(partial, saved):
    """One bit, as after a crash of the machine or of a disk."""
    begin, length = case_places(partial, "displacement")
    place = begin + (min(saved) - 1) * length + length // 3
    byte = (partial / "result.nc").read_bytes()[place]
    write(partial / "result.nc", place, bytes([byte ^ 16]))
    return 1


def lose_the_last_pages(partial, saved):
    """The machine crashed before the disk had all."""
    begin, length = case_places(partial, "displacement")
    os.truncate(partial / "result.nc", begin + (max(saved) - 2) * length)
    return sum(case >= max(saved) - 1 for case in saved)


def remove_the_result(partial, _):
    (partial / "result.nc").unlink()
    return "all"


def leave_another_layout(partial, _):
    """Another scene's, which lay there."""
    shutil.copy(partial.parents[1] / "other/a.partial/head.nc", partial / "head.nc")
    return "all"


@pytest.mark.parametrize(
    "harm",
    [
        kill_between_history_and_record,
        kill_while_the_end_is_written,
        kill_while_the_head_is_written,
        kill_while_a_record_is_written,
        damage_one_history,
        lose_the_last_pages,
        remove_the_result,
        leave_another_layout,
    ],
)
def test_what_a_kill_or_a_crash_can_leave_is_told_from_what_is_done(here, uninterrupted, killed, harm):
    whole, status, _ = uninterrupted
    directory, saved = killed
    shutil.copytree(directory, here.directory, dirs_exist_ok=True)
    if harm is leave_another_layout:
        here.scene("a", {**SCENE, "response": {"duration": 4.0, "samples": 2048}}, SPEEDS, RATIOS)
        assert here.beamwave("run", "a.nml", "--output", "other", "--max-seconds", "0.1").returncode == 5
    here.scene("a", SCENE, SPEEDS, RATIOS)
    lost = harm(here.directory / "output/a.partial", saved)
    left = 0 if lost == "all" else len(saved) - lost
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == status, ended.stderr
    taken = re.search(r"(\d+) cases were taken over from an earlier run", ended.stdout)
    assert (int(taken[1]) if taken else 0) == left
    is_told = f"{len(saved) - left} finished cases of an earlier run were not as it had left them" in ended.stderr
    assert is_told == (lost != 0 and harm not in [kill_while_a_record_is_written, kill_while_the_head_is_written])
    assert results.differences(here.result("a"), whole) == []
