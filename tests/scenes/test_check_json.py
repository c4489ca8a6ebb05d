"""`beamwave check --json`: one document, whatever scenes and their names are, which says what the text says."""

import json
import os
from pathlib import Path

import pytest
from workplace import captured_beam

SWEEP = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 40.0, "count": 5}
STRANGE = ['quote"d', "new\nline", "back:slash", "tab\there", "esc\x1b[31m", "bêta ω", "bell\x07", "no-utf8-\udcff", "it's", "a: b: 3: &c%d: e"]


def checked(here, *words, status=0):
    """The document of a check that ends with a status and says nothing else."""
    ended = here.beamwave("check", "--json", *words, text=False, status=status)
    assert ended.stderr == b""
    document = json.loads(ended.stdout)
    assert document["status"] == status and document["program"].startswith("beamwave ")
    return document["scenes"]


def test_a_good_scene_is_described(here):
    here.scene("a", captured_beam(scene={"title": 'he said "β"'}, damping={"ratio": 0.01}, response={"duration": 0.1, "samples": 64}), SWEEP)
    (scene,) = checked(here, "a.nml")
    assert scene["file"] == "a.nml" and scene["title"] == 'he said "β"' and scene["status"] == 0
    assert (scene["cases"], scene["modes"], scene["tolerance"]) == (5, 12, None)
    assert (scene["points"], scene["samples"]) == (2, 64)
    assert scene["method"] == "closed form" and scene["effects"] == ["rotation", "damping", "impact", "capture"]
    assert scene["errors"] == []
    assert 0 < scene["seconds"] < 10 and scene["memory_bytes"] > 1e6
    here.beamwave("run", "a.nml", "--quiet")
    assert scene["disk_bytes"] == (here.directory / "output/a.nc").stat().st_size


def test_a_tolerance_is_named_and_its_modes_counted(here):
    here.scene("a", captured_beam(modes=None, response={"duration": 0.1, "samples": 64}))
    (scene,) = checked(here, "a.nml")
    assert scene["tolerance"] == 1e-6 and scene["modes"] > 20
    said = here.beamwave("check", "a.nml").stdout
    assert f"about {scene['modes']} to be summed" in said


def test_warnings_and_remarks_are_those_of_the_text(here):
    here.scene("a", captured_beam(rotation={"angular_velocity": 200.0}, response={"duration": 0.02, "samples": 64}))
    (scene,) = checked(here, "a.nml")
    warned = here.beamwave("check", "--quiet", "a.nml").stderr
    assert scene["warnings"]
    assert [f"a.nml: warning: {warning['message']}" for warning in scene["warnings"]] == warned.splitlines()
    assert all(warning["message"].split(": ")[0] == warning["kind"] for warning in scene["warnings"])


def test_every_error_has_its_line_group_and_name(here):
    (here.directory / "bad.nml").write_text("&beam length=-1, density=1, diamter=2 /\n&rotatoin /\n\n&impact mass_ratio=0.2\n restitution=2 /\n")
    (scene,) = checked(here, "bad.nml", status=2)
    found = {(error["line"], error["group"], error["name"]) for error in scene["errors"]}
    assert {(1, "beam", "length"), (1, "beam", "diamter"), (5, "impact", "restitution")} <= found
    assert any(error["line"] == 2 and error["group"] == "rotatoin" for error in scene["errors"])
    text = here.beamwave("check", "bad.nml").stderr.splitlines()
    assert len(text) == len(scene["errors"])
    assert all(error["message"] in line for error, line in zip(scene["errors"], text))
    assert scene["warnings"] == scene["remarks"] == [] and scene["status"] == 2


def test_what_is_absent_has_no_line(here):
    (here.directory / "bad.nml").write_text("&modes before=3 /\n")
    (scene,) = checked(here, "bad.nml", status=2)
    assert [(error["line"], error["group"], error["name"]) for error in scene["errors"]] == [(None, "beam", None)]


def test_errors_of_a_table_have_its_path_and_their_lines(here):
    here.scene("a", {**captured_beam(), "design": {"file": "t.csv"}})
    (here.directory / "t.csv").write_text("impact%mass_ratio, modes%nothing\n0.2, 1\n-1, 2\nx, 3\n")
    (scene,) = checked(here, "a.nml", status=2)
    assert [(error["file"], error["line"]) for error in scene["errors"]] == [("t.csv", 1), ("t.csv", 3), ("t.csv", 4)]
    assert all("t.csv" not in error["message"] for error in scene["errors"])


def test_good_scenes_come_first_and_no_file_is_a_scene_with_an_error(here):
    here.scene("good", captured_beam())
    scenes = checked(here, "none.nml", "good.nml", status=3)
    assert [scene["file"] for scene in scenes] == ["good.nml", "none.nml"]
    assert scenes[1]["status"] == 3 and scenes[1]["errors"][0]["line"] is None


@pytest.mark.parametrize("name", STRANGE)
@pytest.mark.parametrize("good", [True, False])
def test_a_name_of_any_letters_is_read_back(here, name, good):
    path = f"{name}.nml"
    here.scene("a", captured_beam())
    (here.directory / "a.nml").rename(here.directory / path)
    if not good:
        (here.directory / path).write_text("&beam length=0 /\n&beam length=1 /\n")
    (scene,) = checked(here, path, status=0 if good else 2)
    assert os.fsencode(scene["file"]) == os.fsencode(path)
    if not good:
        assert scene["errors"][0]["group"] == "beam" and all(name not in error["message"] for error in scene["errors"])


def test_every_scene_of_the_repository_gives_a_document(here):
    scenes = sorted(Path(__file__).parents[2].glob("input/*.nml"))
    ended = here.beamwave("check", "--json", *map(str, scenes))
    document = json.loads(ended.stdout)
    assert sorted(scene["file"] for scene in document["scenes"]) == sorted(map(str, scenes))
