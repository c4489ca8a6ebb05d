"""Paths are taken for what they are: names of files and directories, whatever NetCDF or another system would make of them."""

import os
import subprocess

import numpy as np
import pytest
import results
from workplace import captured_beam, namelist

FEW = captured_beam(modes={"before": 2, "after": 2})
RATIOS = {"parameter": "impact%mass_ratio", "first": 0.1, "last": 0.2, "count": 2}
ODD = [
    " leading", "trailing ", " ", "http:", "http:/example.org", "http://example.org/x", "https://example.org", "s3:/bucket",
    "s3://bucket/x", "file:///x", "C:", "C:/x", "c:", "a#mode=zarr", "x?y#mode=nczarr,s3", "[mode=bytes]x", "./a://b", "-x",
    "'quoted'", "$HOME", "~", "ünïcödé", "*", "tab\there", "line\nfeed", "a//b", "./", "../here too",
]


def found(here):
    """All files below the directory and beside it, as paths from it."""
    top = here.directory.parent
    return sorted(str(path.relative_to(top)) for path in top.rglob("*") if path.is_file() and path.name != "a.nml")


@pytest.fixture
def inside(here):
    """A workplace in a directory of its own, so that what lands beside it is seen."""
    here.directory = here.directory / "here"
    here.directory.mkdir()
    return here


@pytest.mark.parametrize(
    ("name", "sweeps"), [*((name, []) for name in ODD), *((name, [RATIOS]) for name in [" x ", "http://example.org", "C:/x"])]
)
def test_a_directory_of_any_name_gets_the_result(inside, name, sweeps):
    inside.scene("a", FEW, *sweeps)
    for times in range(2):  # the second finds the first
        ended = inside.beamwave("run", "a.nml", f"--output={name}", status=0)
        assert ("nothing to do" in ended.stdout) == (times == 1)
    result = inside.directory / name / "a.nc"
    assert results.read(result)["mode_count"].max() == 2
    assert found(inside) == [str(result.resolve().relative_to(inside.directory.parent.resolve()))]


@pytest.mark.parametrize("name", [" a", "http:", "C:", "[x]", "a#mode=zarr", "a ", " ", "#", "a.b"])
def test_a_scene_of_any_name_gives_its_name_to_the_result(inside, name):
    inside.write(f"{name}.nml", namelist(FEW))
    inside.beamwave("run", f"{name}.nml", status=0)
    assert inside.left() == [f"{name}.nc"]
    assert results.read(inside.directory / "output" / f"{name}.nc")["mode_count"] == 2


def test_a_scene_comes_out_of_a_pipe(inside):
    """As a shell makes one of `<(command)`."""
    inside.write("a.nml", namelist(FEW))
    command = ["bash", "-c", f"'{inside.program}' run <(sleep 0.3; cat a.nml)"]
    ended = subprocess.run(command, cwd=inside.directory, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert len(inside.left()) == 1


@pytest.mark.parametrize("path", ["pipe", "/dev/zero", "/dev/null"])
def test_what_is_no_file_is_not_waited_for(inside, path):
    os.mkfifo(inside.directory / "pipe")
    ended = inside.beamwave("check", path, status=2 if path == '/dev/null' else 3)
    assert f"{path}: " in ended.stderr


def test_a_blank_at_the_end_belongs_to_a_name(inside):
    inside.write("a.nml", namelist(FEW))
    ended = inside.beamwave("check", "a.nml ", status=3)
    assert "a.nml : cannot be read" in ended.stderr


@pytest.mark.parametrize("planted", ["output/a.nc", "output/a.partial", "output"])
@pytest.mark.parametrize("sweeps", [[], [RATIOS]], ids=["case", "sweep"])
def test_nothing_is_written_through_a_link_that_somebody_else_has_planted(inside, planted, sweeps):
    """To a file, or to a directory where work would lie; the directory of results itself may be a link."""
    inside.scene("a", FEW, *sweeps)
    treasure = inside.directory / "treasure"
    link = inside.directory / planted
    link.parent.mkdir(exist_ok=True)
    if planted.endswith(".nc"):
        treasure.write_text("kept")
    else:
        treasure.mkdir()
    link.symlink_to(treasure)
    ended = inside.beamwave("run", "a.nml", "--overwrite")
    if planted == "output":
        assert ended.returncode == 0, ended.stderr
        assert inside.left("treasure") == ["a.nc"]
    elif treasure.is_file():
        assert treasure.read_text() == "kept"
    else:
        assert inside.left("treasure") == []


@pytest.mark.parametrize("sweeps", [[], [RATIOS]], ids=["single", "sweep"])
@pytest.mark.parametrize("linked", [False, True], ids=["directory", "link"])
def test_nothing_is_removed_that_no_run_has_made(inside, linked, sweeps):
    """Where unfinished work would lie, there are files of somebody else, with the endings that the work has."""
    inside.scene("a", FEW, *sweeps)
    treasure = inside.directory / "treasure"
    place = inside.directory / "output/a.partial"
    place.parent.mkdir(exist_ok=True)
    treasure.mkdir()
    if linked:
        place.symlink_to(treasure)
    else:
        place.mkdir()
    names = ["a.nc", "b.journal", "c.lock", "d-1-20260101T000000.nc", "drafts.nc", "draft.txt"]
    for name in names:
        (place / name).write_text("precious")
    inside.beamwave("run", "a.nml", status=3 if linked else 0)
    assert {name: (place / name).read_text() for name in names} == dict.fromkeys(names, "precious")


NAMES = [(command, ["a\\b.nml"]) for command in ("run", "check", "accuracy", "effects")]
PLACES = [(command, ["a.nml", "--output=out\\put"]) for command in ("run", "accuracy", "effects")]


@pytest.mark.parametrize(("command", "words"), NAMES + PLACES)
def test_a_backslash_is_refused_before_any_work(inside, command, words):
    inside.write(words[0], namelist(captured_beam(response={"duration": 0.01, "samples": 10})))
    ended = inside.beamwave(command, *words, status=2)
    assert "backslash" in ended.stderr and "accepted" in ended.stderr
    assert inside.left(".") == [words[0]]


STEERING = "\x1b]0;x\x07\u202eq\x9b"  # a terminal's title, letters from right to left, escape and bracket in one letter


@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_names_of_files_columns_and_units_do_not_steer_a_terminal(here, quiet):
    """What only a scene's text may not hold comes from the names of files, and from the files of records."""
    rows = "".join(f"{k / 2048},{np.exp(-k / 400) * np.cos(0.3 * k)},{k}\n" for k in range(400))
    here.write("a.csv", f"time [s],a{STEERING} [m],b [N{STEERING}]\n{rows}")
    here.write(f"{STEERING}.nml", "&scene title = 'a\u202eb' /\n&record file = 'a.csv' /\n&spectrum /\n")
    here.write("columns.nml", "&record file = 'a.csv', columns = 'none' /\n&spectrum /\n")
    here.write("words.nml", "&record file = 'a.csv', \u202eno = 1 /\n")
    scene = f"{STEERING}.nml"
    for words in [
        ["run", scene, "columns.nml", "words.nml"], ["run", scene], ["run", scene, "--output", f"o{STEERING}"], ["run", STEERING],
        ["check", "."], ["check", scene], [STEERING], ["run", f"--{STEERING}"], ["describe", STEERING], ["effects", scene],
    ]:
        if words[0] != STEERING and "describe" not in words:
            words = [*words, *quiet]
        ended = here.beamwave(*words)
        said = ended.stdout + ended.stderr
        assert "\\x1b]0;x\\x07\\xe2\\x80\\xaeq\\xc2\\x9b" in said or ended.stderr == ""
        assert not any(letter in said for letter in "\x1b\x07\u202e\x9b")
