"""jobs/records.sh puts the files of a directory into a scene however its &record is written, here without Slurm and MPI."""

import os
import shutil
import subprocess

import pytest
from conftest import PROJECT
from ring_downs import text_of
from workplace import SECONDS

REST = "&spectrum /\n"
SCENES = {
    "on one line": "&record quantity = 'velocity' /\n",
    "empty": "&record/\n",
    "on several lines": "! a comment\n  &Record\n    quantity = 'velocity'\n  /\n",
    "behind a tab, with a comment": "\t&RECORD ! a comment\n  quantity = 'velocity' /\n",
    "with lines of Windows": "&record\r\n  quantity = 'velocity' /\r\n",
}


@pytest.fixture
def submit(here):
    """Runs the script as Slurm would, with stand-ins for mpirun and beamwave-mpi."""
    stand_ins = here.directory / "stand-ins"
    stand_ins.mkdir()
    (stand_ins / "beamwave-mpi").symlink_to(here.program)
    (stand_ins / "mpirun").write_text('#!/bin/sh\nexec "$@"\n')
    (stand_ins / "mpirun").chmod(0o755)
    environment = {**os.environ, "PATH": f"{stand_ins}:{os.environ['PATH']}"}
    command = [shutil.which("bash"), PROJECT / "jobs/records.sh", "scene.nml", "records"]
    return lambda: subprocess.run(command, cwd=here.directory, env=environment, capture_output=True, text=True,
                                  timeout=SECONDS, check=False)  # fmt: skip


@pytest.mark.parametrize("record", SCENES.values(), ids=SCENES.keys())
def test_files_of_a_directory_become_cases(here, submit, record):
    for number in (1, 2):
        here.write(f"records/it's {number}.csv", text_of(number, samples=200))
    here.write("scene.nml", record + REST)
    ended = submit()
    assert ended.returncode == 0, ended.stderr
    assert here.result("scene").sizes["case"] == 2
    assert "nothing to do" in submit().stdout


def test_names_of_any_length_together_are_put_into_the_scene(here, submit):
    """A single argument or variable of a command may have 128 KiB on Linux."""
    names = [f"{number:0200}.csv" for number in range(1000)]
    for name in names:
        here.write(f"records/{name}", "")
    here.write("scene.nml", "&record quantity = 'velocity' /\n" + REST)
    (here.directory / "stand-ins/beamwave-mpi").unlink()
    (here.directory / "stand-ins/beamwave-mpi").symlink_to(shutil.which("true"))
    ended = submit()
    assert ended.returncode == 0, ended.stderr
    files = ", ".join(f"'{name}'" for name in names)
    text = " ".join((here.directory / "records/scene.nml").read_text().split())
    assert text == f"&record file = {files} quantity = 'velocity' / {REST.strip()}"


def test_what_cannot_be_a_scene_of_records_is_refused(here, submit):
    here.write("scene.nml", "&records /\n")
    here.write("records/1.csv", text_of(1))
    ended = submit()
    assert (ended.returncode, ended.stderr) == (2, "records.sh: no line of scene.nml begins with &record\n")
    assert not (here.directory / "records/scene.nml").exists()
