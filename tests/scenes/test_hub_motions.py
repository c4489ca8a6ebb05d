"""A hub that is free to turn: with a beam that is let go, and carried by a frame that is accelerated, beside a method of Ritz."""

import numpy as np
import pytest
from hub_reference import PER_LENGTH, STIFFNESS, HubBeam, half_sine, section
from workplace import PAPER_BEAM

POINTS = [0.0, 0.3, 1.0]
HISTORY = {"duration": 0.05, "samples": 200, "points": POINTS, "velocity": True, "bending_moment": True}
LET_GO = {"force": 500.0, "position": 0.7}
BODY = {"body": {"position": 0.4, "mass": 3.0}}
ROTATING = {"rotation": {"angular_velocity": 80.0}, "stiffening": {"hub_radius": 0.1}}


def hubbed(**groups):
    """The paper's beam on a light hub; a group given as None is left out."""
    scene = {"beam": PAPER_BEAM, "hub": {"rotary_inertia": 0.05, "radius": 0.1}, "modes": {"before": 40}, "response": HISTORY, **groups}
    return {name: group for name, group in scene.items() if group is not None}


def reference(groups, degree=30):
    """Its model."""
    bodies = ((groups["body"]["position"], groups["body"]["mass"]),) if "body" in groups else ()
    cuts = tuple(sorted({0.7, *(place for place, _ in bodies)}))
    return HubBeam(0.05, 0.1, 80.0 if "rotation" in groups else 0.0, bodies, cuts, degree)


def same(found, own, tolerance):
    np.testing.assert_allclose(found, own, rtol=0, atol=tolerance * np.abs(own).max())


@pytest.mark.parametrize("groups", [{}, ROTATING, BODY, {**BODY, **ROTATING}], ids=str)
def test_a_beam_and_its_hub_that_are_let_go_move_as_a_model_of_their_own(here, groups):
    result = here.simulate("a", hubbed(initial=LET_GO, modes={"before": 12}, **groups))
    beam = reference(groups)
    square, mode = beam.modes(12)
    bent = np.append(0.0, np.linalg.solve(beam.stiffness, beam.basis([0.7])[:, 0] * 500.0))  # the hub is held
    time, beta = result["time"], np.sqrt(square)
    q = (mode.T @ beam.mass @ bent)[:, None] * np.cos(np.outer(beta, time))
    v = -beta[:, None] * (mode.T @ beam.mass @ bent)[:, None] * np.sin(np.outer(beta, time))
    same(result["hub_angle"], mode[0] @ q, 1e-9)
    for p, point in enumerate(POINTS[1:], 1):
        same(result["displacement"][p], beam.from_line(point) @ mode @ q, 1e-9)
        same(result["velocity"][p], beam.from_line(point) @ mode @ v, 1e-8)
    same(result["bending_moment"][0], STIFFNESS * beam.from_line(0.0, 2) @ mode @ q, 1e-8)
    # of infinitely many modes: the deflection under the force, and a hub that is where it was held
    for p, point in enumerate(POINTS):
        assert abs(result["displacement"][p, 0] - beam.from_line(point) @ bent) <= result["displacement_error"][p], point
    assert abs(result["hub_angle"][0]) < 1e-5 * np.abs(result["hub_angle"]).max()


@pytest.mark.parametrize("modes", [{"before": 40}, {"tolerance": 1e-6}], ids=str)
def test_a_mass_at_rest_that_the_beam_swings_into_has_the_energy_of_the_deflection_and_no_angular_momentum(here, modes):
    strikes = {"impact": {"mass": 0.5, "position": 0.7, "approach_velocity": 0.0}, "contact": {"radius": 0.025, "surface_radius": 0.0}}
    response = {"duration": 5e-3, "samples": 200, "points": [0.7, 1.0]}
    result = here.simulate("a", hubbed(initial={"force": -500.0}, modes=modes, response=response, **strikes))
    contacts = result["event_kind"] > 0
    assert contacts.sum() >= 2
    np.testing.assert_allclose(result["energy_before"][0], 500.0**2 / (6 * STIFFNESS), rtol=1e-6)  # ½F times l³F/(3EI)
    swung = np.abs(result["hub_rate_change"][contacts]).max() * (0.05 + PER_LENGTH * (0.01 + 0.1 + 1 / 3))
    assert np.abs(result["angular_momentum_after"][contacts]).max() <= 1e-12 * swung


SHOCK = {"amplitude": 50.0, "duration": 1e-3}


@pytest.mark.parametrize("groups", [{}, ROTATING, BODY, {**BODY, **ROTATING}], ids=str)
def test_a_shock_of_the_axis_moves_beam_and_hub_as_a_model_of_their_own_does(here, groups):
    asked = {**HISTORY, "acceleration": True, "shear_force": True, "points": [0.0, 0.3, 0.7, 1.0]}
    result = here.simulate("a", hubbed(base=SHOCK, **groups, response=asked))
    beam = reference(groups, 40)
    square, mode = beam.modes(75)
    time, driven = result["time"], -section(beam, 0.0) @ mode
    u, v, a = (np.array(rows) * driven[:, None] for rows in zip(*(half_sine(s, time, 50.0, 1e-3) for s in square), strict=True))
    turn = mode[0] @ u
    same(result["hub_angle"], turn, 1e-9)
    late = time > 1e-3
    omega = 80.0 if "rotation" in groups else 0.0
    for p, point in enumerate(asked["points"]):
        line, bend, beyond = beam.from_line(point) @ mode, STIFFNESS * beam.from_line(point, 2) @ mode, section(beam, point)
        own = {"displacement": line @ u, "velocity": line @ v, "acceleration": line @ a, "bending_moment": bend @ u * (point < 1),
               "shear_force": omega**2 * (beyond @ mode @ u - beyond[0] * turn) - beyond @ mode @ a}
        for name, history in own.items():
            off = np.abs(result[name][p] - history)[late].max()
            assert off <= 2 * result[f"{name}_error"][p] + 1e-12 * np.abs(result[name]).max(), (name, point, off)
    # the moment about the axis is what the inertia of the beam brings
    inner = beam.mass[0] @ mode @ v
    np.testing.assert_allclose(inner[late], -50.0 * 2e-3 / np.pi * section(beam, 0.0)[0], rtol=1e-9)


def bent(radius, inertia, force, place, base):
    """w and the moment of a beam and a turn θ, without the part of the rigid turn, where a force at a place, or a motion of the base, meets no more
    than the inertia of a hub that turns evenly faster: polynomials within and beyond the place."""
    x = np.polynomial.Polynomial([0.0, 1.0])
    whole = inertia + PER_LENGTH * (radius**2 + radius + 1 / 3)
    faster = (force * (radius + place) - base * PER_LENGTH * (radius + 0.5)) / whole
    load = -PER_LENGTH * (base + (radius + x) * faster)
    moment = load.integ().integ()
    moment = moment - moment(1) - moment.deriv()(1) * (x - 1)  # and its slope are 0 at the tip
    inner = moment + force * (place - x)
    parts = [inner / STIFFNESS, moment / STIFFNESS]
    slope = [parts[0].integ(lbnd=0)]
    slope.append(parts[1].integ(lbnd=place, k=slope[0](place)))
    w = [slope[0].integ(lbnd=0)]
    w.append(slope[1].integ(lbnd=place, k=w[0](place)))
    spin = [((radius + x) * part).integ() for part in w]
    turn = -PER_LENGTH * (spin[0](place) - spin[0](0) + spin[1](1) - spin[1](place)) / whole
    return lambda xi: (w[xi > place](xi), (inner, moment)[xi > place](xi)), turn


@pytest.mark.parametrize("count", [2, 12])
def test_modes_and_residuals_of_a_model_bend_as_forces_less_the_inertia_of_the_turn_do(here, count):
    points = [0.3, 0.6, 1.0]
    here.scene("a", hubbed(modes={"before": count, "modal_model": True}, frequency_response={"points": points, "last": 100.0, "first": 1.0}, response=None))
    result = here.run("a")
    arms = 0.1 + np.array(points)
    drive = result["shape_at_points"] + np.outer(result["hub_turn"], arms)  # (modes, points)
    soft = 1 / result["modal_stiffness"][1:]
    assert result["modal_stiffness"][0] == 0
    for name, loads, suffix in (("force", drive[1:], ""), ("base", -result["participation"][1:, None], "_of_base")):
        for f in range(loads.shape[1]):
            along, turn = bent(0.1, 0.05, *((1.0, points[f], 0.0) if name == "force" else (0.0, 0.5, 1.0)))
            rest = {key: result[key + suffix][f] if name == "force" else result[key + suffix] for key in ("residual_moment", "residual_hub_turn")}
            flexible = result["residual_flexibility"][f] if name == "force" else result["residual_of_base"]
            own = (result["shape_at_points"][1:].T * soft) @ loads[:, f] + flexible
            moment = (result["moment_at_points"][1:].T * soft) @ loads[:, f] + rest["residual_moment"]
            expected = np.array([along(point) for point in points]).T
            np.testing.assert_allclose(own, expected[0], rtol=0, atol=1e-12 * np.abs(expected[0]).max(), err_msg=name)
            np.testing.assert_allclose(moment, expected[1], rtol=0, atol=1e-11 * np.abs(expected[1]).max(), err_msg=name)
            np.testing.assert_allclose((result["hub_turn"][1:] * soft) @ loads[:, f] + rest["residual_hub_turn"], turn, rtol=1e-10, err_msg=name)


@pytest.mark.parametrize("groups", [{}, BODY], ids=str)
def test_a_harmonic_force_moves_beam_and_hub_under_tension_as_a_model_of_their_own(here, groups):
    asked = {"points": [0.3, 1.0], "position": 0.7, "first": 5.0, "last": 2000.0, "count": 60}
    here.scene("a", hubbed(frequency_response=asked, damping={"mass_proportional": 8.0}, **ROTATING, **groups, response=None, modes=None))
    result = here.run("a")
    beam = reference({**ROTATING, **groups})
    whole = np.zeros_like(beam.mass)
    whole[1:, 1:] = beam.stiffness
    found = result["frequency_response_real"] + 1j * result["frequency_response_imag"]
    for j, omega in enumerate(2 * np.pi * result["response_frequency"]):
        answer = np.linalg.solve(whole + (8j * omega - omega**2) * beam.mass, beam.motion(0.7))
        own = np.array([beam.from_line(point) @ answer for point in asked["points"]])
        assert (np.abs(found[:, j] - own) <= result["frequency_response_error"] + 1e-8 * np.abs(own)).all(), (omega, found[:, j] - own)
    assert (result["frequency_response_error"] < 1e-10 * np.abs(found).max(axis=1)).all()


@pytest.mark.parametrize("damping", [{"mass_proportional": 8.0, "stiffness_proportional": 1e-6}, {"ratio": 0.05}, None], ids=str)
def test_a_very_heavy_hub_answers_a_harmonic_force_as_the_boundary_problem_of_a_root_that_is_held(here, damping):
    asked = {"points": [0.4, 1.0], "position": 0.7, "first": 1.0, "last": 100.0, "count": 40}
    groups = {"frequency_response": asked, "support": {"rotational_stiffness": 1e5}, "shear": {}, "damping": damping, "response": None, "modes": None}
    here.scene("heavy", hubbed(**groups) | {"hub": {"rotary_inertia": 1e17}})
    here.scene("held", hubbed(**groups, hub=None))
    heavy, held = ((r["frequency_response_real"] + 1j * r["frequency_response_imag"], r) for r in (here.run("heavy"), here.run("held")))
    peak = np.abs(held[0]).max(axis=1)
    given = heavy[1]["frequency_response_error"] + (held[1]["frequency_response_error"] if "frequency_response_error" in held[1] else 0.0)
    assert (np.abs(heavy[0] - held[0]).max(axis=1) <= 2 * given + 1e-13 * peak).all()
    assert (heavy[1]["frequency_response_error"] <= 1e-11 * peak).all()
