"""Scenes whose numbers are far outside anything that can be built: refused with their place, or run to numbers and fill.

By hand it takes as many as wanted: `BEAMWAVE_SCENES=2000 BEAMWAVE_SEED=0 .venv/bin/python -m pytest -s tests/scenes/test_extremes.py`.
"""

import os
import re
import shutil

import numpy as np
import pytest
from extreme_scenes import extreme_text

SCENES = int(os.environ.get("BEAMWAVE_SCENES", "48"))
SEED = int(os.environ.get("BEAMWAVE_SEED", "1"))
CHUNK = 24
FOUND = [26, 95, 1411, 1417, 3084, 7000660, 7001665]  # of longer runs by hand, each a kind of its own
NO_NUMBER = re.compile(r"\b(NaN|Inf|Infinity)\b|\*{5}")
RIGID = [1e60, 1e100, 1e140, 1e200, 1e290]
BEAM = "&beam length=1, density=7870, youngs_modulus=2e11, diameter=0.037 /\n"
STRUCK = "&impact mass_ratio=0.2, position=0.7 / &capture / &modes before=30 / &response duration=0.1, samples=64, velocity=T /\n"


@pytest.mark.parametrize("seeds", [FOUND, *(range(n, n + CHUNK) for n in range(SEED * 10**6, SEED * 10**6 + SCENES, CHUNK))])
def test_no_number_is_lost(here, seeds):
    ends = {}
    for seed in seeds:
        ended = here.beamwave("run", here.write("a.nml", extreme_text(seed)), "--overwrite", "--max-seconds", "5")
        ends[ended.returncode] = ends.get(ended.returncode, 0) + 1
        said = f"seed {seed}: status {ended.returncode}: {ended.stderr}"
        assert ended.returncode in (0, 2, 4, 5), said
        assert not NO_NUMBER.search(ended.stdout + ended.stderr), said
        if ended.returncode == 2:
            assert all(re.match(r"a\.nml(:\d+)?: &?\w+", line) for line in ended.stderr.splitlines()), said
        if ended.returncode == 5:
            shutil.rmtree(here.directory / "output", ignore_errors=True)
        if ended.returncode not in (0, 4):
            assert here.left() == [], said
            continue
        result = here.result("a")
        lost = [name for name, item in result.variables.items() if not np.isfinite(item.values).all()]
        assert not lost, f"{said}{lost}"
        assert "fault of the program" not in result.attributes["notes"], said
        (here.directory / "output/a.nc").unlink()
    print(f"statuses of {len(seeds)} scenes from seed {seeds[0]}: {ends}")


@pytest.mark.parametrize("spring", ["stiffness", "rotational_stiffness"])
@pytest.mark.parametrize("group", ["support", "body position=0.4, mass=0,"])
def test_a_spring_beyond_what_numbers_tell_apart_is_rigid(here, group, spring):
    """All alike to the last digits, and a root that such springs hold is clamped."""
    found = []
    for stiffness in RIGID:
        here.write("a.nml", f"{BEAM}&{group} {spring}={stiffness} /\n{STRUCK}")
        found.append(here.run("a", "--overwrite"))
    if group == "support":
        here.write("a.nml", BEAM + STRUCK)
        found.append(here.run("a", "--overwrite"))
    for other in found[1:]:
        for name in ["angular_frequency", "angular_frequency_before"]:
            np.testing.assert_allclose(other[name], found[0][name], rtol=1e-14)
        for name in ["displacement", "velocity", "displacement_error"]:
            scale = np.abs(found[0][name]).max()
            np.testing.assert_allclose(other[name], found[0][name], atol=1e-11 * scale)


@pytest.mark.parametrize("stiffness", [1e20, 1e24, 1e28, 1e32, 1e40])
def test_between_stiff_and_rigid_no_mode_is_lost(here, stiffness):
    """Modes of a root on springs differ from those of a clamped one by about α²/κ, also where long records ask for all their digits."""
    here.write("a.nml", BEAM + STRUCK)
    clamped = here.run("a")["angular_frequency"]
    for spring in ["stiffness", "rotational_stiffness"]:
        here.write("b.nml", f"{BEAM}&support {spring}={stiffness} /\n{STRUCK}")
        np.testing.assert_allclose(here.run("b", "--overwrite")["angular_frequency"], clamped, rtol=2e-11)


def test_a_frequency_with_more_modes_below_than_are_counted_is_no_fault(here):
    """Where sections hardly slide and turn easily a bracket of the first mode runs into frequencies of 1e9 half waves and more."""
    beam = "&beam length=0.62, density=4525, youngs_modulus=1.08e-67, area=4.82e-41, second_moment=5.35e-8 /\n"
    held = "&support rotational_stiffness=187489 /\n&shear shear_coefficient=0.85 /\n"
    bodies = "&body position=0.277, mass=1.01, stiffness=103161 /\n&body position=0.166, mass=1.74, stiffness=6302 /\n"
    here.write("a.nml", beam + held + bodies + STRUCK.replace("mass_ratio=0.2", "mass=1.24"))
    ended = here.beamwave("run", "a.nml", "--max-seconds", "20")
    assert ended.returncode in (0, 4), ended.stderr


@pytest.mark.parametrize("modulus", [1e-12, 1e-18])
@pytest.mark.parametrize("shear", ["", "&shear /\n"])
def test_modes_of_a_piece_that_is_far_softer_than_the_first_are_its_own(here, modulus, shear):
    """On the rigid piece inboard of it, it is a clamped beam."""
    both = BEAM.replace("length=1,", "length=1, 1,")
    here.write("a.nml", both.replace("2e11", f"2e11, {modulus}") + shear + "&modes before=70 /\n")
    here.write("b.nml", BEAM.replace("2e11", str(modulus)) + shear + "&modes before=70 /\n")
    result, alone = here.run("a"), here.run("b")
    np.testing.assert_allclose(result["angular_frequency"], alone["angular_frequency"], rtol=1e-12)
