"""A run that is stopped keeps its finished cases, and the same command ends with what an uninterrupted run gives."""

import shutil
import signal
import time

import pytest
import results
from drafts import cases_in, drafts_in
from workplace import ENDLESS, RATIOS, SECONDS, captured_beam, wait_until

SPEEDS = {"parameter": "rotation%angular_velocity", "first": 300.0, "last": 0.0, "count": 900}
LONG = captured_beam(modes={"before": 1000, "after": 1000}, response={"duration": 8.0, "samples": 1024})
STATUS = 4  # the fastest cases, which come first, overflow


def timed(place):
    """A run from its beginning, and its seconds: the shorter of two, since a busy machine only makes them longer."""
    seconds = []
    for directory in ["first", "second"]:
        began = time.perf_counter()
        ended = place.beamwave("run", "a.nml", "--quiet", "--output", directory)
        seconds.append(time.perf_counter() - began)
        assert ended.returncode in (0, STATUS)
    return place.result("a", "first"), min(seconds)


@pytest.fixture(scope="module")
def uninterrupted(shared):
    """The result, and how long it took: slow builds are stopped as far on as fast ones."""
    place = shared("uninterrupted")
    place.scene("a", LONG, SPEEDS)
    return timed(place)


def wait_for_work(here):
    """Until a first case is saved, or all are."""
    wait_until(lambda: cases_in(here.directory / "output/a.partial") or (here.directory / "output/a.nc").exists())


def has_draft(here):
    return "a.partial/draft.nc" in here.left()


def send(here, number, seconds, *words):
    """Run, send a signal so long after the work began, and wait for the end. A run that was faster than that, as where
    other work has just ended, is begun anew and stopped sooner."""
    result = here.directory / "output/a.nc"
    for part in (1, 0.25, 0.0625, 0):
        shutil.rmtree(result.parent, ignore_errors=True)
        running = here.start("run", "a.nml", *words)
        wait_for_work(here)
        time.sleep(part * seconds)
        running.send_signal(number)
        out, err = running.communicate(timeout=SECONDS)
        if not result.exists():
            break
    return running.returncode, out, err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGUSR1, signal.SIGHUP, signal.SIGXCPU])
def test_a_signal_stops_in_order_and_the_same_command_goes_on(here, uninterrupted, number):
    whole, seconds = uninterrupted
    here.scene("a", LONG, SPEEDS)
    status, _, err = send(here, number, seconds / 4)
    assert status == 5, err
    assert "of 900 cases saved; the same command goes on from there" in err
    assert has_draft(here) and "a.nc" not in here.left()
    resumed = here.beamwave("run", "a.nml", status=STATUS)
    assert "taken over from an earlier run" in resumed.stdout
    assert results.differences(here.result("a"), whole) == []
    assert here.left() == ["a.nc"]


def test_a_time_limit_stops_in_order_as_often_as_it_takes(here, uninterrupted):
    whole, seconds = uninterrupted
    here.scene("a", LONG, SPEEDS)
    for parts in (3, 12, 48):  # a run that is much faster than the one that was timed is begun anew with less time
        shutil.rmtree(here.directory / "output", ignore_errors=True)
        statuses = []
        while not statuses or (statuses[-1] == 5 and len(statuses) < 50):
            limit = seconds / parts * 1.1 ** len(statuses)  # grows, lest a busy machine finish no case in it
            statuses.append(here.beamwave("run", "a.nml", "--quiet", "--max-seconds", f"{limit:.4f}").returncode)
        if len(statuses) > 1:
            break
    assert len(statuses) > 1
    assert statuses[-1] == STATUS
    assert results.differences(here.result("a"), whole) == []


def test_no_time_at_all_is_a_stop_before_the_first_scene(here):
    here.scene("a", captured_beam())
    ended = here.beamwave("run", "a.nml", "--max-seconds", "0", status=5)
    assert "a.nml" in ended.stderr
    assert here.run("a")["mode_count"] == 10


def test_a_stop_leaves_the_scenes_that_follow_for_later(here, uninterrupted):
    here.scene("a", LONG, SPEEDS)
    here.scene("b", captured_beam())
    status, _, err = send(here, signal.SIGTERM, uninterrupted[1] / 4, "b.nml")
    assert status == 5
    assert "b.nml" in err
    assert "b.nc" not in here.left()


def test_a_case_under_way_can_be_stopped(here):
    here.scene(
        "a", captured_beam(modes={"before": 400, "after": 400}, response={"duration": 1.0, "samples": 2_000_000})
    )
    ended = here.beamwave("run", "a.nml", "--max-seconds", "0.03", status=5)  # no build sums these histories in that
    assert "a.nml" in ended.stderr
    assert "a.nc" not in here.left(".")


@pytest.mark.parametrize("command", ["accuracy", "effects"])
def test_a_study_stops_in_a_long_stage(here, command):
    """The jump along the beam, and the growth of modes; each would take hours."""
    jump = captured_beam(
        modes={"before": 100_000, "after": 100_000},
        impact={"mass_ratio": 0.2, "profile_points": 10**6},
        response={"duration": 0.01, "samples": 10},
    )
    growth = captured_beam(modes=None, rotation={"angular_velocity": 1e13}, response={"duration": 1e-11, "samples": 10**7})
    growth["modes"] = {"tolerance": 0.01}
    here.scene("a", jump if command == "effects" else growth)
    running = here.start(command, "a.nml")
    time.sleep(0.5)
    running.send_signal(signal.SIGTERM)
    _, err = running.communicate(timeout=SECONDS)
    assert running.returncode == 5, err
    assert here.left() == []


def test_a_check_stops_between_its_scenes_and_within_them(here):
    long = {**captured_beam(shear={}, response={"duration": 0.05, "samples": 1000}), "modes": {"tolerance": 1e-4}}
    for i in range(100):  # about half a second each
        here.scene(f"scenes/{i}", long)
    running = here.start("check", "scenes")
    time.sleep(0.5)
    running.send_signal(signal.SIGTERM)
    _, err = running.communicate(timeout=SECONDS)
    assert running.returncode == 5, err
    assert "was checked" in err


@pytest.mark.parametrize("part", [0.1, 0.3])
def test_what_a_killed_run_leaves_never_blocks(here, uninterrupted, part):
    whole, seconds = uninterrupted
    here.scene("a", LONG, SPEEDS)
    assert send(here, signal.SIGKILL, part * seconds)[0] == -signal.SIGKILL
    assert has_draft(here) and "a.nc" not in here.left()
    assert results.differences(here.run("a", status=STATUS), whole) == []


def test_what_a_killed_run_had_saved_is_right(here):
    many = {"parameter": "impact%mass_ratio", "first": 0.1, "last": 1.0, "count": 2500}
    here.scene("a", captured_beam(modes={"before": 5, "after": 5}), many)
    whole, seconds = timed(here)
    assert send(here, signal.SIGKILL, 0.6 * seconds)[0] == -signal.SIGKILL
    here.beamwave("run", "a.nml", status=0)
    assert results.differences(here.result("a"), whole) == []


def leave_rubbish(path):
    path.write_bytes(b"no NetCDF file" * 100)


def leave_half_a_file(path):
    path.write_bytes((path.parents[1] / "older.nc").read_bytes()[:5000])


def leave_another_scene(path):
    path.write_bytes((path.parents[1] / "older.nc").read_bytes())


@pytest.mark.parametrize("leave", [leave_rubbish, leave_half_a_file, leave_another_scene])
def test_unfinished_work_that_is_no_use_is_discarded(here, leave):
    here.scene("older", captured_beam(impact={"mass_ratio": 0.7}))
    here.scene("a", captured_beam())
    here.run("older")
    (here.directory / "output/a.partial").mkdir()
    leave(here.directory / "output/a.partial/draft.nc")
    assert here.run("a")["impact_mass_ratio"] == 0.2
    assert here.left() == ["a.nc", "older.nc"]


@pytest.mark.parametrize("what", ["output", "output/a.partial", "the draft"])
def test_work_that_vanishes_ends_the_run_soon_and_is_not_said_to_be_saved(here, what):
    here.scene("a", ENDLESS, RATIOS)
    running = here.start("run", "a.nml")
    wait_for_work(here)
    (draft,) = drafts_in(here.directory / "output/a.partial")
    gone = draft if what == "the draft" else here.directory / what
    shutil.rmtree(gone) if gone.is_dir() else gone.unlink()
    _, err = running.communicate(timeout=SECONDS)
    assert running.returncode == 3
    assert f"{draft.relative_to(here.directory)}: is gone" in err
    assert "0 of 20000 cases are saved; the same command begins anew" in err
