"""The scenes of the paper's figures give what its equations give and what it says in words."""

import re

import numpy as np
import pytest
from closed_form import CapturedBeam
from conftest import PROJECT

SPEEDS = [0.0, 50.0, 100.0]
FIGURES = [f"fig{number}" for number in range(2, 8)]


@pytest.fixture(scope="module")
def paper(shared):
    """Results of fig2 to fig7 by name."""
    place = shared("paper")
    ended = place.beamwave("run", PROJECT / "input/paper")
    assert (ended.returncode, ended.stderr) == (0, "")
    return {name: place.result(name) for name in FIGURES}


@pytest.mark.parametrize("name", ["fig2", "fig4", "fig5"])
def test_modes_and_waves_are_the_closed_form(paper, name):
    result = paper[name]
    np.testing.assert_array_equal(result["rotation_angular_velocity"], SPEEDS)
    for case, speed in enumerate(SPEEDS):
        beam = CapturedBeam(0.2, speed, before=20, after=20)
        for end, alpha in {"": beam.alpha, "_before": beam.alpha_before}.items():
            # α from 80 bisections in doubles is good to 1e-15; β of mode 1 loses a factor (hα²/β)² ≤ 3 of it
            np.testing.assert_allclose(result[f"alpha{end}"][case], alpha, rtol=4e-15)
            np.testing.assert_allclose(result[f"angular_frequency{end}"][case], beam.frequency(alpha), rtol=4e-14)
            np.testing.assert_allclose(result[f"phase_velocity{end}"][case], beam.phase_velocity(alpha), rtol=4e-14)
            np.testing.assert_allclose(result[f"group_velocity{end}"][case], beam.group_velocity(alpha), rtol=4e-14)


CHANGES = [("fig2", "angular_frequency", -1), ("fig4", "phase_velocity", -1), ("fig5", "group_velocity", 1)]


@pytest.mark.parametrize("figure, name, sign", CHANGES)
def test_rotation_changes_low_wave_numbers_most(paper, figure, name, sign):
    values = paper[figure][name]
    assert (sign * np.diff(values, axis=0) > 0).all()
    change = np.abs(values[1:] / values[0] - 1)
    assert (np.diff(change, axis=1) < 0).all()


def test_the_jump_gathers_at_the_tip_as_modes_are_added(paper):
    result = paper["fig3"]
    counts = np.array([5, 10, 20, 50])
    np.testing.assert_array_equal(result["mode_count"], counts)
    jump, position = result["velocity_jump"], result["profile_position"]
    # 4nγ/(1 + 4nγ) from shapes of value 2 at the tip, n of them summed
    np.testing.assert_allclose(jump[:, -1], 0.8 * counts / (1 + 0.8 * counts), rtol=1e-14 * counts.max())
    assert (np.diff(jump[:, -1]) > 0).all()
    inside = np.abs(jump[:, position < 0.9]).max(axis=1)
    assert (np.diff(inside) < 0).all()
    share = np.sum(jump**2 * (position > 0.95), axis=1) / np.sum(jump**2, axis=1)
    assert (np.diff(share) > 0).all()
    np.testing.assert_array_equal(jump[:, 0], 0.0)


@pytest.mark.parametrize("figure, swept", [("fig6", "rotation_angular_velocity"), ("fig7", "impact_mass_ratio")])
def test_displacements_are_the_closed_form(paper, figure, swept):
    result = paper[figure]
    for case, value in enumerate(result[swept]):
        ratio, speed = (0.2, value) if figure == "fig6" else (value, 50.0)
        beam = CapturedBeam(ratio, speed, before=40, after=40)
        expected = beam.displacement(result["point_position"], result["time"])
        # phases up to 2e5 rad in doubles are off by 3e-11, in modes that carry less than a hundredth of the peak
        np.testing.assert_allclose(result["displacement"][case], expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("figure", ["fig6", "fig7"])
def test_swings_of_the_midpoint_grow_with_rotation_and_mass(paper, figure):
    result = paper[figure]
    assert (np.diff(np.abs(result["displacement"]).max(axis=2)[:, 0]) > 0).all()
    assert (np.diff(result["angular_frequency"][:, 0]) < 0).all()


def relative_change(result, name):
    return result[name] / result[f"{name}_before"] - 1


def test_the_capture_slows_low_modes_most_and_more_in_a_rotating_beam(paper):
    for name in ["phase_velocity", "angular_frequency"]:
        change = relative_change(paper["fig4"], name)
        assert (change < 0).all()
        assert (np.diff(np.abs(change), axis=1) < 0).all()
        assert (np.diff(np.abs(change[:, 0])) > 0).all()
    first = relative_change(paper["fig4"], "phase_velocity")[:, 0]
    np.testing.assert_array_equal(np.round(100 * first, 1), [-13.8, -17.5, -37.9])


def test_group_velocity_does_not_follow_that_conclusion(paper):
    change = relative_change(paper["fig5"], "group_velocity")
    assert (np.diff(np.abs(change[:, 0])) < 0)[0]  # less, not more, from 0 to 50 rad/s
    assert change[0, 0] < 0 < change[2, 0]  # and at 100 rad/s the other way


def test_the_numbers_a_scene_promises_at_its_head_are_those_it_gives(paper):
    def promised(name):
        head = (PROJECT / f"input/paper/{name}.nml").read_text(encoding="utf-8").splitlines()[1]
        return [float(number) for number in re.findall(r"\d+\.\d+", head)]

    first = {name: paper[name] for name in FIGURES}
    assert promised("fig2") == np.round(first["fig2"]["angular_frequency"][:, 0], 1).tolist()
    assert promised("fig3") == np.round(first["fig3"]["velocity_jump"][:, -1], 3).tolist()
    assert promised("fig4") == np.round(first["fig4"]["phase_velocity"][:, 0], 1).tolist()
    assert promised("fig5") == np.round(first["fig5"]["group_velocity"][:, 0], 1).tolist()
    for name in ["fig6", "fig7"]:
        assert promised(name) == np.round(2000 * np.pi / first[name]["angular_frequency"][:, 0], 1).tolist()
