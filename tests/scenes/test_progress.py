"""A run over a second shows a bar on a terminal, which vanishes, and plain lines in a log; `--quiet` shows neither."""

import re

import numpy as np
from ring_downs import as_text
from terminals import ended_on_terminal
from workplace import ENDLESS, RATIOS, captured_beam

CASES = {**RATIOS, "count": 100_000}
CLEAR = "\r\x1b[K"


def test_a_bar_shows_on_a_terminal_and_vanishes(here):
    here.scene("a", ENDLESS, CASES)
    status, shown = ended_on_terminal(here, "run", "a.nml", "--max-seconds", "2")
    assert status == 5
    bars = re.findall(r"\r\[#*\.*\] a  (\d+) %  case (\d+) of 100000", shown)
    assert bars
    assert [int(case) for _, case in bars] == sorted(int(case) for _, case in bars)
    _, _, after = shown.rpartition(CLEAR)
    assert "cases saved" in after
    assert "[" not in after.replace("\r\n", "")


def test_a_bar_of_a_record_moves_and_never_falls_back(here):
    """The search for lines learns on its way how much is left; what was reached stays, and no time left is guessed."""
    dice = np.random.default_rng(5)
    time = np.arange(80_000) / 2048
    waves = [np.exp((2j * np.pi * f - 0.5) * time) for f in np.sort(dice.uniform(20, 900, 20))]
    values = np.real(dice.normal(size=(16, 20)) @ waves) + 0.01 * dice.standard_normal((16, time.size))
    here.write("long.csv", as_text(time, values, "time," + ",".join(f"s{i}" for i in range(16))))
    here.scene("long", {"record": {"file": "long.csv"}, "spectrum": {}})
    status, shown = ended_on_terminal(here, "run", "long.nml", "--max-seconds", "30")
    assert status in (0, 5)
    parts = [int(part) for part in re.findall(r"\] long  (\d+) %", shown)]
    assert len(set(parts)) >= 2
    assert parts == sorted(parts) and not re.search(r"\d \w+ left", shown)


def test_a_short_run_shows_nothing(here):
    here.scene("a", captured_beam())
    assert ended_on_terminal(here, "run", "a.nml") == (0, "")


def test_nothing_is_shown_while_no_scene_is_under_way(here):
    # to plan a tolerance calls for progress: of the first scene before it begins, of the second after the first has ended
    still = {"duration": 1e-12, "samples": 50, "points": 1e-7}
    here.scene("a", captured_beam())
    here.scene("b", {**captured_beam(response=still), "modes": {"tolerance": 1e-6}})
    for words in (["b.nml"], ["a.nml", "b.nml"]):
        ended = here.beamwave("run", *words, "--overwrite", status=2)
        assert re.fullmatch(r"b\.nml:\d+: modes%tolerance: [^\n]*\n", ended.stderr)


def test_quiet_shows_warnings_alone_on_a_terminal(here):
    here.scene("a", ENDLESS, CASES)
    status, shown = ended_on_terminal(here, "run", "a.nml", "--quiet", "--max-seconds", "2")
    assert status == 5
    assert re.fullmatch(r"a\.nml: warning: .* cases saved; the same command goes on from there\r\n", shown)


def test_a_log_gets_plain_lines(here):
    here.scene("a\x1b[1m", ENDLESS, CASES)
    ended = here.beamwave("run", "a\x1b[1m.nml", "--max-seconds", "6", status=5)
    lines = [line for line in ended.stderr.splitlines() if " %" in line]
    assert lines
    for line in lines:
        assert re.fullmatch(r"a\\x1b\[1m  \d+ %  case \d+ of 100000(  [\d.]+ cases/s)?(  \d+ (ms|s|min|h) left)?", line)
    assert not re.search(r"[\r\x1b]", ended.stderr)


def test_quiet_leaves_only_warnings_and_errors(here):
    here.scene("a", captured_beam(impact={"restitution": 0.5}))
    ended = here.beamwave("run", "a.nml", "--quiet")
    assert (ended.returncode, ended.stdout) == (0, "")
    assert ended.stderr.startswith("a.nml: warning: added energy: restitution 0.5 with capture")
