"""`beamwave run --progress json`: all that goes to standard error is a line of JSON."""

import json

import pytest
from workplace import RATIOS, captured_beam

SWEEP = {"parameter": "rotation%angular_velocity", "first": 0.0, "last": 40.0, "count": 5}
LONG = captured_beam(modes=None, response={"duration": 1.0, "samples": 256}) | {"modes": {"tolerance": 1e-10}}
STAGES = {"modes", "events", "response", "spectrum", "write", None}


def lines_of(ended):
    return [json.loads(line) for line in ended.stderr.splitlines()]


def test_each_scene_begins_and_ends(here):
    here.scene("one", captured_beam())
    here.scene("many", captured_beam(), SWEEP)
    ended = here.beamwave("run", "one.nml", "many.nml", "--quiet", "--progress", "json")
    assert ended.returncode == 0 and ended.stdout == ""
    told = [(line["event"], line["scene"], line["done"], line["cases"]) for line in lines_of(ended)]
    assert told == [("begin", "one", 0, 1), ("end", "one", 1, 1), ("begin", "many", 0, 5), ("end", "many", 5, 5)]


def test_progress_grows_and_a_stopped_run_goes_on_from_there(here):
    here.scene("a", LONG, RATIOS)
    ended = here.beamwave("run", "a.nml", "--progress=json", "--max-seconds", "4", status=5)
    lines = lines_of(ended)
    steps = [line for line in lines if line["event"] == "progress"]
    assert len(steps) >= 2 and {line["stage"] for line in steps} <= STAGES
    assert any(line["stage"] for line in steps)
    for name in ("done", "part", "seconds"):
        values = [line[name] for line in steps]
        assert values == sorted(values)
    assert all(0 <= line["part"] <= 1 and line["cases"] == 20_000 for line in steps)
    assert any(line["event"] == "message" and "goes on from there" in line["message"] for line in lines)
    again = lines_of(here.beamwave("run", "a.nml", "--progress=json", "--max-seconds", "1"))
    assert again[0]["event"] == "begin" and again[0]["done"] == lines[-1 if lines[-1]["event"] == "end" else -2]["done"] > 0


def test_warnings_and_errors_are_lines_too(here):
    here.scene('say "a"\nb', captured_beam(rotation={"angular_velocity": 200.0}, response={"duration": 0.02, "samples": 64}))
    (here.directory / "bad.nml").write_text("&beam length=0 /\n")
    ended = here.beamwave("run", 'say "a"\nb.nml', "bad.nml", "--progress", "json", status=2)
    messages = [line["message"] for line in lines_of(ended) if line["event"] == "message"]
    assert any(message.startswith("bad.nml:1: beam%length: ") for message in messages)
    assert any(line["event"] == "begin" and line["scene"] == 'say "a"\nb' for line in lines_of(ended))


def test_a_result_that_is_there_has_no_progress(here):
    here.scene("a", captured_beam())
    here.beamwave("run", "a.nml")
    assert lines_of(here.beamwave("run", "a.nml", "--progress", "json")) == []


def test_processes_that_share_a_sweep_tell_of_it_once(processes):
    here = processes(2)
    here.scene("a", captured_beam(), SWEEP)
    ended = here.beamwave("run", "a.nml", "--quiet", "--progress", "json", status=0)
    assert [line["event"] for line in lines_of(ended) if line["event"] != "progress"] == ["begin", "end"]


@pytest.mark.parametrize("word", ["yes", "JSON", ""])
def test_another_word_is_refused(here, word):
    here.scene("a", captured_beam())
    ended = here.beamwave("run", "a.nml", f"--progress={word}")
    assert ended.returncode == 2 and "--progress" in ended.stderr
