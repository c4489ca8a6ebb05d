"""A tip that is held: rigid, pinned, by springs; exact modes of pieces and Galerkin's, against closed forms."""

import re

import mpmath as mp
import numpy as np
import pytest
from conftest import PROJECT
from workplace import PAPER_BEAM, captured_beam

H = 0.037 / 4 * np.sqrt(2e11 / 7870)
PINNED = {"rotational_stiffness": 0.0}
ENDS = {  # groups, and the frequency equation with guesses of its roots alpha
    "clamped_clamped": ({"tip_support": {}}, lambda x: mp.cos(x) - mp.sech(x), lambda k: (k + 0.5) * mp.pi),
    "clamped_pinned": ({"tip_support": PINNED}, lambda x: mp.tan(x) - mp.tanh(x), lambda k: (k + 0.25) * mp.pi),
    "clamped_sliding": ({"tip_support": {"stiffness": 0.0}}, lambda x: mp.tan(x) + mp.tanh(x), lambda k: (k - 0.25) * mp.pi),
    "pinned_pinned": ({"support": PINNED, "tip_support": PINNED}, mp.sin, lambda k: k * mp.pi),
    "pinned_clamped": ({"support": PINNED, "tip_support": {}}, lambda x: mp.tan(x) - mp.tanh(x), lambda k: (k + 0.25) * mp.pi),
}
WAYS = {"pieces": {}, "galerkin": {"rotation": {"angular_velocity": 0.0, "plane": "out"}, "stiffening": {}}}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("ends", ENDS)
def test_roots_are_those_of_the_frequency_equation(here, ends, way):
    groups, equation, guess = ENDS[ends]
    count = 40
    result = here.simulate("a", {"beam": PAPER_BEAM, **WAYS[way], **groups, "modes": {"before": count}})
    assert result.attributes["method"] == way
    alpha = np.array([float(mp.findroot(equation, guess(k))) for k in range(1, count + 1)])
    np.testing.assert_allclose(result["angular_frequency"], H * alpha**2, rtol=1e-12)
    np.testing.assert_allclose(result["alpha"], alpha, rtol=1e-12)
    if "stiffness" not in groups["tip_support"]:
        assert (result["mode_shape"][:, -1] == 0).all()
        signs = np.sign(result["mode_shape"][:10, -2])
        np.testing.assert_array_equal(signs, [(-1) ** k for k in range(1, 11)])


@pytest.mark.parametrize("way", WAYS)
def test_the_timoshenko_beam_between_pins(here, way):
    """v = sin(n pi x), psi = cos(n pi x): (G p^2 - m b)(B p^2 + G - r b) = (G p)^2 with G = kappa G A, r = rho I, b = beta^2."""
    shear = {"poisson_ratio": 0.3, "shear_coefficient": 0.9}
    here.scene("a", {"beam": PAPER_BEAM, **WAYS[way], "shear": shear, "support": PINNED, "tip_support": PINNED, "modes": {"before": 12}})
    area = mp.pi / 4 * mp.mpf(0.037) ** 2
    inertia = area * mp.mpf(0.037) ** 2 / 16
    stiff, mass, rotary = inertia * mp.mpf(2e11), 7870 * area, 7870 * inertia
    g = 0.9 * mp.mpf(2e11) / (2 * (1 + mp.mpf(0.3))) * area
    expected = []
    for n in range(1, 13):
        p = n * mp.pi
        b = g * p**2 * rotary + mass * (stiff * p**2 + g)
        expected.append(float(mp.sqrt((b - mp.sqrt(b**2 - 4 * mass * rotary * g * stiff * p**4)) / (2 * mass * rotary))))
    np.testing.assert_allclose(here.run("a")["angular_frequency"], expected, rtol=1e-12)


@pytest.mark.parametrize("way", WAYS)
def test_a_faint_spring_is_a_free_tip_and_a_strong_one_a_rigid_tip(here, way):
    beta = {}
    for name, groups in {"free": {}, "faint": {"tip_support": {"stiffness": 1e-9, "rotational_stiffness": 1e-9}},
                         "strong": {"tip_support": {"stiffness": 1e25, "rotational_stiffness": 1e25}}, "rigid": {"tip_support": {}}}.items():
        beta[name] = here.simulate(name, {"beam": PAPER_BEAM, **WAYS[way], **groups, "modes": {"before": 20}})["angular_frequency"]
    np.testing.assert_allclose(beta["faint"], beta["free"], rtol=1e-12)
    np.testing.assert_allclose(beta["strong"], beta["rigid"], rtol=1e-12)


@pytest.mark.parametrize("plane", ["in", "out"])
@pytest.mark.parametrize("shear", [None, {}])
@pytest.mark.parametrize("stiffening", [None, {"hub_radius": 0.2}])
def test_a_capture_on_a_beam_with_a_held_tip_balances(here, plane, shear, stiffening):
    here.scene("a", captured_beam(rotation={"angular_velocity": 60.0, "plane": plane}, tip_support=PINNED, shear=shear, stiffening=stiffening,
                                  impact={"position": 0.6}, response={"duration": 0.05, "samples": 64, "bending_moment": True}))
    result = here.run("a")
    np.testing.assert_allclose(result["momentum_after"], result["momentum_before"], rtol=1e-12)
    assert (np.diff(result["energy_before"]) < 0).all()
    assert (result["displacement"][-1] == 0).all()
    assert (result["bending_moment"][-1] == 0).all()


def test_both_ways_tell_one_motion(here):
    for way, groups in WAYS.items():
        history = {"duration": 0.05, "samples": 200, "bending_moment": True}
        here.scene(way, captured_beam(**{"rotation": None, **groups}, tip_support={"stiffness": 2e5}, impact={"position": 0.6}, response=history))
    one, other = (here.run(way) for way in WAYS)
    for name in ["displacement", "bending_moment", "mode_shape", "modal_mass"]:
        np.testing.assert_allclose(one[name], other[name], atol=1e-10 * np.abs(one[name]).max(), err_msg=name)


def test_a_blow_at_a_rigidly_held_tip_is_refused(here):
    here.scene("a", captured_beam(tip_support=PINNED))
    here.scene("b", captured_beam(tip_support={"stiffness": 0.0}))
    ended = here.beamwave("run", "a.nml", "b.nml", status=2)
    assert re.search(r"^a.nml: impact%position: is 1, the tip, which &tip_support holds rigidly.*; accepted: > 0 and < 1", ended.stderr)
    assert here.left() == ["b.nc"]


def test_the_scene_of_a_held_tip_shows_what_it_promises(here):
    path = PROJECT / "input/effects/held_tip.nml"
    here.beamwave("run", path, status=0)
    text = path.read_text(encoding="utf-8")
    here.write("free.nml", re.sub(r"&tip_support.*\n", "", text[text.index("&scene"):]))
    here.write("pin.nml", re.sub(r"&tip_support.*\n", "&tip_support rotational_stiffness = 0 /\n", text[text.index("&scene"):]))
    firsts = [here.result("held_tip"), here.run("free"), here.run("pin")]
    promised = re.findall(r"\d+\.\d+", text[:text.index("&scene")])
    assert promised == [f"{result['angular_frequency'][0]:.2f}" for result in firsts]
