"""`beamwave effects`: what each effect changes, from runs with it and without it."""

import re
from pathlib import Path

import numpy as np
import pytest
import results
from workplace import captured_beam

PROJECT = Path(__file__).parents[2]
WORDS = tuple(re.findall(r"`(\w+)`", (PROJECT / "docs/input.md").read_text(encoding="utf-8").split("effects` compares\n")[1]))
OFF, ON, NOT_COMBINED = 1, 2, 3
PAPER = captured_beam(modes={"before": 40, "after": 40}, response={"duration": 0.05, "samples": 512})


@pytest.fixture(scope="module")
def studied(shared):
    """The paper's scene, studied."""
    here = shared("effects")
    here.scene("paper", PAPER)
    ended = here.beamwave("effects", "paper.nml", status=0)
    return here, ended, here.dataset("paper.effects")


def row(ds, effect):
    return ds.sel(effect=WORDS.index(effect) + 1)


def test_the_file_opens_with_its_words_and_without_a_number_that_is_none(studied):
    here, _, ds = studied
    assert ds["effect"].attrs["flag_meanings"].split() == list(WORDS)
    assert ds["effect_state"].attrs["flag_meanings"] == "off on not_combined"
    assert ds.attrs["study"] == "effects" and ds.attrs["Conventions"] == "CF-1.11"
    raw = results.read(here.directory / "output/paper.effects.nc")
    for name, variable in raw.variables.items():
        assert "units" in variable.attributes and "long_name" in variable.attributes, name
        assert np.isfinite(variable.values).all(), name


def test_what_is_on_off_and_impossible_is_told_apart(studied):
    _, _, ds = studied
    states = dict(zip(WORDS, ds["effect_state"].values))
    assert {name for name, state in states.items() if state == ON} == {"rotation", "capture"}
    assert {name for name, state in states.items() if state == NOT_COMBINED} == {"recontact", "hub"}
    assert "hub: &hub: needs &stiffening" in ds.attrs["remarks"] or "needs &stiffening if the beam rotates" in ds.attrs["remarks"]
    assert "recontact: excludes &capture" in ds.attrs["remarks"]
    assert "shear: tried with poisson_ratio = 0.3" in ds.attrs["remarks"]
    assert np.isnan(row(ds, "recontact")["frequency_change"]).all()


def test_the_three_facts_of_the_paper_s_beam(studied):
    """Rotation lowers mode 1 by 9 %, with its tension mode 1 rises by 2 %, shear takes 12 % off mode 10."""
    _, _, ds = studied
    facts = (  # rad/s with and without, by power series and the exponential of a matrix in 60 digits
        ("rotation", 1, 111.1009073259, 121.8335405734, -0.09),
        ("rotation_with_tension", 1, 123.7888525707, 121.8335405734, 0.02),
        ("shear", 10, 34826.46923442, 39591.86441446, -0.12),
    )
    for effect, mode, with_it, without, rough in facts:
        there = row(ds, effect).sel(mode=mode)
        # What the Galerkin basis promises, and closed forms keep.
        assert float(there["angular_frequency_with"]) == pytest.approx(with_it, rel=1e-10), effect
        assert float(there["angular_frequency_without"]) == pytest.approx(without, rel=1e-10), effect
        change = float(there["frequency_change"])
        assert change == pytest.approx(with_it / without - 1, abs=1e-9), effect
        assert change == pytest.approx(rough, abs=0.005), effect


def test_the_numbers_are_those_of_running_both_scenes(studied):
    here, _, ds = studied
    here.scene("with", PAPER)
    here.scene("without", captured_beam(rotation=None, modes=PAPER["modes"], response=PAPER["response"]))
    one, other = here.run("with"), here.run("without")
    found = row(ds, "rotation")
    for result, name in ((one, "angular_frequency_with"), (other, "angular_frequency_without")):
        np.testing.assert_array_equal(found[name].values, result["angular_frequency"][:10])
    difference = np.abs(one["displacement"] - other["displacement"]).max() / np.abs(one["displacement"]).max()
    assert float(found["response_change"]) == pytest.approx(difference, rel=1e-12)  # a few roundings
    for name in ("phase_velocity", "group_velocity"):
        change = one[name][:10] / other[name][:10] - 1
        np.testing.assert_allclose(found[f"{name}_change"], change, atol=1e-14)


def test_the_table_in_the_readme_is_what_the_program_prints(here):
    """Frequencies and wave velocities, which are the same wherever they are computed; not the response, nor the time."""
    readme = (PROJECT / "README.md").read_text(encoding="utf-8")
    scene = re.search(r"```fortran\n(.*?)```", readme, re.DOTALL)[1]
    here.write("scene.nml", re.sub(r"^&(response|spectrum).*\n", "", scene, flags=re.MULTILINE))
    ended = here.beamwave("effects", "scene.nml", status=0)
    table = re.search(r"^  effect +state.*?\n(.*?)^```", readme, re.DOTALL | re.MULTILINE)[1]
    rows = [re.split(r"\s{2,}", line.strip()) for line in table.splitlines()]
    assert len(rows) == 5
    printed = [re.split(r"\s{2,}", line.strip()) for line in ended.stdout.splitlines()]
    for row in rows:
        assert row[:7] in [line[:7] for line in printed], row


def test_an_effect_matters_from_the_first_mode_that_it_changes_by_more_than_the_tolerance(here):
    response = {"duration": 0.01, "samples": 16}
    scene = captured_beam(rotation={"angular_velocity": 1.0}, modes=None, response=response)
    ds = here.study("effects", "slow", {**scene, "modes": {"tolerance": 1e-5}})
    assert float(ds["frequency_tolerance"]) == 1e-5
    rotation = row(ds, "rotation")
    first = int(rotation["matters_from_mode"])
    larger = np.abs(rotation["frequency_change"].values) > 1e-5
    # 1 rad/s takes (1/121.8)²/2 = 3.4e-5 off mode 1, (1/849)²/2 = 7e-7 off mode 2.
    assert first == 1 and larger.tolist() == [True] + 9 * [False]


def test_a_scene_that_asks_for_no_tolerance_is_held_against_one_per_cent(here):
    here.scene("slow", captured_beam(rotation={"angular_velocity": 1.0}))
    ended = here.beamwave("effects", "slow.nml")
    assert "more than 1 %,\n  since the scene has no tolerance" in ended.stdout
    ds = here.dataset("slow.effects")
    assert float(ds["frequency_tolerance"]) == 0.01
    assert int(row(ds, "rotation")["matters_from_mode"]) == 0  # 3.4e-5 of mode 1


def test_counts_are_held_against_the_error_that_they_leave(studied):
    here, _, ds = studied
    run = here.run("paper")
    left = np.max(run["displacement_error"]) / np.abs(run["displacement"]).max()
    assert float(ds["frequency_tolerance"]) == pytest.approx(left, rel=1e-12)


def test_the_report_holds_a_row_for_each_effect_and_the_time_it_costs(studied):
    _, ended, ds = studied
    for word in WORDS:
        assert f"\n  {word.replace('_', ' ')} " in ended.stdout
    assert "matters from mode 1 on" in ended.stdout and "excludes &capture" in ended.stdout
    measured = ds["effect_state"] != NOT_COMBINED
    assert (ds["seconds_with"][measured] > 0).all() and (ds["seconds_without"][measured] > 0).all()
    np.testing.assert_allclose(ds["cost"], ds["seconds_with"] / ds["seconds_without"])


def test_a_study_that_is_there_is_left_alone(studied):
    here, _, _ = studied
    again = here.beamwave("effects", "paper.nml")
    assert again.returncode == 0 and "nothing to do" in again.stdout
    here.scene("paper", captured_beam())
    other = here.beamwave("effects", "paper.nml")
    assert other.returncode == 3 and "--overwrite" in other.stderr


def test_a_beam_of_pieces_with_a_support_and_bodies_is_studied(here):
    scene = {"beam": {"length": [0.5, 0.5], "diameter": [0.037, 0.025], "density": 7870.0, "youngs_modulus": 2e11},
             "support": {"rotational_stiffness": 1e5}, "body": {"position": 0.5, "mass": 0.01},
             "impact": {"mass_ratio": 0.2, "position": 0.8}, "capture": {}, "modes": {"before": 10, "after": 10},
             "response": {"duration": 0.01, "samples": 32}}
    ds = here.study("effects", "pieces", scene)
    states = dict(zip(WORDS, ds["effect_state"].values))
    assert {name for name, state in states.items() if state == ON} == {"capture", "pieces", "support", "body", "position"}
    assert ds["beam_diameter"].dims == ("piece",)
    # a beam of the same mass and the mean stiffness has none of its stiffness where it bends the most
    assert float(row(ds, "pieces")["frequency_change"].sel(mode=1)) > 0
    # a mass away from the tip takes less off the frequency of mode 1, and a rigid clamp nothing
    assert float(row(ds, "position")["frequency_change"].sel(mode=1)) > 0
    assert float(row(ds, "support")["frequency_change"].sel(mode=1)) < 0
    assert float(row(ds, "body")["frequency_change"].sel(mode=1)) < 0


def test_a_speed_is_tried_that_the_beam_of_pieces_holds(here):
    """0.4 of what its own first mode allows: that takes 1 - sqrt(1 - 0.16) off its frequency."""
    beam = {"length": [0.5, 0.5], "diameter": [0.037, 0.01], "density": 7870.0, "youngs_modulus": 2e11}
    support, body = {"rotational_stiffness": 1e3}, {"position": 1.0, "mass": 0.5}
    ds = here.study("effects", "pieces", {"beam": beam, "support": support, "body": body, "modes": {"before": 3}})
    change = float(row(ds, "rotation")["frequency_change"].sel(mode=1))
    assert change == pytest.approx(np.sqrt(1 - 0.4**2) - 1, rel=0.02)  # three digits of the speed


def test_effects_that_are_on_are_taken_off(here):
    scene = captured_beam(stiffening={}, shear={}, damping={"ratio": 0.02}, capture={"rotary_inertia": 1e-3})
    scene = {**scene, "release": {"time": 0.01}, "response": {"duration": 0.02, "samples": 64}}
    ds = here.study("effects", "all", scene)
    states = dict(zip(WORDS, ds["effect_state"].values))
    off = {"out_of_plane", "contact", "force", "base", "initial", "pieces", "taper", "support", "tip_support", "hub", "body"}
    off |= {"position"}
    assert {name for name, state in states.items() if state == OFF} == off
    assert {name for name, state in states.items() if state == NOT_COMBINED} == {"recontact"}
    # A ratio ζ takes ζ²/2 off the frequency of bending alone, more off that of mode 1, which rotation has lowered.
    assert float(row(ds, "damping")["frequency_change"].sel(mode=5)) == pytest.approx(-2e-4, rel=0.1)
    # A release changes no mode of beam and mass, and the motion after it.
    assert (row(ds, "release")["frequency_change"] == 0).all() and float(row(ds, "release")["response_change"]) > 0


def test_a_rebound_is_studied_beside_a_capture_and_contacts(here):
    scene = captured_beam(capture=None, response={"duration": 0.01, "samples": 64})
    ds = here.study("effects", "rebound", {**scene, "modes": {"before": 5}})
    states = dict(zip(WORDS, ds["effect_state"].values))
    assert states["capture"] == OFF and states["recontact"] == OFF
    assert states["release"] == states["body_inertia"] == NOT_COMBINED
    assert np.isnan(ds["frequency_change"].sel(mode=slice(6, 10))).all()


def test_of_a_sweep_the_first_case_is_studied_and_that_is_said(here):
    sweep = {"parameter": "rotation%angular_velocity", "values": [50.0, 10.0]}
    here.scene("sweep", captured_beam(rotation={}), sweep)
    ended = here.beamwave("effects", "sweep.nml")
    assert ended.returncode == 0 and "Of 2 cases only the first is measured" in ended.stdout.split("effect  ")[0]
    ds = here.dataset("sweep.effects")
    assert float(ds["rotation_angular_velocity"]) == 50.0


def test_a_row_without_numbers_has_no_verdict_and_says_why(here):
    """Effects with which the tolerance is out of reach: what needs a history has no verdict, and each run's reason stands once."""
    groups = {"rotation": None, "modes": None, "response": {"duration": 0.01, "samples": 4}}
    here.scene("fine", {**captured_beam(**groups), "modes": {"tolerance": 1e-9}})
    ended = here.beamwave("effects", "fine.nml", status=4)
    warnings = [line for line in ended.stdout.splitlines() if "warning: not trusted: " in line]
    for effect in ("shear", "release"):
        reason = f" {effect} (the run with it): tolerance: 1e-9 cannot be reached"
        assert sum(reason in line for line in warnings) == 1, ended.stdout
    (release,) = [line for line in ended.stdout.splitlines() if re.match(r" +release +off ", line)]
    (shear,) = [line for line in ended.stdout.splitlines() if re.match(r" +shear +off ", line)]
    assert release.split()[-3:] == ["-", "-", "-"]  # response, time, verdict
    assert shear.endswith("-       -   matters from mode 1 on")  # its frequencies are known
    ds = here.dataset("fine.effects")
    assert np.isnan(row(ds, "release")["response_change"]) and np.isnan(row(ds, "shear")["response_change"])
    assert float(row(ds, "damping")["response_change"]) > 0
    assert "(the run with it): tolerance: 1e-9" in ds.attrs["notes"]


def test_wrong_words_are_refused(here):
    here.scene("a", captured_beam())
    assert here.beamwave("effects").returncode == 2
    assert here.beamwave("effects", "a.nml", "a.nml").returncode == 2
    assert here.beamwave("effects", "a.nml", "--max-seconds", "1").returncode == 2
    assert here.beamwave("effects", "absent.nml").returncode == 3
    assert here.left(".") == ["a.nml"]
