"""The same scene gives the same bits, however often, in whatever units, and from the scene that its result holds."""

import re

import numpy as np
import pytest
import results
from ring_downs import text_of
from workplace import captured_beam

EVERYTHING = captured_beam(
    scene={"title": "it's all"},
    modes={"before": 40, "after": 30},
    response={"duration": 0.5, "samples": 4096, "points": [0.25, 0.5, 1.0], "velocity": True},
    spectrum={"max_peaks": 12},
)
SWEEPS = [
    {"parameter": "rotation%angular_velocity", "first": 1.0, "last": 100.0, "count": 3, "spacing": "log"},
    {"parameter": "impact%mass_ratio", "values": [0.1, 1.0 / 3.0]},
]


@pytest.mark.parametrize("sweeps", [[], SWEEPS], ids=["one case", "sweep"])
def test_two_runs_give_the_same_bits(here, sweeps):
    first = here.simulate("a", EVERYTHING, *sweeps)
    assert results.differences(here.run("a", "--overwrite"), first) == []
    assert here.beamwave("run", "a.nml", "--output", "again").returncode == 0
    assert results.differences(here.result("a", "again"), first) == []


@pytest.mark.parametrize("sweeps", [[], SWEEPS], ids=["one case", "sweep"])
def test_the_scene_in_a_result_gives_the_same_values(here, sweeps):
    first = here.simulate("a", EVERYTHING, *sweeps)
    (here.directory / "resolved").mkdir()
    here.write("resolved/a.nml", first.attributes["scene"])
    assert "nothing to do" in here.beamwave("run", "resolved/a.nml").stdout
    assert here.beamwave("run", "resolved", "--output", "again").returncode == 0
    assert results.differences(here.result("a", "again"), first) == ["given"]  # its defaults are given now


MEMORY = [  # as glibc hands it out: other blocks, their places and what is left in them
    {"MALLOC_PERTURB_": "165"},
    {"MALLOC_MMAP_THRESHOLD_": "128", "MALLOC_PERTURB_": "90"},
    {"GLIBC_TUNABLES": "glibc.malloc.tcache_count=0", "MALLOC_TOP_PAD_": "1000000"},
]


@pytest.mark.parametrize("kind", ["simulated", "recorded"])
def test_no_bit_depends_on_the_memory_that_a_run_is_given(here, monkeypatch, kind):
    if kind == "simulated":
        here.scene("a", EVERYTHING, *SWEEPS)
    else:
        here.write("ring.csv", text_of(1))
        record = {"file": "ring.csv", "points": [0.5, 1.0]}
        beam = {"length": 0.6, "density": 2700.0, "width": 0.03, "height": 0.018, "youngs_modulus": 69e9}
        stiffness = {"parameter": "support%rotational_stiffness", "first": 1e3, "last": 1e5, "count": 9, "spacing": "log"}
        here.scene("a", {"beam": beam, "support": {"rotational_stiffness": 1e3}, "record": record, "spectrum": {}}, stiffness)
    first = here.run("a", status=0)
    for names in MEMORY:
        with monkeypatch.context() as own:
            for name, value in names.items():
                own.setenv(name, value)
            assert results.differences(here.run("a", "--overwrite"), first) == []


# what the units of a scene's inputs count of metre, kilogram and second
DIMENSIONS = {
    "length": (1, 0, 0),
    "diameter": (1, 0, 0),
    "density": (-3, 1, 0),
    "youngs_modulus": (-1, 1, -2),
    "angular_velocity": (0, 0, -1),
    "approach_velocity": (1, 0, -1),
    "mass": (0, 1, 0),
    "duration": (0, 0, 1),
}
UNITS = {
    "m": (1, 0, 0),
    "kg": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "J": (2, 1, -2),
    "Pa": (-1, 1, -2),
    "Hz": (0, 0, -1),
    "rad": (0, 0, 0),
    "1": (0, 0, 0),
}


def in_other_units(scene, powers):
    """The scene with metre, kilogram and second made 2**-power as long."""

    def scaled(name, value):
        return value * 2.0 ** int(np.dot(DIMENSIONS[name], powers)) if name in DIMENSIONS else value

    return {group: {name: scaled(name, value) for name, value in values.items()} for group, values in scene.items()}


def power_of(units, powers):
    """The power of two by which a number in UDUNITS' `units` grows."""
    terms = [re.fullmatch(r"([A-Za-z]+|1)(-?\d+)?", term).groups() for term in units.split()]
    return sum(int(exponent or 1) * np.dot(UNITS[name], powers) for name, exponent in terms)


@pytest.mark.parametrize("powers", [(7, 0, 0), (0, -11, 0), (0, 0, 5), (-3, 4, -6)])
def test_units_changed_by_powers_of_two_give_the_same_bits(here, powers):
    scene = {**EVERYTHING, "impact": {"mass": 1.7, "approach_velocity": 1.5}}
    si, other = here.simulate("si", scene), here.simulate("other", in_other_units(scene, powers))
    assert si.variables.keys() == other.variables.keys()
    for name, variable in si.variables.items():
        if name == "stage_seconds":
            continue
        scale = 2.0 ** power_of(variable.attributes["units"], powers)
        there = ~results.is_fill(variable.values)
        np.testing.assert_array_equal(there, ~results.is_fill(other[name]), err_msg=name)
        np.testing.assert_array_equal(other[name][there], variable.values[there] * scale, err_msg=name)
