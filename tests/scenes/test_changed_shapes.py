"""Stiffening, shear and the rotary inertia of a captured body: the effects that change the shapes of the modes."""

import re

import numpy as np
import pytest
from conftest import PROJECT
from results import FILL
from workplace import captured_beam

BEAM = "&beam length=1, diameter=0.037, density=7870, youngs_modulus=2e11 /\n"
STRUCK = "&impact mass_ratio=0.2 /\n&modes before=30, after=30 /\n"
HISTORY = "&response duration=0.1, samples=1024, velocity=.true. /\n"
STIFFENED = "&rotation angular_velocity=50 /\n&stiffening hub_radius=0.2 /\n&capture /\n"


@pytest.fixture(scope="module")
def effects(shared):
    """Results of the scenes of input/effects/ by name, and the rows of their reports."""
    place = shared("effects")
    names = ["rotation", "stiffening", "shear", "body_inertia"]
    ended = place.beamwave("run", *(PROJECT / f"input/effects/{name}.nml" for name in names))
    assert (ended.returncode, ended.stderr) == (0, "")
    return {name: place.result(name) for name in names}


def promised(name):
    """The numbers in the two comment lines of a scene, as they stand there."""
    lines = (PROJECT / f"input/effects/{name}.nml").read_text(encoding="utf-8").splitlines()[:2]
    assert all(line.startswith("! ") for line in lines)
    return re.findall(r"\d+(?:\.\d+)?", " ".join(lines))


def test_the_scenes_of_the_effects_show_what_they_promise(effects):
    beta = {name: np.asarray(result["angular_frequency"]) for name, result in effects.items()}
    plain = 46.6304239974881 * np.array([1.6163996601559350880, 7.3183726733425058470, 29.138585642520606567]) ** 2
    speeds = [float(effects["rotation"][name][0]) for name in ("phase_velocity", "group_velocity")]
    assert promised("rotation") == ["1", f"{np.sqrt(plain[0]**2 - 50**2):.2f}", f"{plain[0]:.2f}",
                                    *(f"{speed:.1f}" for speed in speeds)]
    np.testing.assert_allclose(beta["rotation"][0] ** 2, plain[0] ** 2 - 50**2, rtol=1e-13)
    assert promised("stiffening") == ["50", "1", f"{beta['stiffening'][0]:.1f}", f"{plain[0]:.1f}",
                                      f"{np.sqrt(plain[0]**2 - 50**2):.1f}", f"{plain[0]:.1f}"]
    drop = 100 * (1 - beta["shear"][[0, 2, 9]] / plain)
    assert promised("shear") == ["1", f"{drop[0]:.2f}", f"{beta['shear'][0]:.2f}", f"{plain[0]:.2f}", "3", f"{drop[1]:.1f}",
                                 f"{beta['shear'][2]:.0f}", f"{plain[1]:.0f}", "10", f"{drop[2]:.0f}",
                                 f"{beta['shear'][9]:.0f}", f"{plain[2]:.0f}"]
    body = beta["body_inertia"]
    lost = 1 - effects["body_inertia"]["energy_after"][1] / effects["body_inertia"]["energy_before"][1]
    assert promised("body_inertia")[:-1] == ["1", f"{body[0]:.2f}", f"{plain[0]:.2f}", "10", f"{body[9]:.0f}",
                                             f"{100 * (1 - body[9] / plain[2]):.0f}", f"{plain[2]:.0f}", f"{100 * lost:.2f}"]


def test_the_scenes_of_pieces_show_what_they_promise(here):
    names = ["effects/stepped_beam", "effects/soft_root", "inboard_capture"]
    here.beamwave("run", *(PROJECT / f"input/{name}.nml" for name in names), status=0)
    stepped, soft, inboard = (here.result(name.split("/")[-1]) for name in names)
    plain = 46.6304239974881 * np.array([1.6163996601559350880, 29.138585642520606567]) ** 2
    lost = 1 - stepped["energy_after"][1] / stepped["energy_before"][1]
    assert promised("stepped_beam") == ["10", "1", f"{stepped['angular_frequency'][0]:.2f}", f"{plain[0]:.2f}", f"{100 * lost:.2f}"]
    body = soft["angular_frequency"]
    assert promised("soft_root") == ["1", f"{body[0]:.2f}", f"{plain[0]:.2f}", "10", f"{body[9]:.0f}",
                                     f"{100 * (1 - body[9] / plain[1]):.0f}", f"{plain[1]:.0f}"]
    speed = f"{inboard['critical_angular_velocity']:.2f}"
    assert promised("../inboard_capture") == ["0.7", "1", f"{inboard['angular_frequency'][0]:.2f}", speed]
    assert {result.attributes["method"] for result in (stepped, soft, inboard)} == {"pieces"}


@pytest.mark.parametrize("name", ["stiffening", "shear", "body_inertia"])
def test_a_faint_effect_changes_nothing(here, name):
    faint = {"stiffening": "&rotation angular_velocity=1e-7 /\n&stiffening /\n&capture /\n",
             "shear": "&shear shear_coefficient=1e12, poisson_ratio=0 /\n&capture /\n",
             "body_inertia": "&capture rotary_inertia=1e-17 /\n"}
    beam = BEAM if name != "shear" else BEAM.replace("0.037", "1e-7")
    duration = HISTORY if name != "shear" else HISTORY.replace("0.1", "1e5")
    here.write("with.nml", beam + faint[name] + STRUCK + duration)
    here.write("without.nml", beam + "&capture /\n" + STRUCK + duration)
    assert here.beamwave("run", "with.nml", "without.nml").returncode == 0
    changed, plain = here.result("with"), here.result("without")
    assert (changed.attributes["method"], plain.attributes["method"]) == (
        "galerkin" if name == "stiffening" else "pieces", "closed form")
    for variable in ["alpha", "angular_frequency", "phase_velocity", "group_velocity", "modal_mass_before", "impulse"]:
        np.testing.assert_allclose(changed[variable], plain[variable], rtol=1e-10)
    # beta t is 4e4 at the end for mode 30, of frequencies that agree to 1e-13
    peak = np.abs(plain["displacement"]).max()
    np.testing.assert_allclose(changed["displacement"], plain["displacement"], rtol=0, atol=1e-8 * peak)


def test_without_their_equations_wave_numbers_are_not_measured(here):
    here.write("scene.nml", BEAM + STIFFENED + STRUCK + HISTORY + "&spectrum /\n")
    assert here.beamwave("run", "scene.nml").returncode == 0
    result = here.result("scene")
    assert result["peak_count"] > 3
    for name in ["measured_wavenumber", "measured_phase_velocity", "measured_group_velocity"]:
        assert (result[name] == FILL).all()


REFUSED = {
    "&rotation angular_velocity=1 /\n&stiffening /\n&modes before=501 /": "scene.nml:4: modes%before: is 501, more than the Galerkin basis",
    "&shear poisson_ratio=0.51 /": "scene.nml:2: shear%poisson_ratio: ",
}


@pytest.mark.parametrize("groups", REFUSED)
def test_what_these_effects_cannot_mean_is_refused(here, groups):
    here.write("scene.nml", BEAM + groups + "\n")
    ended = here.beamwave("check", "scene.nml", status=2)
    assert REFUSED[groups] in ended.stderr


def test_the_coefficient_of_a_circle_is_an_input_of_the_resolved_scene(here):
    here.write("a.nml", BEAM + "&shear poisson_ratio=0.25 /\n&modes before=3 /\n")
    first = here.run("a")
    assert first["shear_shear_coefficient"] == 6 * 1.25 / (7 + 6 * 0.25)  # Cowper, in binary64
    here.write("b.nml", first.attributes["scene"])
    again = here.run("b")
    assert again.attributes["scene"] == first.attributes["scene"]
    np.testing.assert_array_equal(again["angular_frequency"], first["angular_frequency"])
    sweep = "&sweep parameter='shear%poisson_ratio', values=0.25, 0.3 /\n"
    here.write("c.nml", BEAM + "&shear /\n&modes before=3 /\n" + sweep)
    materials = here.run("c")
    assert materials["shear_shear_coefficient"].tolist() == [6 * (1 + nu) / (7 + 6 * nu) for nu in (0.25, 0.3)]
    assert "shear_coefficient" not in materials.attributes["scene"]  # each its own, which the ratio tells
    np.testing.assert_array_equal(materials["angular_frequency"][0], first["angular_frequency"])


def test_out_of_plane_the_sections_of_a_beam_with_shear_turn_over(here):
    """At (π/2)√(E/ρ)/l whatever the section, the mass and its inertia; far outside linear theory, which is noted."""
    critical = float(np.pi / 2 * np.sqrt(2e11 / 7870) / 1.0)
    groups = {"shear": {}, "capture": {"rotary_inertia": 0.1}, "modes": {"before": 4, "after": 4}}
    for factor in [0.999, 1.001]:
        here.scene("a", captured_beam(rotation={"angular_velocity": factor * critical, "plane": "out"}, **groups))
        result = here.run("a", "--overwrite")
        for name in ["critical_angular_velocity", "critical_angular_velocity_before"]:
            np.testing.assert_allclose(result[name], critical, rtol=1e-15)
        assert (result["growth_rate"][0] > 0) == (factor > 1)
        assert ("since the angular velocity is above 7918.58 rad/s" in result.attributes["notes"]) == (factor > 1)
        assert "outside linear theory" in result.attributes["notes"]


def test_rotation_beyond_linear_theory_is_noted(here):
    here.write("scene.nml", BEAM + "&rotation angular_velocity=600 /\n&stiffening /\n")
    ended = here.beamwave("run", "scene.nml", status=0)
    assert "outside linear theory" in ended.stderr


def ritz_damping(omega, gamma, inertia, mass_part, stiffness_part, count):
    """Damping c_k of the modes, and the largest ratio of what couples two of them: dense matrices of the functions
    xi^2 P_j(2 xi - 1), with tension where there is no `inertia` of the body."""
    point, weight = np.polynomial.legendre.leggauss(60)
    point, weight = np.append((point + 1) / 2, 1.0), np.append(weight / 2, 0.0)
    functions = [np.polynomial.Polynomial([0, 0, 1]) * np.polynomial.Legendre.basis(j, [0, 1]).convert(
        kind=np.polynomial.Polynomial) for j in range(18)]
    value, slope, curvature = (np.array([f.deriv(d)(point) if d else f(point) for f in functions]) for d in range(3))
    mass = (value * weight) @ value.T + gamma * np.outer(value[:, -1], value[:, -1])
    elastic = (curvature * weight) @ curvature.T
    operator = elastic - omega**2 * mass
    if inertia:
        mass = mass + inertia * np.outer(slope[:, -1], slope[:, -1])
    else:
        operator = operator + (slope * weight * omega**2 * ((1 - point**2) / 2 + gamma)) @ slope.T
    root = np.linalg.inv(np.linalg.cholesky(mass))
    modes = root.T @ np.linalg.eigh(root @ operator @ root.T)[1][:, :count]
    damping = mass_part * np.eye(count) + stiffness_part * modes.T @ elastic @ modes
    own = np.diag(damping)
    return own, np.max(np.abs(damping - np.diag(own)) / np.sqrt(np.outer(own, own)))


COUPLED = {"tension": ("&stiffening /\n&capture /\n", 0.0), "body": ("&capture rotary_inertia=0.05 /\n", 0.05)}


@pytest.mark.parametrize("effect", COUPLED)
def test_rayleigh_damping_is_the_diagonal_and_says_what_it_leaves_out(here, effect):
    groups, inertia = COUPLED[effect]
    h, mass = 0.037 / 4 * np.sqrt(2e11 / 7870), 7870 * np.pi / 4 * 0.037**2
    here.write("scene.nml", BEAM + "&rotation angular_velocity=300 /\n" + groups + "&impact mass_ratio=0.2 /\n"
               "&damping mass_proportional=1, stiffness_proportional=2e-5 /\n&modes before=6, after=6 /\n")
    ended = here.beamwave("run", "scene.nml", status=0)
    rate, ratio = ritz_damping(300 / h, 0.2, inertia / mass, 1 / h, 2e-5 * h, 6)
    swings = here.result("scene")["angular_frequency"] < FILL
    assert swings.sum() >= 4
    # 18 functions whose powers of xi lose some eight digits
    np.testing.assert_allclose(here.result("scene")["growth_rate"][swings], -rate[swings] * h / 2, rtol=1e-6)
    said = float(re.search(r"coupled damping: .* at most (\S+) of", ended.stderr).group(1))
    assert said == pytest.approx(ratio, rel=0.06)  # two digits are printed
    assert 0.01 < ratio < 1


def test_damping_that_couples_nothing_says_nothing(here):
    here.write("scene.nml", BEAM + "&shear /\n&damping stiffness_proportional=1e-6 /\n")
    assert "coupled damping" not in here.beamwave("run", "scene.nml").stderr


def test_modes_that_the_basis_cannot_hold_are_fill(here):
    """At 1e9 rad/s bending is left to a layer of 7e-8 of the beam: no polynomials are enough, and no time is lost on them."""
    here.write("scene.nml", BEAM + "&rotation angular_velocity=50 /\n&stiffening /\n&capture /\n" + STRUCK + HISTORY
               + "&spectrum /\n&sweep parameter='rotation%angular_velocity', values=50, 1e9 /\n")
    ended = here.beamwave("run", "scene.nml", status=4)
    assert "not converged" in ended.stderr
    result = here.result("scene")
    np.testing.assert_array_equal(result["case_status"], [0, 2])
    np.testing.assert_array_equal(result["mode_count"], [30, 0])
    others = {"case", "case_status", "rotation_angular_velocity", "notes", "note_count"}
    of_cases = {name for name, variable in result.variables.items() if variable.dimensions[:1] == ("case",)} - others
    for name in of_cases:
        assert (result[name][1] == (FILL if result[name].dtype.kind == "f" else 0)).all(), name
    for name in ["alpha", "angular_frequency", "growth_rate", "modal_mass_before", "modal_velocity", "impulse", "event_time",
                 "velocity_jump", "displacement", "velocity", "displacement_error", "amplitude"]:
        assert name in of_cases and (result[name][0] < FILL).any(), name
    # the other case is what it is alone
    here.write("alone.nml", BEAM + "&rotation angular_velocity=50 /\n&stiffening /\n&capture /\n" + STRUCK + HISTORY)
    assert here.beamwave("run", "alone.nml").returncode == 0
    np.testing.assert_array_equal(here.result("alone")["displacement"], result["displacement"][0])


@pytest.mark.parametrize("mass_ratio", [1e24, 1e60])
@pytest.mark.parametrize("damping", [None, {"ratio": 1e-4}, {"mass_proportional": 0.0, "stiffness_proportional": 1e-6}])
@pytest.mark.parametrize("omega", [3e-5, 4.0])
@pytest.mark.parametrize("groups", [{"capture": {"rotary_inertia": 1e-3}}, {"shear": {}}], ids=["inertia", "shear"])
def test_an_immense_mass_goes_its_own_way_and_takes_the_tip_along(here, mass_ratio, groups, omega, damping):
    """y'' = ω²y with the approach velocity at the start: the beam's pull is 3/γ of its own stiffness, and so is its damping."""
    history = {"response": {"duration": 0.5, "samples": 50}, "rotation": {"angular_velocity": omega}}
    result = here.simulate("a", captured_beam(impact={"mass_ratio": mass_ratio}, damping=damping, **history, **groups))
    expected = np.sinh(omega * result["time"]) / omega
    np.testing.assert_allclose(result["displacement"][1], expected, rtol=1e-13)
    np.testing.assert_allclose(result["energy_after"][1], result["energy_before"][0], rtol=1e-13)


def test_tension_that_leaves_bending_but_a_thin_layer_makes_a_string(here):
    """Its ends are held, at the root and by the mass; c = sqrt(T/(rho A)) = omega l sqrt(gamma), and bending has some 1e-12 of l."""
    result = here.simulate("a", captured_beam(impact={"mass_ratio": 1e24}, stiffening={}))
    of_string = result["rotation_angular_velocity"] * 1e12 * np.pi * np.arange(1, result["angular_frequency"].size)
    np.testing.assert_allclose(result["angular_frequency"][1:], of_string, rtol=1e-11)
