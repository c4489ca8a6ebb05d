"""The words of the command line: what each command prints, and status 2 for what makes no sense."""

import re

import pytest
from conftest import PROJECT
from workplace import captured_beam

WRONG = {
    "no command": [],
    "an unknown command": ["frob"],
    "an option of no command": ["run", "--frob", "a.nml"],
    "an option of another command": ["check", "--overwrite", "a.nml"],
    "run without a scene": ["run"],
    "check without a scene": ["check", "--quiet"],
    "an option without its value": ["run", "a.nml", "--output"],
    "a value where none is taken": ["run", "a.nml", "--quiet=yes"],
    "seconds that are no number": ["run", "a.nml", "--max-seconds", "soon"],
    "seconds below zero": ["run", "a.nml", "--max-seconds", "-1"],
    "seconds without end": ["run", "a.nml", "--max-seconds", "inf"],
    "two groups to describe": ["describe", "beam", "modes"],
    "an unknown group to describe": ["describe", "nope"],
}


@pytest.mark.parametrize("words", WRONG.values(), ids=WRONG.keys())
def test_a_wrong_command_line_is_refused_before_anything_runs(here, words):
    here.scene("a", captured_beam())
    ended = here.beamwave(*words, status=2)
    assert ended.stderr.strip()
    assert ended.stdout == ""
    assert not (here.directory / "output").exists()


@pytest.mark.parametrize(
    "words", [["{}"], ["run", "--{}"], ["run", "--{}=a"], ["run", "a.nml", "--max-seconds", "{}"], ["describe", "{}"]]
)
def test_a_message_shows_no_more_than_80_letters_of_a_word(here, words):
    ended = here.beamwave(*[word.format("x" * 100_000) for word in words], status=2)
    assert "x" * 70 in ended.stderr
    assert "x" * 81 not in ended.stderr


@pytest.mark.parametrize("word", ["--help", "help"])
def test_help_names_every_command_and_status(here, word):
    ended = here.beamwave(word)
    assert (ended.returncode, ended.stderr) == (0, "")
    for name in ["run", "check", "describe", "--version", "--output", "--overwrite", "--quiet", "--max-seconds", "70"]:
        assert name in ended.stdout


def test_messages_accept_what_the_help_shows(here):
    shown = here.beamwave("--help").stdout
    names = re.findall(r"^  beamwave ([a-z]+) ", shown, re.MULTILINE)
    options = re.findall(r"^    (--[a-z-]+)", shown, re.MULTILINE)
    assert here.beamwave("frob").stderr.endswith("accepted: " + ", ".join([*names, "--help", "--version"]) + "\n")
    for name in names:
        refused = here.beamwave(name, "--frob").stderr
        accepted = re.findall(r"--[a-z-]+", refused.partition("; accepted: ")[2])
        assert refused.startswith(f"beamwave {name}: '--frob' is not an option of this command")
        assert accepted == [option for option in options if option in accepted]
        for option in options:
            takes = "is not an option" not in here.beamwave(name, f"{option}=").stderr
            assert takes == (option in accepted)


def test_version_names_program_compiler_and_libraries(here):
    ended = here.beamwave("--version")
    project = (PROJECT / "CMakeLists.txt").read_text(encoding="utf-8")
    version = re.search(r"project\(beamwave VERSION ([0-9.]+)", project)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.startswith(f"beamwave {version[1]} (")
    for name in ["GCC", "NetCDF", "FFTW", "LAPACK"]:
        assert name in ended.stdout


def test_the_documented_inputs_are_those_the_program_describes(here):
    ended = here.beamwave("describe")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout == (PROJECT / "docs/input.md").read_text(encoding="utf-8")


def test_one_group_can_be_described(here):
    ended = here.beamwave("describe", "impact", status=0)
    assert "mass_ratio" in ended.stdout
    assert "youngs_modulus" not in ended.stdout
    assert here.beamwave("describe", "IMPACT").stdout == ended.stdout
    unknown = here.beamwave("describe", "rotatoin", status=2)
    assert "'rotatoin' is not a known group (did you mean &rotation?); accepted: &scene" in unknown.stderr


def test_check_says_what_would_run_and_writes_nothing(here):
    here.scene("a", captured_beam(scene={"title": "a title"}))
    ended = here.beamwave("check", "a.nml")
    assert (ended.returncode, ended.stderr) == (0, "")
    for word in ["a title", "rotation", "impact", "capture", "closed form", "memory", "result"]:
        assert word in ended.stdout
    assert here.left(".") == ["a.nml"]
    assert here.beamwave("check", "a.nml", "--quiet").stdout == ""


def test_run_reports_and_leaves_one_file(here):
    here.scene("a", captured_beam())
    ended = here.beamwave("run", "a.nml")
    assert (ended.returncode, ended.stderr) == (0, "")
    for word in ["closed form", "phase velocity", "impulse", "energy", "output/a.nc"]:
        assert word in ended.stdout
    assert here.left() == ["a.nc"]


def test_a_directory_stands_for_its_scenes(here):
    for name in ["set/b", "set/a"]:
        here.scene(name, captured_beam())
    here.write("set/notes.txt", "no scene")
    ended = here.beamwave("run", "set/", "--output=results", "--quiet")
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")
    assert here.left("results") == ["a.nc", "b.nc"]


def test_a_file_that_is_named_twice_is_run_once(here):
    here.scene("a", captured_beam())
    for name in ["set/b", "other/b"]:
        here.scene(name, captured_beam())
    (here.directory / "link.nml").symlink_to("a.nml")
    ended = here.beamwave("run", "a.nml", "./a.nml", "set", "set/b.nml", "set/../a.nml")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "2 scenes: 2 done" in ended.stdout
    assert here.left() == ["a.nc", "b.nc"]
    absent = here.beamwave("run", "absent.nml", "absent.nml", status=3)
    assert len(absent.stderr.splitlines()) == 1
    linked = here.beamwave("run", "a.nml", "link.nml", "--overwrite")  # another name of the file has a result of its own
    assert (linked.returncode, linked.stderr) == (0, "")
    assert here.left() == ["a.nc", "b.nc", "link.nc"]


def test_two_files_of_one_name_keep_no_other_error_from_view(here):
    for name in ["one/a", "two/a", "b"]:
        here.scene(name, captured_beam())
    here.scene("bad", captured_beam(beam={"length": -1.0}))
    ended = here.beamwave("run", "one/a.nml", "b.nml", "bad.nml", "absent.nml", "two/a.nml", "one/a.nml", status=3)
    errors = ended.stderr.splitlines()
    assert len(errors) == 3
    assert "beam%length" in errors[0] and errors[1].startswith("absent.nml: ")
    assert errors[2].startswith("two/a.nml: has the same name as one/a.nml")
    assert "5 scenes: 0 done, 3 wrong, 2 not begun" in ended.stdout
    assert not (here.directory / "output").exists()


def test_a_second_run_has_nothing_to_do(here):
    first = here.simulate("a", captured_beam())
    ended = here.beamwave("run", "a.nml")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "output/a.nc" in ended.stdout
    assert "nothing to do" in ended.stdout
    assert here.result("a").attributes == first.attributes  # `created` too: nobody touched it


def test_a_scene_that_only_reads_differently_is_the_same_scene(here):
    here.simulate("a", captured_beam())
    here.write("a.nml", "! a comment\n" + (here.directory / "a.nml").read_text(encoding="utf-8").upper())
    assert "nothing to do" in here.beamwave("run", "a.nml").stdout


def test_another_scene_does_not_replace_a_result_unasked(here):
    first = here.simulate("a", captured_beam())
    here.scene("a", captured_beam(impact={"mass_ratio": 0.5}))
    ended = here.beamwave("run", "a.nml", status=3)
    assert "output/a.nc" in ended.stderr
    assert "--overwrite" in ended.stderr
    assert here.result("a").attributes == first.attributes
    assert here.run("a", "--overwrite")["impact_mass_ratio"] == 0.5
