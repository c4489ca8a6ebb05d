"""Processes that share a sweep give the bits of one, whoever does which case; only one of them speaks."""

import re
import signal

import pytest
import results
from drafts import cases_in, wait_for_cases
from mounts import in_own_mounts
from workplace import ENDLESS, RATIOS, SECONDS, captured_beam

SCENE = captured_beam(modes={"before": 30, "after": 30}, response={"duration": 0.5, "samples": 1024})
SPEEDS = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": 40}
COUNTS = {"parameter": "modes%after", "values": [30, 4, 17]}
LONG = {**SPEEDS, "count": 6000}
DIVERGING = {**SPEEDS, "first": 300.0, "last": 0.0}


def stopped_early(here, *words):
    """Stop the long sweep after a while; the numbers of its finished cases, of which there is one even on a busy machine."""
    here.scene("a", SCENE, LONG)
    for tenths in range(2, 40):  # steps shorter than the sweep takes on two quick processes
        ended = here.beamwave("run", "a.nml", "--max-seconds", str(tenths / 10), *words, status=5)
        saved = cases_in(here.directory / "output/a.partial")
        assert f"stopped with {len(saved)} of {LONG['count']} cases saved; the same command goes on from there" in ended.stderr
        if saved:
            break
    return saved


@pytest.fixture(scope="module")
def alone(shared):
    """What one process gives."""
    place = shared("alone")
    place.scene("a", SCENE, SPEEDS, COUNTS)
    place.scene("one", SCENE)
    place.scene("b", captured_beam(response={"duration": 20.0, "samples": 512}), DIVERGING)
    place.beamwave("run", "a.nml", "one.nml", "b.nml")
    return place


@pytest.fixture(scope="module")
def uninterrupted(shared):
    """The long sweep by one process."""
    place = shared("uninterrupted")
    place.scene("a", SCENE, LONG)
    assert place.beamwave("run", "a.nml").returncode == 0
    return place


@pytest.mark.parametrize("number", [2, 3])
def test_any_number_of_processes_gives_the_same_bits(processes, alone, number):
    here = processes(number)
    here.beamwave("run", *(alone.directory / f"{name}.nml" for name in ["a", "one", "b"]), status=4)
    for name in ["a", "one", "b"]:
        assert results.differences(here.result(name), alone.result(name)) == []
    assert here.left() == ["a.nc", "b.nc", "one.nc"]
    again = here.beamwave("run", alone.directory / "a.nml")
    assert (again.returncode, again.stdout.count("nothing to do")) == (0, 1)


def test_only_one_process_speaks(processes):
    here = processes(3)
    assert here.beamwave("--version").stdout.count("compiler") == 1
    assert here.beamwave("describe", "beam").stdout.count("## &beam") == 1
    here.write("bad.nml", "&beam length = -1 /\n")
    ended = here.beamwave("run", "bad.nml", status=2)
    assert ended.stderr.count("bad.nml:1: beam%length") == 1
    assert here.beamwave("walk").returncode == 2


@pytest.mark.parametrize(("first", "second"), [(2, 1), (1, 2), (2, 3)])
def test_work_goes_on_with_another_number_of_processes(processes, uninterrupted, first, second):
    saved = stopped_early(processes(first))
    here = processes(second)
    ended = here.beamwave("run", "a.nml", status=0)
    assert f"{len(saved)} cases were taken over from an earlier run" in ended.stdout
    assert here.left() == ["a.nc"]
    assert results.differences(here.result("a"), uninterrupted.result("a")) == []


@pytest.mark.parametrize(("number", "statuses"), [(signal.SIGUSR1, [5]), (signal.SIGTERM, range(1, 256))])
def test_a_signal_to_mpirun_saves_what_is_finished(processes, number, statuses):
    here = processes(2)
    here.scene("a", ENDLESS, RATIOS)
    running = here.start("run", "a.nml")
    partial = here.directory / "output/a.partial"
    wait_for_cases(here)
    running.send_signal(number)
    _, err = running.communicate(timeout=SECONDS)
    assert running.returncode in statuses, err
    assert "fault" not in err
    assert cases_in(partial)
    assert not (here.directory / "output/a.nc").exists()


def test_a_full_disk_ends_all_with_3_before_any_work(processes):
    here = processes(2)
    here.scene("a", SCENE, LONG)
    script = """mkdir disk && mount -t tmpfs -o size=1M none disk
    beamwave run a.nml --output disk; status=$?
    find disk -type f; exit $status"""
    ended = in_own_mounts(here, script)
    assert ended.returncode == 3, ended.stderr
    assert len(re.findall(r"disk/a.partial/.*: cannot be written: No space left", ended.stderr)) == 1
    assert ended.stdout == ""


def test_a_disk_that_others_fill_meanwhile_has_kept_the_room(processes, alone):
    here = processes(2)
    quiet = captured_beam(modes={"before": 12, "after": 12}, response={"duration": 0.05, "samples": 1024})
    here.scene("a", quiet, LONG)  # notes of cases have no room of their own
    script = """mkdir disk && mount -t tmpfs -o size=400M none disk
    (until test -s disk/a.partial/draft.nc; do sleep 0.01; done; cat /dev/zero > disk/full 2> /dev/null) &
    beamwave run a.nml --output disk; status=$?
    wait; df --output=avail disk | tail -1; exit $status"""
    ended = in_own_mounts(here, script)
    assert ended.returncode == 0, ended.stderr
    assert int(ended.stdout.split()[-1]) < 100  # kB: those of the lock are free again


def test_a_run_at_work_keeps_a_second_one_out(processes):
    here = processes(2)
    here.scene("a", SCENE, LONG)
    running = here.start("run", "a.nml", "--max-seconds", "20")
    wait_for_cases(here)
    second = processes(1).beamwave("run", "a.nml", status=3)
    assert "another run is at work on this scene" in second.stderr
    running.communicate(timeout=SECONDS)
    assert running.returncode in (0, 5)  # done, or its time was up
