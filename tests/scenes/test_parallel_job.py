"""Job scripts without Slurm. jobs/parallel.sh shares a sweep out by GNU parallel: the bits of one run, its worst status, and an order to
stop that saves. Those for arrays say that they are no task of one."""

import os
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest
import results
from conftest import PROJECT
from drafts import cases_in
from workplace import ENDLESS, RATIOS, SECONDS, captured_beam

SPEEDS = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 100.0, "count": 11}


@pytest.fixture
def start(here):
    """Starts the script on three cores that a job would have."""
    if shutil.which("parallel") is None:
        pytest.skip("no GNU parallel here")
    programs = here.directory / "programs"
    programs.mkdir()
    (programs / "beamwave").symlink_to(here.program)
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "SLURM_CPUS_PER_TASK": "3"}
    return lambda *words: subprocess.Popen(
        [shutil.which("bash"), PROJECT / "jobs/parallel.sh", *words], cwd=here.directory, env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def test_the_result_is_that_of_one_run_whatever_the_names(here, start):
    name = 'it\'s a $(touch x) "sweep"'
    here.scene("whole", captured_beam(), SPEEDS)
    here.scene(name, captured_beam(), SPEEDS)
    whole = here.run("whole")
    said = start(f"{name}.nml", "--output", "two words").communicate(timeout=SECONDS)[1]
    shared = results.read(here.directory / "two words" / f"{name}.nc")
    assert np.array_equal(shared["angular_frequency"], whole["angular_frequency"]), said
    assert not (here.directory / "x").exists()


@pytest.mark.parametrize("name", ["array", "parts"])
def test_scripts_for_arrays_say_so_outside_of_one(here, name):
    environment = {name: value for name, value in os.environ.items() if not name.startswith("SLURM_")}
    ended = subprocess.run([PROJECT / f"jobs/{name}.sh", "a.nml"], cwd=here.directory, env=environment, text=True, capture_output=True)
    assert ended.returncode == 2
    assert ended.stderr.startswith(f"{name}.sh: this is no task of an array; submit it by sbatch --array=1-20")


def test_the_status_is_the_highest_of_a_part(here, start):
    here.write("bad.nml", "&beam length=0 /\n")
    started = start("bad.nml")
    assert "beam%length" in started.communicate(timeout=SECONDS)[1]
    assert started.returncode == 2


def test_an_order_to_stop_saves_what_is_finished(here, start):
    here.scene("a", ENDLESS, RATIOS)
    started = start("a.nml", "--quiet")
    draft, deadline = here.directory / "output/a.partial/draft.nc", time.monotonic() + SECONDS
    while not draft.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    time.sleep(3.0)
    started.send_signal(signal.SIGUSR1)
    said = started.communicate(timeout=SECONDS)[1]
    assert started.returncode == 5, said
    assert cases_in(draft.parent)
