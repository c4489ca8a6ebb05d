"""Bad scenes: all that is wrong is listed where it stands, nothing is written, and good scenes run all the same."""

import re
import resource

import pytest
from workplace import captured_beam, namelist

BAD = """\
&beam length = -1.0, diameter = 0.037, density = 7870.0,
  youngs_modulus = 2e11 /
&rotatoin angular_velocity = 50.0 /
&impact mass_ratio = heavy /
&capture /
&response duration = 1e999, samples = 3.5,
  colour = 5, samples = 12 /
"""
WRONG_IN_BAD = {
    (1, "beam%length"),
    (3, "&rotatoin"),
    (4, "impact%mass_ratio"),
    (6, "response%duration"),
    (6, "response%samples"),
    (7, "response%colour"),
    (7, "response%samples"),
}


def test_every_error_of_a_file_is_listed_where_it_stands(here):
    ended = here.beamwave("run", here.write("bad.nml", BAD))
    assert (ended.returncode, ended.stdout) == (2, "")
    listed = re.findall(r"^bad\.nml:(\d+): ([&%\w]+): .*accepted: ", ended.stderr, re.MULTILINE)
    listed = {(int(line), name) for line, name in listed}
    assert not WRONG_IN_BAD - listed
    assert here.left(".") == ["bad.nml"]


def test_what_is_absent_is_listed_without_a_line(here):
    ended = here.beamwave("run", here.write("empty.nml", "&beam length = 1.0 /\n"))
    assert ended.returncode == 2
    for name in ["density", "youngs_modulus"]:
        assert re.search(rf"^empty\.nml: beam%{name}: ", ended.stderr, re.MULTILINE)


PROMISED_FOR_LATER = ["stiffening", "shear", "damping", "release", "recontact"]


@pytest.mark.parametrize("group", PROMISED_FOR_LATER)
def test_a_group_that_is_not_built_is_refused(here, group):
    known = here.beamwave("describe").stdout
    if f"&{group}" in known:
        pytest.skip(f"&{group} is built")
    ended = here.beamwave("run", here.write("a.nml", namelist(captured_beam()) + f"&{group}\n/\n"))
    assert ended.returncode == 2
    assert f"&{group}" in ended.stderr


CONFLICTS = {
    "capture without impact": captured_beam(impact=None),
    "spectrum without response": captured_beam(spectrum={}),
    "a rebound's history without counts": captured_beam(
        capture=None, modes=None, response={"duration": 0.1, "samples": 64}
    ),
    "two masses": captured_beam(impact={"mass": 1.0}),
    "two counts for one set of modes": captured_beam(capture=None),
    "diameter beside area": captured_beam(beam={"area": 1e-3}),
    "release of a mass that was not captured": captured_beam(
        capture=None, modes={"before": 5, "after": 5}, release={"time": 0.01}
    ),
    "recontact of a captured mass": captured_beam(recontact={}, response={"duration": 0.1, "samples": 64}),
    "contacts without an end of the search": captured_beam(
        capture=None, modes={"before": 5, "after": 5}, recontact={}
    ),
    "damping of no kind": captured_beam(damping={}),
    "damping of two kinds": captured_beam(damping={"ratio": 0.01, "mass_proportional": 1.0}),
}


@pytest.mark.parametrize("scene", CONFLICTS.values(), ids=CONFLICTS.keys())
def test_groups_that_contradict_each_other_are_refused(here, scene):
    ended = here.beamwave("run", here.scene("a", scene))
    assert ended.returncode == 2, ended.stdout
    assert re.match(r"a\.nml(:\d+)?: ", ended.stderr)
    assert here.left(".") == ["a.nml"]


SWEEPS = {
    "one name twice": 2 * [{"parameter": "impact%mass_ratio", "values": [0.1, 0.2]}],
    "both of two exclusive names": [
        {"parameter": "impact%mass_ratio", "values": [0.1, 0.2]},
        {"parameter": "impact%mass", "values": [0.1, 0.2]},
    ],
    "an axis of the result": [{"parameter": "impact%profile_points", "values": [11, 21]}],
    "a word": [{"parameter": "rotation%plane", "values": [1, 2]}],
    "half a mode": [{"parameter": "modes%before", "values": [5, 5.5]}],
    "a group that is not there": [{"parameter": "response%duration", "values": [1.0, 2.0]}],
    "an unknown name": [{"parameter": "beam%colour", "values": [1.0, 2.0]}],
    "values beside a range": [
        {"parameter": "impact%mass_ratio", "values": [0.1], "first": 0.1, "last": 1.0, "count": 3}
    ],
}


@pytest.mark.parametrize("sweeps", SWEEPS.values(), ids=SWEEPS.keys())
def test_a_sweep_that_cannot_be_is_refused(here, sweeps):
    ended = here.beamwave("run", here.scene("a", captured_beam(), *sweeps))
    assert ended.returncode == 2, ended.stdout
    assert re.match(r"a\.nml(:\d+)?: ", ended.stderr)


def test_good_scenes_run_beside_bad_ones_and_the_highest_status_counts(here):
    here.scene("good", captured_beam())
    here.write("bad.nml", BAD)
    ended = here.beamwave("run", "bad.nml", "good.nml", "--quiet")
    assert ended.returncode == 2
    assert "bad.nml:1: beam%length" in ended.stderr
    assert here.left() == ["good.nc"]
    ended = here.beamwave("run", "missing.nml", "bad.nml", "good.nml")
    assert ended.returncode == 3
    assert "missing.nml" in ended.stderr


@pytest.mark.parametrize("text", ["&beam length=" + ";" * 10**7, "&scene title=" + " 'a'" * 300_000 + " /"])
def test_a_long_scene_takes_little_memory_and_says_little(here, text):
    here.write("a.nml", text)
    limited = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_AS, (600 * 2**20,) * 2)}
    if here.beamwave("--version", **limited).returncode != 0:
        pytest.skip("the program does not start in 600 MB, as under a sanitizer")
    ended = here.beamwave("check", "a.nml", **limited)
    assert ended.returncode == 2
    assert len(ended.stderr.splitlines()) <= 1001
    assert max(map(len, ended.stderr.splitlines())) < 500


def test_two_scenes_with_one_name_stop_everything(here):
    for name in ["a", "b", "sub/a"]:
        here.scene(name, captured_beam())
    ended = here.beamwave("run", "a.nml", "b.nml", "sub")
    assert ended.returncode == 2
    assert "sub/a.nml" in ended.stderr
    assert "a.nc" in ended.stderr
    assert not (here.directory / "output").exists()
