"""Damped modes in whole runs: their frequencies and rates, their histories, the tolerance, and no damping as the limit."""

import numpy as np
import pytest
import results
from closed_form import CapturedBeam, shapes
from conftest import PROJECT
from workplace import captured_beam

RATIO = 0.03
RAYLEIGH = {"mass_proportional": 4.0, "stiffness_proportional": 5e-6}  # 1/s, s
RESPONSE = {"duration": 0.25, "samples": 512, "points": [0.5, 1.0], "velocity": True}
PAPER = CapturedBeam(0.2, 50.0, before=12, after=10)


def rates(damping):
    """c of each mode, 1/s."""
    bending = PAPER.h * PAPER.alpha**2
    if "ratio" in damping:
        return 2 * damping["ratio"] * bending
    return damping["mass_proportional"] + damping["stiffness_proportional"] * bending**2


def eigenvalues(damping):
    """Both roots of s² + cs + β² = 0, the slower first."""
    roots = [np.roots([1, c, beta**2]) for c, beta in zip(rates(damping), PAPER.frequency(PAPER.alpha))]
    return np.array([pair[np.argsort(-pair.real)] for pair in roots])


def history(damping, position, time):
    """Displacement and velocity, (position, time)."""
    s = eigenvalues(damping)[:, :, np.newaxis]
    start = PAPER.modal_velocity()[:, np.newaxis] / (s[:, 0] - s[:, 1])
    grown = np.exp(s * time)
    modal = start * (grown[:, 0] - grown[:, 1]), start * (s[:, 0] * grown[:, 0] - s[:, 1] * grown[:, 1])
    return [shapes(PAPER.alpha, position) @ values.real for values in modal]


@pytest.mark.parametrize("damping", [{"ratio": RATIO}, RAYLEIGH], ids=["ratio", "Rayleigh"])
def test_frequencies_rates_and_histories_are_those_of_the_characteristic_equation(here, damping):
    result = here.simulate("a", captured_beam(damping=damping, response=RESPONSE))
    s = eigenvalues(damping)
    turns = s[:, 0].imag != 0
    # numpy's roots of a quadratic with real roots c apart: a rounding of c, 1e3 times the slow one
    np.testing.assert_allclose(result["growth_rate"], s[:, 0].real, rtol=1e-12)
    np.testing.assert_allclose(result["angular_frequency"][turns], np.abs(s[turns, 0].imag), rtol=1e-12)
    assert results.is_fill(result["angular_frequency"][~turns]).all()
    np.testing.assert_allclose(result["phase_velocity"], PAPER.phase_velocity(PAPER.alpha), rtol=1e-12)
    np.testing.assert_allclose(result["group_velocity"], PAPER.group_velocity(PAPER.alpha), rtol=1e-12)
    displacement, velocity = history(damping, [0.5, 1.0], result["time"])
    np.testing.assert_allclose(result["displacement"], displacement, atol=1e-11 * np.abs(displacement).max())
    np.testing.assert_allclose(result["velocity"], velocity, atol=1e-11 * np.abs(velocity).max())
    assert result.attributes["effects"] == "rotation damping impact capture"


def test_stiffness_proportional_damping_overdamps_high_modes(here):
    result = here.simulate("a", captured_beam(damping={"stiffness_proportional": 1e-4}, response=RESPONSE))
    overdamped = results.is_fill(result["angular_frequency"])
    np.testing.assert_array_equal(overdamped, 1e-4 * PAPER.h * PAPER.alpha**2 > 2)
    assert 0 < overdamped.sum() < 10
    assert (result["growth_rate"] < 0).all()


@pytest.mark.parametrize("shear", [None, {}], ids=["closed form", "pieces"])
def test_at_the_critical_ratio_nothing_turns_and_near_it_every_digit_counts(here, shear):
    """A beam at rest: β √(1 − ζ²) of every mode, 0 at ζ = 1, and beyond it −β(ζ − √(ζ² − 1))."""
    scene = captured_beam(rotation=None, shear=shear)
    undamped = here.simulate("undamped", scene)["angular_frequency"]
    for name, ratio in [("at", 1.0), ("below", 1 - 1e-12), ("above", 1 + 1e-12), ("far", 30.0)]:
        result = here.simulate(name, {**scene, "damping": {"ratio": ratio}})
        apart = np.sqrt(abs(1 - ratio) * (1 + ratio))  # 1 − ζ is exact
        if ratio <= 1:
            np.testing.assert_allclose(result["angular_frequency"], undamped * apart, rtol=1e-13)
            np.testing.assert_allclose(result["growth_rate"], -ratio * undamped, rtol=1e-13)
        else:
            assert results.is_fill(result["angular_frequency"]).all()
            np.testing.assert_allclose(result["growth_rate"], -undamped / (ratio + apart), rtol=1e-13)
    np.testing.assert_array_equal(here.result("at")["angular_frequency"], 0.0)


@pytest.mark.parametrize("groups", [{}, {"shear": {}}, {"stiffening": {}}], ids=["closed form", "shear", "tension"])
def test_a_slow_rotation_at_the_critical_ratio_adds_what_it_adds(here, groups):
    """In plane β² = λ + ρ with ρ in ω²: where ρ < 0 the rates are −c/2 ± √−ρ, where ρ > 0, by tension, a mode turns at √ρ."""
    rates = {}
    for speed in [0.0, 1e-3, 1.0]:
        here.scene("a", captured_beam(rotation={"angular_velocity": speed}, damping={"ratio": 1.0}, **groups))
        rates[speed] = here.run("a", "--overwrite")
    still, slow, faster = rates.values()
    np.testing.assert_array_equal(still["angular_frequency"], 0.0)
    if "stiffening" in groups:
        np.testing.assert_allclose(slow["angular_frequency"], 1e-3 * faster["angular_frequency"], rtol=1e-3)
    else:
        assert results.is_fill(slow["angular_frequency"]).all()
        apart = [result["growth_rate"] - still["growth_rate"] for result in (slow, faster)]
        # of rates up to 4e4, rounded
        np.testing.assert_allclose(apart[0], 1e-3 * apart[1], rtol=1e-2, atol=1e-10)


def test_the_weakest_damping_is_none(here):
    without = here.simulate("a", captured_beam(response=RESPONSE))
    peak = np.abs(without["displacement"]).max()
    for name, damping in [("b", {"ratio": 0.0}), ("c", {"ratio": 1e-13}), ("d", {"mass_proportional": 1e-10})]:
        here.scene(name, captured_beam(damping=damping, response=RESPONSE))
        # c t/2 < 2e-9 of mode 10, which is 1e-3 of the whole; of mode 1 1e-11
        np.testing.assert_allclose(here.run(name)["displacement"], without["displacement"], atol=1e-11 * peak)


def test_a_growing_mode_grows_more_slowly(here):
    fast = {"angular_velocity": 300.0}
    result = here.simulate("a", captured_beam(rotation=fast, damping={"mass_proportional": 40.0}, response=RESPONSE))
    beta = np.sqrt(300.0**2 - (PAPER.h * PAPER.alpha[0] ** 2) ** 2)
    np.testing.assert_allclose(result["growth_rate"][0], np.hypot(beta, 20.0) - 20.0, rtol=1e-13)
    tip = result["displacement"][1]
    grown = np.log(np.abs(tip[-1] / tip[-101])) / (result["time"][-1] - result["time"][-101])
    np.testing.assert_allclose(grown, result["growth_rate"][0], rtol=1e-9)  # the rest is e^(-40) of it


def test_the_scene_shows_what_its_head_says(here):
    here.beamwave("run", PROJECT / "input/effects/damping.nml", status=0)
    result = here.result("damping")
    assert f"{result['angular_frequency'][0]:.1f}" == "111.1"
    late = result["time"] > 0.5
    time, tip = result["time"][late], result["displacement"][1, late]
    swing = np.exp((result["growth_rate"][0] + 1j * result["angular_frequency"][0]) * time)
    basis = np.stack([swing.real, swing.imag], axis=1)
    rest = tip - basis @ np.linalg.lstsq(basis, tip, rcond=None)[0]
    assert np.abs(rest).max() < 0.01 * np.abs(tip).max()
