"""Beams whose sections vary linearly between stations, and beams by mass per length and bending stiffness."""

import re

import numpy as np
import pytest
from conftest import PROJECT
from results import FILL
from workplace import PAPER_BEAM, captured_beam

STEEL = {"density": 7870.0, "youngs_modulus": 2e11}
WIDTH, HEIGHT = 0.03, 0.02
UNIT = float(np.sqrt(2e11 * HEIGHT**2 / 12 / 7870))  # sqrt(EI/(rho A)) of the root over l^2, l = 1
MASS = 7870 * WIDTH * HEIGHT  # rho A l of the root's section
SLENDER = {"length": 1.0, **STEEL, "taper": "linear", "width": [0.03, 0.012], "height": [0.02, 0.012]}


def tapering(c_b, c_h, cuts=1):
    """The rectangle's beam with stations where it is cut."""
    x = np.linspace(0, 1, cuts + 1)
    return {"length": [1 / cuts] * cuts, **STEEL, "taper": "linear", "width": (WIDTH * (1 - c_b * x)).tolist(),
            "height": (HEIGHT * (1 - c_h * x)).tolist()}


def table():
    """The rows of taper_modes.txt by case: its numbers, and the squares of its frequencies."""
    lines = (PROJECT / "tests/reference/taper_modes.txt").read_text().splitlines()
    names, *rows = [line.split() for line in lines if not line.startswith("#")]
    cases = {}
    for row in rows:
        numbers = dict(zip(names, row))
        square = float(numbers.pop("beta_squared"))
        numbers.pop("k")
        cases.setdefault(tuple((name, float(number)) for name, number in numbers.items()), []).append(square)
    return [(dict(case), np.array(squares)) for case, squares in cases.items()]


def test_modes_are_those_of_ritz_in_many_digits(here):
    cases = table()
    assert len(cases) >= 20
    for number, (case, _) in enumerate(cases):
        scene = {"beam": tapering(case["c_b"], case["c_h"]), "modes": {"before": 6}}
        if case["omega"]:
            scene["rotation"] = {"angular_velocity": case["omega"] * UNIT, "plane": "in" if case["in_plane"] else "out"}
            scene["stiffening"] = {"hub_radius": case["hub"]}
        if case["mass"]:
            scene["body"] = {"position": 1.0, "mass": case["mass"] * MASS, "rotary_inertia": case["inertia"] * MASS}
        if case["compliance"]:
            # r^2 = h^2/12 is what the height makes it, and s^2 = 2 (1 + nu) r^2/kappa; so the height, and the unit of time, are its own
            thicker = float(np.sqrt(12 * case["rotary"]) / HEIGHT)
            scene["beam"]["height"] = [height * thicker for height in scene["beam"]["height"]]
            scene["shear"] = {"poisson_ratio": 0.3, "shear_coefficient": 2.6 * case["rotary"] / case["compliance"]}
            scene["rotation"]["angular_velocity"] *= thicker
            for name in {"mass", "rotary_inertia"} & scene.get("body", {}).keys():
                scene["body"][name] *= thicker
        here.scene(f"all/c{number}", scene)
    here.beamwave("run", "all", status=0)
    for number, (case, squares) in enumerate(cases):
        result = here.result(f"c{number}")
        unit = UNIT * (np.sqrt(12 * case["rotary"]) / HEIGHT if case["compliance"] else 1)
        assert (squares > 0).all()
        np.testing.assert_allclose(result["angular_frequency"], unit * np.sqrt(squares), rtol=1e-11, err_msg=str(case))


def test_uniform_pieces_go_to_the_taper_with_the_square_of_their_number(here):
    exact = here.simulate("taper", {"beam": tapering(0.4, 0.6), "modes": {"before": 3}})["angular_frequency"]
    errors = {}
    for count in (10, 20, 40, 80, 160):
        x = (np.arange(count) + 0.5) / count
        here.scene("steps", {"beam": {"length": [1 / count] * count, **STEEL, "width": (WIDTH * (1 - 0.4 * x)).tolist(),
                                      "height": (HEIGHT * (1 - 0.6 * x)).tolist()}, "modes": {"before": 3}})
        steps = here.run("steps", "--overwrite")
        assert steps.attributes["method"] == "pieces"
        errors[count] = np.abs(steps["angular_frequency"] / exact - 1)
    for fewer, more in zip((10, 20, 40, 80), (20, 40, 80, 160)):
        slope = np.log2(errors[more] / errors[fewer])
        assert ((slope > -2.2) & (slope < -1.8)).all(), slope


EFFECTS = {
    "plain": {},
    "tension": {"rotation": {"angular_velocity": 60.0}, "stiffening": {"hub_radius": 0.5}},
    "out_of_plane": {"rotation": {"angular_velocity": 60.0, "plane": "out"}, "stiffening": {}, "shear": {}},
    "soft": {"support": {"rotational_stiffness": 1e3}, "tip_support": {"stiffness": 1e3}, "body": {"position": 0.3, "mass": 0.4}},
}


@pytest.mark.parametrize("effect", EFFECTS)
def test_two_equal_stations_are_the_uniform_beam(here, effect):
    groups = {**EFFECTS[effect], "modes": {"before": 20}}
    here.scene("same", {"beam": tapering(0.0, 0.0), **groups})
    here.scene("uniform", {"beam": {"length": 1.0, **STEEL, "width": WIDTH, "height": HEIGHT}, **groups})
    np.testing.assert_allclose(here.run("same")["angular_frequency"], here.run("uniform")["angular_frequency"], rtol=1e-12)


@pytest.mark.parametrize("effect", EFFECTS)
def test_stations_on_the_taper_change_nothing(here, effect):
    groups = {**EFFECTS[effect], "modes": {"before": 20}}
    here.scene("one", {"beam": tapering(0.4, 0.6), **groups})
    one, four = here.run("one"), here.simulate("four", {"beam": tapering(0.4, 0.6, cuts=4), **groups})
    np.testing.assert_allclose(four["angular_frequency"], one["angular_frequency"], rtol=1e-12)
    np.testing.assert_allclose(four["mode_shape"], one["mode_shape"], atol=1e-10)
    np.testing.assert_allclose(four["wavenumber"], one["wavenumber"], rtol=1e-10)


@pytest.mark.parametrize("effect", EFFECTS)
def test_a_capture_balances_and_is_found_again_in_more_pieces(here, effect):
    history = {"impact": {"mass_ratio": 0.2, "position": 0.9}, "capture": {}, "modes": {"before": 20, "after": 20},
               "response": {"duration": 0.05, "samples": 100, "bending_moment": True}, "release": {"time": 0.03}}
    for cuts in (1, 3):
        here.scene(f"a{cuts}", {"beam": tapering(0.4, 0.6, cuts), **EFFECTS[effect], **history})
    one, other = here.run("a1"), here.run("a3")
    np.testing.assert_allclose(one["momentum_after"][:2], one["momentum_before"][:2], rtol=1e-12)
    assert (np.diff(one["energy_before"]) < 0).all()
    for name in ("displacement", "bending_moment", "bending_stress", "event_impulse"):
        np.testing.assert_allclose(other[name], one[name], atol=1e-9 * np.abs(one[name]).max(), err_msg=name)


def test_stress_is_that_of_the_section_at_the_point(here):
    points = [0.0, 0.25, 0.5, 0.8]
    history = {"response": {"duration": 0.05, "samples": 64, "points": points, "bending_moment": True}}
    here.scene("taper", captured_beam(beam=None, **history) | {"beam": tapering(0.4, 0.6)})
    here.scene("round", captured_beam(**history))
    square = {"length": 1.0, **STEEL, "area": 1e-3, "second_moment": 1e-7}
    here.scene("given", captured_beam(beam=None, **history) | {"beam": {**square, "extreme_fibre": 0.02}})
    here.scene("unknown", captured_beam(beam=None, **history) | {"beam": square})
    x = np.array(points)
    b, h = WIDTH * (1 - 0.4 * x), HEIGHT * (1 - 0.6 * x)
    for name, factor in {"taper": 6 / (b * h**2), "round": np.full(4, 32 / (np.pi * 0.037**3)), "given": np.full(4, 2e5)}.items():
        result = here.run(name)
        np.testing.assert_allclose(result["bending_stress"], factor[:, None] * result["bending_moment"], rtol=1e-13)
        np.testing.assert_allclose(result["bending_stress_error"], factor * result["bending_moment_error"], rtol=1e-13)
    assert "bending_stress" not in here.run("unknown").variables


def test_mass_per_length_and_bending_stiffness_stand_for_material_and_section(here):
    area, second = np.pi / 4 * 0.037**2, np.pi / 64 * 0.037**4
    lumped = {"length": 1.0, "mass_per_length": 7870 * area, "bending_stiffness": 2e11 * second}
    for name, beam in {"lumped": lumped, "round": PAPER_BEAM}.items():
        here.scene(name, captured_beam(beam=None, response={"duration": 0.05, "samples": 64}) | {"beam": beam})
    one, other = here.run("lumped"), here.run("round")
    for name in ("angular_frequency", "displacement", "critical_angular_velocity"):
        np.testing.assert_allclose(one[name], other[name], rtol=1e-11, atol=1e-13 * np.abs(other[name]).max())
    # linear between stations, as everything: a cantilever whose EI and rho A fall alike
    stations = {"mass_per_length": [2.0, 1.0], "bending_stiffness": [200.0, 100.0], "taper": "linear"}
    here.scene("wedge", {"beam": {"length": 1.0, **stations}, "modes": {"before": 3}})
    height = {"length": 1.0, **STEEL, "width": [0.02, 0.01], "height": 0.01, "taper": "linear"}
    here.scene("width", {"beam": height, "modes": {"before": 3}})
    unit = np.sqrt(2e11 * 0.01**2 / 12 / 7870)
    np.testing.assert_allclose(here.run("wedge")["angular_frequency"] / 10, here.run("width")["angular_frequency"] / unit, rtol=1e-12)


def test_a_hinged_taper_that_turns_in_plane_grows_without_tension(here):
    scene = {"beam": SLENDER, "rotation": {"angular_velocity": 20.0}, "support": {"rotational_stiffness": 0.0}, "modes": {"before": 4}}
    here.scene("free", scene)
    here.scene("pulled", {**scene, "stiffening": {}})
    free = here.run("free")
    assert free["critical_angular_velocity"] == 0
    np.testing.assert_allclose(free["growth_rate"][0], 20.0, rtol=1e-10)
    assert here.run("pulled")["critical_angular_velocity"] == FILL
    assert here.result("pulled")["angular_frequency"][0] == 0


def test_a_sweep_over_a_station_is_its_cases(here):
    beam = {**SLENDER, "height": [0.02, 0.012]}
    here.scene("swept", {"beam": beam, "modes": {"before": 4}}, {"parameter": "beam%height(2)", "values": [0.01, 0.02, 0.03]})
    swept = here.run("swept")
    assert swept.variables["beam_width"].dimensions == ("station",)
    for case, height in enumerate([0.01, 0.02, 0.03]):
        here.scene("one", {"beam": {**beam, "height": [0.02, height]}, "modes": {"before": 4}})
        assert here.run("one", "--overwrite")["angular_frequency"].tobytes() == swept["angular_frequency"][case].tobytes()


def test_the_resolved_scene_is_the_scene(here):
    first = here.simulate("a", {"beam": SLENDER, "modes": {"before": 4}})
    here.write("b.nml", first.attributes["scene"])
    assert here.run("b")["angular_frequency"].tobytes() == first["angular_frequency"].tobytes()


def test_what_the_taper_changes_is_studied(here):
    here.scene("a", captured_beam(beam=None) | {"beam": SLENDER})
    here.scene("b", captured_beam())
    for name, pattern in {"a": r"taper +on +\S+%", "b": r"taper +off +\S+%"}.items():
        ended = here.beamwave("effects", f"{name}.nml", status=0)
        assert re.search(pattern, ended.stdout), ended.stdout


def test_the_scene_of_a_taper_shows_what_it_promises(here):
    path = PROJECT / "input/effects/taper.nml"
    here.beamwave("run", path, status=0)
    text = path.read_text(encoding="utf-8")
    mean = re.sub(r"diameter = [^,]+, [^,]+, taper = 'linear'", "diameter = 0.037", text)
    here.write("uniform.nml", mean)
    promised = re.findall(r"\d+\.\d+", text[: text.index("&scene")])
    found = [here.result("taper"), here.run("uniform")]
    assert promised == [f"{result['angular_frequency'][k]:.2f}" for k in (0, 9) for result in found]
