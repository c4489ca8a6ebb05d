"""Whatever a run is at, it ends within about a second of work after it was told to, and a check within ten seconds. By hand
BEAMWAVE_LONG=all takes scenes of every kind and both studies, which takes some minutes."""

import os
import resource
import signal
import time

import long_work
import pytest
from workplace import SECONDS, group_text

ALL = os.environ.get("BEAMWAVE_LONG") == "all"
SCENES = long_work.ALL if ALL else long_work.FEW
ENDS = {0, 2, 4, 5} if ALL else {5}  # some of them are done before
WORK = 2.0  # s of processor time: a second without a look, and what an ending in order takes
CHECK = 10.0  # s


@pytest.fixture(params=SCENES)
def scene(request, here):
    here.scene("a", SCENES[request.param], *long_work.SWEEPS.get(request.param, []))
    if request.param == "many bodies":
        bodies = "".join(group_text("body", {"position": i / 401, "mass": 1e-3}) for i in range(1, 401))
        here.write("a.nml", (here.directory / "a.nml").read_text() + bodies)
    return here


def work_of(process):
    """Seconds of processor time that a running process has taken."""
    fields = open(f"/proc/{process.pid}/stat").read().rsplit(")", 1)[1].split()
    return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


def work_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.parametrize("words", [["run"], ["effects"], ["accuracy"]] if ALL else [["run"]])
def test_a_signal_ends_any_work_soon(scene, words):
    before = work_of_children()
    running = scene.start(*words, "a.nml", "--overwrite")
    time.sleep(1.0)
    told = work_of(running) if running.poll() is None else 0.0
    running.send_signal(signal.SIGTERM)
    _, err = running.communicate(timeout=SECONDS)
    assert running.returncode in ENDS, err
    assert work_of_children() - before - told < WORK


def test_time_that_is_up_ends_any_work_soon(scene):
    before = work_of_children()
    ended = scene.beamwave("run", "a.nml", "--max-seconds", "1")
    assert ended.returncode in ENDS, ended.stderr
    assert work_of_children() - before < 1.0 + WORK


def test_a_check_has_an_end(scene):
    began = time.perf_counter()
    ended = scene.beamwave("check", "a.nml")
    assert ended.returncode in (0, 2), ended.stderr
    assert time.perf_counter() - began < CHECK
    assert ended.returncode == 2 or "memory " in ended.stdout
