"""`run(scene)`: the program is found and called, its result opened, its refusals raised."""

import os
import warnings
from pathlib import Path

import f90nml
import numpy as np
import pytest

from beamwave_postproc import ProgramWarning, RunFailed, Untrusted, run
from beamwave_postproc.run import find_program, namelist

PAPER = {
    "beam": {"length": 1.0, "diameter": 0.037, "density": 7870.0, "youngs_modulus": 2.0e11},
    "rotation": {"angular_velocity": 0.0, "plane": "in"},
    "impact": {"mass_ratio": 0.2},
    "capture": {},
    "modes": {"before": 3, "after": 3},
}


def test_groups_become_a_namelist_that_reads_back(tmp_path):
    groups = {
        **PAPER,
        "scene": {"title": "it's a title"},
        "response": {"duration": 0.1, "samples": np.int32(8), "points": np.array([0.5, 1.0]), "velocity": True},
        "sweep": [
            {"parameter": "rotation%angular_velocity", "values": [0, 50]},
            {"parameter": "impact%mass_ratio", "values": (0.1, 0.2)},
        ],
    }
    read = f90nml.reads(namelist(groups))
    assert read["scene"]["title"] == "it's a title" and read["response"]["velocity"] is True
    assert read["response"]["points"] == [0.5, 1.0] and read["response"]["samples"] == 8
    assert [sweep["values"] for sweep in read["sweep"]] == [[0, 50], [0.1, 0.2]]
    assert read["beam"]["youngs_modulus"] == 2.0e11 and read["capture"] == {}


def test_a_scene_as_groups_as_text_and_as_a_file_gives_one_result(beamwave, tmp_path):
    (tmp_path / "scene.nml").write_text(namelist(PAPER))
    results = [
        run(scene, program=beamwave)
        for scene in (PAPER, namelist(PAPER), tmp_path / "scene.nml", str(tmp_path / "scene.nml"))
    ]
    for result in results[1:]:
        np.testing.assert_array_equal(result["angular_frequency"], results[0]["angular_frequency"])
    # h α₁²/l² of the paper's beam with the mass, from the constants in its documents.
    assert float(results[0]["angular_frequency"][0]) == pytest.approx(
        46.6304239974881 * 1.6163996601559350880**2, rel=1e-13
    )
    assert sorted(tmp_path.iterdir()) == [tmp_path / "scene.nml"]


def test_the_result_is_kept_where_told(beamwave, tmp_path):
    (tmp_path / "a scene.nml").write_text(namelist(PAPER))
    for _ in range(2):
        run(tmp_path / "a scene.nml", tmp_path / "kept", program=beamwave)
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["a scene.nc"]


@pytest.mark.parametrize(
    ("scene", "error"),
    [
        *(({}, ValueError), ({"body": []}, ValueError), ("", ValueError), (" \n", ValueError)),
        *((".", IsADirectoryError), (Path(), IsADirectoryError), ("! a comment", FileNotFoundError)),
        *(
            ("R&D", IsADirectoryError),
            ("R&D/absent.nml", FileNotFoundError),
            (None, TypeError),
            (b"&beam /", TypeError),
        ),
    ],
)
def test_what_is_no_scene_runs_nothing(tmp_path, monkeypatch, scene, error, stand_in):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "R&D").mkdir()
    (tmp_path / "a.nml").write_text(namelist(PAPER))
    with pytest.raises(error):
        run(scene, "output", program=stand_in(tmp_path, f"touch {tmp_path}/called"))
    with pytest.raises(ValueError, match="output is empty"):
        run("a.nml", "", program=stand_in(tmp_path, f"touch {tmp_path}/called"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["R&D", "a.nml", "beamwave"]


def test_paths_and_texts_are_told_apart_by_how_they_begin(beamwave, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = namelist(PAPER)
    for name in ("R&D.nml", "&beam.nml", "-x.nml"):
        (tmp_path / name).write_text(text)
    scenes = ["R&D.nml", "-x.nml", Path("&beam.nml"), f"! R&D\n\n  {text}", text.replace("\n", " ").strip()]
    first, *others = (run(scene, program=beamwave) for scene in scenes)
    for other in others:
        np.testing.assert_array_equal(other["angular_frequency"], first["angular_frequency"])
    with pytest.raises(RunFailed):
        run("&beam.nml", program=beamwave)


def test_a_result_that_is_kept_is_replaced_only_where_that_is_asked_for(beamwave, tmp_path):
    other = {**PAPER, "modes": {"before": 4, "after": 4}}
    for _ in range(2):
        assert run(PAPER, tmp_path, program=beamwave).sizes["mode"] == 3
    before = (tmp_path / "scene.nc").read_bytes()
    with pytest.raises(RunFailed, match="--overwrite") as failure:
        run(other, tmp_path, program=beamwave)
    assert failure.value.status == 3 and (tmp_path / "scene.nc").read_bytes() == before
    assert run(other, tmp_path, overwrite=True, program=beamwave).sizes["mode"] == 4


def test_a_scene_that_is_wrong_is_raised_with_its_messages(beamwave):
    with pytest.raises(RunFailed, match="beam%length") as failure:
        run({"beam": {**PAPER["beam"], "length": -1.0}}, program=beamwave)
    assert failure.value.status == 2 and "\nscene.nml:2: " in str(failure.value)


def test_numbers_that_cannot_be_trusted_are_a_warning(beamwave):
    scene = {**PAPER, "rotation": {"angular_velocity": 5000.0}, "response": {"duration": 1.0, "samples": 16}}
    with pytest.warns(Untrusted):
        assert int(run(scene, program=beamwave)["case_status"]) != 0


@pytest.fixture
def answering(stand_in, tmp_path, full_result):
    """Makes a program that leaves a result where it is told, writes lines to standard error, and ends with a status."""

    def make(status, said):
        told = "".join(f"echo '{line}' >&2\n" for line in said)
        return stand_in(tmp_path, f'mkdir -p "$4"\ncp "{full_result}" "$4/scene.nc"\n{told}exit {status}')

    return make


@pytest.mark.parametrize(("status", "kinds"), [(0, [ProgramWarning] * 2), (4, [Untrusted])])
def test_what_the_program_warns_of_is_a_warning_in_python(answering, status, kinds):
    said = ["a scene.nml: warning: large deflection: 2: much", "b.nml: warning: aliasing", "as its second line says"]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run(PAPER, program=answering(status, said))
    assert [warning.category for warning in caught] == kinds
    assert "\n".join(str(warning.message) for warning in caught) == (
        "large deflection: 2: much\naliasing\nas its second line says"
    )
    assert {Path(warning.filename) for warning in caught} == {Path(__file__)}


def test_a_run_without_a_warning_is_silent(answering):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(PAPER, program=answering(0, []))


def test_the_program_s_own_warnings_arrive(beamwave):
    fast = {**PAPER, "rotation": {"angular_velocity": 200.0, "plane": "in"}}
    with pytest.warns(ProgramWarning, match="unstable"):
        run(fast, program=beamwave)


def test_the_program_is_looked_for_where_the_documents_say(tmp_path, monkeypatch, stand_in):
    own, on_path, by_name = (tmp_path / name for name in ("own", "on_path", "by_name"))
    for directory in (own, on_path, by_name):
        directory.mkdir()
        stand_in(directory, "exit 5")
    monkeypatch.setenv("PATH", f"{on_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.delenv("BEAMWAVE", raising=False)
    assert find_program() == str(on_path / "beamwave")
    monkeypatch.setenv("BEAMWAVE", str(by_name / "beamwave"))
    assert find_program() == str(by_name / "beamwave")
    assert find_program(own / "beamwave") == str(own / "beamwave")
    with pytest.raises(FileNotFoundError, match="no program"):
        find_program(tmp_path / "absent")


@pytest.mark.parametrize("way", ["package", "environment", "directory"])
def test_the_program_built_in_the_checkout_is_found(tmp_path, monkeypatch, way, stand_in):
    checkout, elsewhere = tmp_path / "a checkout", tmp_path / "elsewhere"
    package = checkout / "postproc" / "beamwave_postproc"
    installed = elsewhere / "site-packages" / "beamwave_postproc"
    for directory in (package, installed, checkout / "build" / "bin", checkout / "input" / "paper"):
        directory.mkdir(parents=True)
    (package / "__init__.py").touch()
    program = stand_in(checkout / "build" / "bin", "exit 5")
    module = (package if way == "package" else installed) / "run.py"
    monkeypatch.setitem(find_program.__globals__, "__file__", str(module))
    monkeypatch.setattr("sys.prefix", str((checkout if way == "environment" else elsewhere) / ".venv"))
    monkeypatch.chdir(checkout / "input" / "paper" if way == "directory" else elsewhere)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("BEAMWAVE", raising=False)
    assert find_program() == str(program)
    program.unlink()
    with pytest.raises(FileNotFoundError, match=f"not at {program}"):
        find_program()
    (package / "__init__.py").unlink()
    with pytest.raises(FileNotFoundError, match="in no checkout"):
        find_program()


def test_a_stopped_run_is_raised_with_its_status(tmp_path, stand_in):
    program = stand_in(tmp_path, "echo 'stopped in order' >&2; exit 5")
    with pytest.raises(RunFailed, match="stopped in order") as failure:
        run(PAPER, program=program)
    assert failure.value.status == 5


def test_nothing_is_left_in_the_temporary_directory(tmp_path, monkeypatch, stand_in):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "scratch"))
    Path(tmp_path / "scratch").mkdir()
    with pytest.raises(RunFailed):
        run(PAPER, program=stand_in(tmp_path, "exit 3"))
    assert not list((tmp_path / "scratch").iterdir())
