"""The report of `run` is one screen, and with `--verbose` all of it."""

import re

import numpy as np
import pytest
from conftest import PROJECT

SCREEN = 45  # lines
SCENES = sorted(str(path.relative_to(PROJECT / "input")) for path in (PROJECT / "input").rglob("*.nml"))
CUT = re.compile(r"   \.\.\.  \d+ more|  details    \d+ more lines with --verbose")
LAST = re.compile(r"  (time|result) ")


@pytest.fixture(scope="module")
def reports(shared):
    """Runs a scene of input/, and prints the report of its result again, whole."""
    made = {}

    def report(scene):
        if scene not in made:
            place = shared("screen")
            first = place.beamwave("run", PROJECT / "input" / scene)
            again = place.beamwave("run", PROJECT / "input" / scene, "--verbose")
            assert first.returncode in (0, 4) and again.returncode == 0, first.stderr
            made[scene] = first.stdout.splitlines(), again.stdout.splitlines(), place
        return made[scene]

    return report


@pytest.mark.parametrize("scene", SCENES)
def test_a_report_is_one_screen_and_says_how_to_see_the_rest(reports, scene):
    short, whole, _ = reports(scene)
    assert len(short) <= SCREEN
    kept = [line.removesuffix(" ...") for line in short if not CUT.fullmatch(line) and not LAST.match(line)]
    rest = iter(whole)
    assert all(line in rest for line in kept)  # in the same order, notes with their first line
    assert sum("--verbose" in line for line in short) == 1 or len(whole) <= len(kept) + 1  # that nothing was to do
    assert not any(CUT.fullmatch(line) for line in whole)


def test_a_whole_report_has_every_mode_and_event_of_the_file(reports):
    short, whole, place = reports("effects/contact.nml")
    result = place.result("contact")
    frequency = result["angular_frequency"] / (2 * np.pi)
    rows = [line.split() for line in whole if re.match(r" {4,5}\d+ +\d+\.", line)]
    np.testing.assert_allclose([float(row[4]) for row in rows], frequency, rtol=1e-6)
    assert sum(line.startswith("  contact ") for line in whole) == (result["event_kind"] > 0).sum()
    assert sum(bool(re.match(r" {4,5}\d+ +\d+\.", line)) for line in short) < len(rows)


def test_of_repeats_the_cases_stand_in_the_whole_report(reports):
    short, whole, _ = reports("tutorial/clamp.nml")
    for words in ["case   lines  strongest line", "Frequency response over the repeats", "beam, case 1", "beam, case 2"]:
        assert any(words in line for line in whole) and not any(words in line for line in short)
    for words in ["Pooled repeats", "Modal constants", "Identified", "Misfit: the model explains"]:
        assert any(words in line for line in short)


@pytest.mark.parametrize("scene", ["tutorial/clamp_rigid.nml", "identify.nml", "effects/contact.nml"])
def test_every_warning_is_on_the_screen(reports, scene):
    short, whole, _ = reports(scene)
    warnings = [line for line in whole if line.startswith("  warning: ")]
    assert warnings and set(warnings) <= set(short)


@pytest.mark.parametrize("command", ["run", "accuracy", "effects"])
def test_quiet_and_verbose_exclude_each_other(here, command):
    ended = here.beamwave(command, PROJECT / "input/paper/fig2.nml", "--quiet", "--verbose")
    assert ended.returncode == 2 and "accepted: one of them" in ended.stderr
    assert not ended.stdout
