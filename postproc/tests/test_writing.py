"""What the commands write has its name when it is whole, and takes nobody else's place unless it is asked to."""

import errno
import os
import stat
from functools import partial
from pathlib import Path

import hostile
import numpy as np
import pytest
import synthetic

from beamwave_postproc import cli, dispersion, motion, paper, peaks, velocity_jump
from beamwave_postproc.record import cli as record
from beamwave_postproc.writing import put

OLD, NEW = b"an old file", b"a new one"


def write(path):
    path.write_bytes(NEW)


def place(path, kind):
    """Put something in the place of a file; returns where what a link leads to lies."""
    elsewhere = path.with_name("elsewhere")
    elsewhere.write_bytes(OLD)
    {
        "file": lambda: path.write_bytes(OLD),
        "link": lambda: path.symlink_to(elsewhere),
        "hard link": lambda: os.link(elsewhere, path),
        "link to nothing": lambda: path.symlink_to("nothing"),
        "pipe": lambda: os.mkfifo(path),
    }[kind]()
    return elsewhere


KINDS = ["file", "link", "hard link", "link to nothing", "pipe"]


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_there_is_kept_or_replaced_itself(tmp_path, kind):
    path = tmp_path / "a.txt"
    elsewhere = place(path, kind)
    before = path.lstat()
    with pytest.raises(FileExistsError, match="is there already; accepted: --overwrite"):
        put(path, write, mark="new")
    assert path.lstat().st_ino == before.st_ino and elsewhere.read_bytes() == OLD
    put(path, write, overwrite=True)
    assert path.read_bytes() == NEW and stat.S_ISREG(path.lstat().st_mode) and elsewhere.read_bytes() == OLD
    assert {one.name for one in tmp_path.iterdir()} == {"a.txt", "elsewhere"}


def test_its_own_is_replaced_but_not_through_a_link(tmp_path):
    path = tmp_path / "a.txt"
    elsewhere = place(path, "hard link")
    put(path, write, mark="old")
    assert path.read_bytes() == NEW and elsewhere.read_bytes() == OLD
    path.unlink()
    path.symlink_to(elsewhere)
    with pytest.raises(FileExistsError):
        put(path, write, mark="old")


def test_a_failure_leaves_what_was_there_and_names_the_file(tmp_path):
    def fail(path):
        path.write_bytes(NEW)
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    path = tmp_path / "a.txt"
    path.write_bytes(OLD)
    with pytest.raises(OSError, match=f"No space left on device: '{path}'"):
        put(path, fail, overwrite=True)
    assert path.read_bytes() == OLD and list(tmp_path.iterdir()) == [path]


def test_a_name_that_is_taken_meanwhile_is_left_where_links_are_not_offered_too(tmp_path, monkeypatch):
    path = tmp_path / "a.txt"

    def meanwhile(draft):
        draft.write_bytes(NEW)
        path.write_bytes(OLD)

    for links in (True, False):
        if not links:
            monkeypatch.setattr("os.link", lambda *_: (_ for _ in ()).throw(OSError(errno.EPERM, "no links here")))
        with pytest.raises(FileExistsError):
            put(path, meanwhile)
        assert path.read_bytes() == OLD and list(tmp_path.iterdir()) == [path]
        path.unlink()
    put(path, write)
    assert path.read_bytes() == NEW


def drawn(directory):
    settings = synthetic.scene(impact=None, modes={"after": 2})
    return [str(synthetic.write(directory / "a.nc", settings))]


def measured(directory):
    settings = synthetic.scene(response={"duration": 0.1, "samples": 64}, spectrum={"max_peaks": 3})
    return [str(synthetic.write(directory / "a.nc", settings))]


def filmed(directory):
    """A film of four frames."""
    settings = synthetic.scene(response={"duration": 0.01, "samples": 16, "points": [0.25, 0.5, 0.75, 1.0]})
    return ["--animate", str(synthetic.write(directory / "a.nc", settings))]


def compared(directory):
    twin = directory / "b.nc"
    twin.symlink_to(directory / "a.nc")
    return ["--compare", *drawn(directory), str(twin)]


def of_the_paper(directory):
    synthetic.write(directory / "fig3.nc", synthetic.scene())
    return [str(directory)]


def recorded(directory):
    np.save(directory / "a.npy", hostile.VALUES)
    return [str(directory / "a.npy"), "--sample-rate", "2048"]


COMMANDS = {
    "a_dispersion.png": (cli, drawn), "a.html": (cli, lambda place: ["--page", *drawn(place)]),
    "a_and_b_frequencies.png": (cli, compared), "a_motion.gif": (cli, filmed), "a_peaks.csv": (peaks, measured),
    "fig3.png": (paper, of_the_paper), "a.nc": (record, recorded),
}  # fmt: skip


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_replaces_its_own_and_nothing_else(tmp_path, monkeypatch, capsys, name):
    command, prepare = COMMANDS[name]
    monkeypatch.setattr("beamwave_postproc.files.DPI", 20)
    for module in ("files", "kinds"):
        monkeypatch.setattr(f"beamwave_postproc.{module}.KINDS", {"dispersion": dispersion})
    monkeypatch.setattr("beamwave_postproc.files.motion", partial(motion, frames=4))
    monkeypatch.setattr("beamwave_postproc.paper.FIGURES", {"fig3": velocity_jump})
    words = prepare(tmp_path)
    written = tmp_path / name
    elsewhere = place(written, "hard link")
    assert command.main(words) == 3
    assert "is there already; accepted: --overwrite" in capsys.readouterr().err
    assert written.read_bytes() == elsewhere.read_bytes() == OLD
    assert command.main([*words, "--overwrite"]) == 0
    assert written.read_bytes() != OLD and elsewhere.read_bytes() == OLD
    first = written.stat().st_ino
    again = command.main(words)
    assert again == (3 if name == "a.nc" else 0)  # a record is not made again by the way: results were made of it
    assert (written.stat().st_ino == first) == (name == "a.nc")
    assert not list(tmp_path.glob(".*"))


def test_a_record_does_not_take_the_place_of_its_source(tmp_path, capsys):
    hostile.new_matlab(tmp_path / "a.nc", lambda file: None)
    before = (tmp_path / "a.nc").read_bytes()
    assert record.main([str(tmp_path / "a.nc"), "--overwrite"]) == 3
    assert "its own place" in capsys.readouterr().err and (tmp_path / "a.nc").read_bytes() == before


@pytest.mark.parametrize("name", ["..\\a.npy", "dir\\a.npy"])
def test_a_backslash_leads_nowhere_else(tmp_path, monkeypatch, capsys, name):
    """NetCDF takes it for a slash."""
    inside = tmp_path / "inside"
    inside.mkdir()
    monkeypatch.chdir(inside)
    np.save(inside / name, hostile.VALUES)
    assert record.main([name, "--sample-rate", "2048"]) == 3
    assert "backslash" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.rglob("*")) == sorted(["inside", name])
    for record_name in ("http:", "C:", "~", "#mode=zarr"):
        Path(record_name).mkdir()
        np.save(Path(record_name) / "a.npy", hostile.VALUES)
        assert record.main([f"{record_name}/a.npy", "--sample-rate", "2048"]) == 0
        assert (Path(record_name) / "a.nc").is_file()
