"""Files that do harm become one line each, within 10 s and 1 GB, and nothing is written; the next file follows."""

import faulthandler
import json
import os
import resource
import signal
import sys
import time
from pathlib import Path

import hostile
import numpy as np
import pytest

from beamwave_postproc import cli
from beamwave_postproc.record import cli as record
from beamwave_postproc.record import readers
from beamwave_postproc.tool import Tool

MOST_SECONDS, MOST_KILOBYTES = 10.0, 10**6


@pytest.fixture(autouse=True)
def silent():
    """What a crash would print of pytest itself."""
    was = faulthandler.is_enabled()
    faulthandler.disable()
    yield
    if was:
        faulthandler.enable(sys.__stderr__)


def left(directory):
    """All that lies in a directory, with what it holds."""
    return {path.name: path.read_bytes() if path.is_file() else None for path in directory.iterdir()}


def seconds_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@pytest.mark.parametrize("file", [*hostile.RECORDS, *hostile.RESULTS], ids=lambda file: file.__name__)
def test_a_hostile_file_is_one_line_and_leaves_nothing(tmp_path, capfd, file):
    path = tmp_path / f"a{hostile.RECORDS.get(file, '.nc')}"
    file(path)
    before, began = left(tmp_path), seconds_of_children()
    assert (cli if path.suffix == ".nc" else record).main([str(path)]) == 3
    out, err = capfd.readouterr()
    assert len(err.splitlines()) == 1 and err.startswith(f"{path}: ") and len(err) < 600
    written = [line.removeprefix(f"{tmp_path}/") for line in out.splitlines()]
    assert {name: text for name, text in left(tmp_path).items() if name not in written} == before
    assert not written or file is hostile.modes_never_written  # whose other pictures are drawn
    assert seconds_of_children() - began < MOST_SECONDS
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < MOST_KILOBYTES


def never_ends():
    while True:
        pass


HARM = {
    "crash": (lambda: os.kill(os.getpid(), signal.SIGSEGV), "reading it ended in signal 11"),
    "abort": (os.abort, "reading it ended in signal 6"),
    "end": (lambda: os._exit(0), ""),
    "endless": (never_ends, "takes far longer"),
    "blocked": (lambda: time.sleep(1000), "takes far longer"),
    "memory": (lambda: np.ones(10**10), "not enough memory"),
    "noise": (lambda: [os.write(number, b"\x1b[31m") for number in (1, 2)] and 1 / 0, "ZeroDivisionError"),
    "words": (lambda: int("\x1b[31m\u202e" * 1000), r"\x1b[31m"),
}


@pytest.mark.parametrize("harm", HARM)
def test_whatever_a_reader_does_the_next_file_is_read(tmp_path, capfd, monkeypatch, harm):
    does, said = HARM[harm]
    monkeypatch.setattr("beamwave_postproc.tool.SECONDS", 0.5)
    monkeypatch.setattr(readers, "numpy_channels", lambda path, wanted: does())
    np.save(tmp_path / "bad.npy", hostile.VALUES)
    hostile.matlab(tmp_path / "good.mat")
    status = record.main([str(tmp_path / "bad.npy"), str(tmp_path / "good.mat")])
    out, err = capfd.readouterr()
    assert (tmp_path / "good.nc").exists() and f"{tmp_path / 'good.nc'}\n" in out
    assert status == (0 if harm == "end" else 3)
    assert said in err and len(err.splitlines()) == (0 if harm == "end" else 1)
    assert "\x1b" not in out + err and "\u202e" not in out + err
    assert len(list(tmp_path.iterdir())) == 3


def shared(tmp_path, monkeypatch, work, count=24):
    """Have three processes share works on a file; the exit status."""
    monkeypatch.setattr("beamwave_postproc.tool.cores", lambda: 3)
    tool = Tool()

    def do():
        found = tool.share(count, work)
        (tmp_path / "found").write_text(json.dumps(found))

    (tmp_path / "a.nc").write_bytes(b"")
    return tool.each([tmp_path / "a.nc"], tmp_path, do)


def test_processes_share_work_of_which_each_part_is_done_once(tmp_path, monkeypatch):
    def work(numbers):
        return [(number, os.getpid(), time.sleep(0.05)) for number in numbers]

    assert shared(tmp_path, monkeypatch, work) == 0
    done = [part for found in json.loads((tmp_path / "found").read_text()) for part in found]
    assert sorted(number for number, *_ in done) == list(range(24))
    assert len({process for _, process, _ in done}) == 3


@pytest.mark.parametrize(("harm", "said"), [("crash", "ended in signal 11"), ("blocked", "takes far longer"), ("end", "helped has failed")])
def test_a_helper_that_fails_is_one_line_and_no_process_is_left(tmp_path, monkeypatch, capfd, harm, said):
    monkeypatch.setattr("beamwave_postproc.tool.SECONDS", 0.5)
    helpers = tmp_path / "helpers"
    helpers.mkdir()

    def work(numbers):
        for _ in numbers:
            time.sleep(0.05)
            if os.getpid() != os.getpgrp():
                (helpers / str(os.getpid())).touch()
                HARM[harm][0]() if harm != "end" else os._exit(3)

    assert shared(tmp_path, monkeypatch, work) == 3
    err = capfd.readouterr().err
    assert said in err and len(err.splitlines()) == 1
    time.sleep(0.2)
    left_over = [int(path.name) for path in helpers.iterdir() if Path(f"/proc/{path.name}").exists()]
    # One that has ended and whose end nobody asks for any more is no process at work.
    assert not [p for p in left_over if Path(f"/proc/{p}/stat").read_text().split()[2] != "Z"]
