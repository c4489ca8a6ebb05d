"""Bad scenes: all that is wrong is listed where it stands, nothing is written, and good scenes run all the same."""

import re
import resource

import pytest
from workplace import captured_beam

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


def test_good_scenes_run_beside_bad_ones_and_the_highest_status_counts(here):
    here.scene("good", captured_beam())
    here.write("bad.nml", BAD)
    ended = here.beamwave("run", "bad.nml", "good.nml", "--quiet", status=2)
    assert "bad.nml:1: beam%length" in ended.stderr
    assert here.left() == ["good.nc"]
    ended = here.beamwave("run", "missing.nml", "bad.nml", "good.nml", status=3)
    assert "missing.nml" in ended.stderr


@pytest.mark.parametrize("text", ["&beam length=" + ";" * 10**7, "&scene title=" + " 'a'" * 300_000 + " /"])
def test_a_long_scene_takes_little_memory_and_says_little(here, text):
    here.write("a.nml", text)
    limited = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_AS, (600 * 2**20,) * 2)}
    if here.beamwave("--version", **limited).returncode != 0:
        pytest.skip("the program does not start in 600 MB, as under a sanitizer")
    ended = here.beamwave("check", "a.nml", **limited, status=2)
    assert len(ended.stderr.splitlines()) <= 1001
    assert max(map(len, ended.stderr.splitlines())) < 500


def test_two_scenes_with_one_name_stop_everything(here):
    for name in ["a", "b", "sub/a"]:
        here.scene(name, captured_beam())
    ended = here.beamwave("run", "a.nml", "b.nml", "sub", status=2)
    assert "sub/a.nml" in ended.stderr
    assert "a.nc" in ended.stderr
    assert not (here.directory / "output").exists()
