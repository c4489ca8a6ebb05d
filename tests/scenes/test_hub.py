"""A hub that is free to turn: its modes, what blows do to it, and what it cannot be combined with."""

import re

import numpy as np
import pytest
from conftest import PROJECT
from hub_reference import PER_LENGTH, STIFFNESS, HubBeam, half_sine, section
from results import FILL
from scipy.integrate import solve_ivp
from workplace import PAPER_BEAM, captured_beam

MASS = PER_LENGTH  # of the beam, 1 m long
HISTORY = {"duration": 0.05, "samples": 200, "points": [0.3, 0.5, 1.0]}


def rows():
    """The rows of hub_modes.txt by case: its numbers, and the frequencies from mode 2 on."""
    lines = (PROJECT / "tests/reference/hub_modes.txt").read_text(encoding="utf-8").splitlines()
    names, *table = [line.split() for line in lines if not line.startswith("#")]
    cases = {}
    for row in table:
        cases.setdefault(tuple(map(float, row[:-2])), []).append(float(row[-1]))
    return [(dict(zip(names, case)), np.array(beta)) for case, beta in cases.items()]


def hubbed(inertia=2.0, radius=None, **groups):
    """The paper's capture on a free hub that does not rotate."""
    hub = {"rotary_inertia": inertia} | ({} if radius is None else {"radius": radius})
    return captured_beam(**{"rotation": None, "hub": hub, "modes": {"before": 8, "after": 8}, "response": HISTORY, **groups})


TURNING = {"rotation": {"angular_velocity": 50.0}, "stiffening": {"hub_radius": 0.3}}


def test_frequencies_are_those_of_power_series(here):
    for number, (case, _) in enumerate(rows()):
        scene = {"beam": PAPER_BEAM, "hub": {"rotary_inertia": case["inertia"], "radius": case["radius"]}, "modes": {"before": 7}}
        if case["omega"]:
            scene["rotation"] = {"angular_velocity": case["omega"]}
            scene["stiffening"] = {"hub_radius": case["radius"]}
        if case["gamma"]:
            scene["body"] = {"position": 1.0, "mass_ratio": case["gamma"]}
        support = {name: case[name] for name in ("stiffness", "rotational_stiffness") if case[name] >= 0}
        if support:
            scene["support"] = support
        here.scene(f"all/c{number}", scene)
    here.beamwave("run", "all", status=0)
    for number, (case, beta) in enumerate(rows()):
        result = here.result(f"c{number}")
        np.testing.assert_allclose(result["angular_frequency"][1 : beta.size + 1], beta, rtol=1e-11, err_msg=str(case))
        # the rigid turn is no wave, and measured from the hub's own line it is no motion
        assert result["angular_frequency"][0] == 0 and result["growth_rate"][0] == 0
        assert result["phase_velocity"][0] == FILL and result["group_velocity"][0] == FILL
        assert np.abs(result["mode_shape"][0]).max() < 1e-12
        assert (result["mode_shape"][:, 0] == 0).all() or "support" in result.attributes["effects"]


def test_a_captured_blow_moves_beam_and_hub_as_a_model_of_its_own_does(here):
    inertia, radius, gamma, count = 0.7, 0.25, 0.2, 8
    result = here.simulate("a", hubbed(inertia, radius))
    before, after = HubBeam(inertia, radius), HubBeam(inertia, radius, bodies=((1.0, gamma * MASS),))
    _, free = before.modes(count)
    square, loaded = after.modes(count)
    tip = before.motion(1.0)
    struck = tip @ free
    impulse = 1 / (1 / (gamma * MASS) + (struck**2).sum())
    rate = loaded.T @ (before.mass @ free @ (struck * impulse) + tip * (gamma * MASS - impulse))
    time, beta = result["time"], np.sqrt(square[1:])
    q = np.vstack([rate[:1, None] * time, rate[1:, None] * np.sin(np.outer(beta, time)) / beta[:, None]])
    turn = loaded[0] @ q
    np.testing.assert_allclose(result["hub_angle"], turn, atol=1e-10 * np.abs(turn).max())
    for point, history in zip(HISTORY["points"], result["displacement"]):
        own = after.from_line(point) @ loaded @ q
        np.testing.assert_allclose(history, own, atol=1e-10 * np.abs(own).max(), err_msg=str(point))


PULSE = {"position": 0.7, "amplitude": 100.0, "duration": 1e-3}
EVERYTHING = {"velocity": True, "acceleration": True, "bending_moment": True, "shear_force": True}


@pytest.mark.parametrize("bodies", [(), ((0.4, 3.0),)], ids=["bare", "loaded"])
@pytest.mark.parametrize("omega", [0.0, 80.0])
def test_a_force_moves_beam_and_hub_as_a_model_of_its_own_does(here, omega, bodies):
    inertia, radius = 0.05, 0.1
    turning = {"rotation": {"angular_velocity": omega}, "stiffening": {"hub_radius": radius}} if omega else {}
    body = {"body": {"position": bodies[0][0], "mass": bodies[0][1]}} if bodies else {}
    points = [0.0, 0.3, 0.7, 1.0]
    here.scene("a", {"beam": PAPER_BEAM, **turning, "hub": {"rotary_inertia": inertia, "radius": radius}, **body, "force": PULSE,
                     "modes": {"before": 40}, "response": {"duration": 0.05, "samples": 500, "points": points, **EVERYTHING}})
    result = here.run("a")
    beam = HubBeam(inertia, radius, omega, bodies, tuple(sorted({0.7, *(place for place, _ in bodies)})), degree=40)
    square, mode = beam.modes(75)
    time, driven = result["time"], beam.motion(0.7) @ mode
    u, v, a = (np.array(rows) * driven[:, None] for rows in zip(*(half_sine(s, time, 100.0, 1e-3) for s in square), strict=True))
    turn = mode[0] @ u
    np.testing.assert_allclose(result["hub_angle"], turn, atol=1e-9 * np.abs(turn).max())
    late = time > 1e-3  # without the force the modes that are left out here are at rest
    rows = []
    for point in points:
        rows.append((beam.from_line(point) @ mode, STIFFNESS * beam.from_line(point, 2) @ mode, section(beam, point) @ mode))
    for name, seen, history in (("displacement", 0, u), ("velocity", 0, v), ("acceleration", 0, a), ("bending_moment", 1, u)):
        for p in range(len(points)):
            off = np.abs(result[name][p] - (rows[p][seen] @ history if (name, points[p]) != ("bending_moment", 1.0) else 0.0))[late].max()
            assert off <= 2 * result[f"{name}_error"][p] + 1e-12 * np.abs(result[name]).max(), (name, points[p], off)
    for p in range(len(points)):  # square to the hub's line: what lies beyond takes, less the pull on a line that turns
        beyond = rows[p][2]
        pull = omega**2 * (section(beam, points[p])[0])
        own = omega**2 * beyond @ u - beyond @ a - pull * turn
        off = np.abs(result["shear_force"][p] - own)[late].max()
        assert off <= 2 * result["shear_force_error"][p] + 1e-12 * np.abs(result["shear_force"]).max(), (points[p], off)
    # the moment about the axis is what the force brings
    brought = 100.0 * 2e-3 / np.pi * (radius + 0.7)
    inner = beam.mass[0] @ mode @ v
    np.testing.assert_allclose(inner[late], brought, rtol=1e-9)
    np.testing.assert_allclose(np.polyfit(time, result["hub_angle"], 1)[0], brought / beam.mass[0, 0], rtol=0.2)


SHOCK = {"amplitude": 50.0, "duration": 1e-3}
SOFT = {"stiffness": 1e6, "rotational_stiffness": 1e4}
BALL = {"impact": {"mass": 0.5, "position": 0.7, "approach_velocity": 1.0}, "contact": {"radius": 0.025, "surface_radius": 0.0}}


def test_a_contact_moves_beam_and_hub_as_an_integration_of_its_own_does(here):
    inertia, radius, omega, n, mass = 0.5, 0.3, 50.0, 60, 0.5
    result = here.simulate("a", {"beam": PAPER_BEAM, **TURNING, "hub": {"rotary_inertia": inertia}, **BALL, "modes": {"before": n},
                                 "response": {"duration": 2e-3, "samples": 400, "points": [0.3, 0.7, 1.0]}})
    beam = HubBeam(inertia, radius, omega, cuts=(0.7,), degree=60)
    square, mode = beam.modes(110)
    struck = beam.motion(0.7) @ mode
    rest = (struck[n:] ** 2 / square[n:]).sum()
    stiffness = 4 / 3 * np.sqrt(0.025) * 2e11 / (2 * 0.91)

    def force(state):
        approach = state[2 * n] - struck[:n] @ state[:n]
        if approach <= 0:
            return 0.0
        depth = min(approach, (approach / (rest * stiffness)) ** (2 / 3))
        for _ in range(30):
            depth -= (depth + rest * stiffness * depth**1.5 - approach) / (1 + 1.5 * rest * stiffness * depth**0.5)
        return stiffness * depth**1.5

    def slope(_, state):
        pressed = force(state)
        bend = struck[:n] * pressed - square[:n] * state[:n]
        return np.concatenate([state[n : 2 * n], bend, [state[-1], omega**2 * state[2 * n] - pressed / mass]])

    time = result["time"]
    solution = solve_ivp(slope, (0, time[-1]), np.append(np.zeros(2 * n + 1), 1.0), "DOP853", time, rtol=1e-10, atol=1e-15, max_step=2e-6)
    turn = mode[0, :n] @ solution.y[:n]
    free = (time > result["event_end"][0]) & (time > 0)  # the modes that are left out here are at rest then
    np.testing.assert_allclose(result["hub_angle"][free], turn[free], atol=1e-6 * np.abs(turn).max())
    assert np.isclose(result["event_end"][0], 1.65e-4, rtol=0.05) and np.sum(result["event_kind"] > 0) == 1
    for p, point in enumerate([0.3, 0.7, 1.0]):
        own = beam.from_line(point)[None] @ mode[:, :n] @ solution.y[:n]
        off = np.abs(result["displacement"][p] - own[0])[free].max()
        assert off <= 1e-6 * np.abs(own).max(), (point, off)  # the residual flexibility is that of the basis
    speed = mode[0, 0] * solution.y[n]
    np.testing.assert_allclose(result["hub_rate_change"][0], speed[free][0], rtol=1e-6)


LET_GO = {"initial": {"force": 500.0, "position": 0.7}}


@pytest.mark.parametrize("groups", [
    {"force": PULSE}, {"force": PULSE, **TURNING}, {"base": SHOCK}, {"base": SHOCK, **TURNING, "support": SOFT}, BALL, {**BALL, **TURNING}, {**BALL, **TURNING, "capture": {}, "release": {"time": 0.006}},
    {"force": PULSE, **TURNING, "body": {"position": 0.5, "mass": 1.0, "from": 2e-3, "until": 5e-3}},
    LET_GO, {**LET_GO, **TURNING}, {**LET_GO, **TURNING, "support": SOFT}, {**LET_GO, "shear": {}}], ids=lambda groups: "-".join(groups))
def test_with_a_very_heavy_hub_motions_are_those_of_a_root_that_is_held(here, groups):
    scene = {"beam": PAPER_BEAM, "modes": {"before": 20}, **groups,
             "response": {"duration": 0.01, "samples": 200, "points": [0.5, 1.0], **({} if "capture" in groups else {"bending_moment": True, "velocity": True})}}
    count = {"before": 21} | ({"after": 21} if "capture" in groups else {})
    here.scene("heavy", scene | {"hub": {"rotary_inertia": 1e12}, "modes": count})
    heavy, held = here.run("heavy"), here.simulate("held", scene | {"modes": {name: 20 for name in count}})
    for name in ("displacement", "velocity", "bending_moment"):
        if name in held:
            np.testing.assert_allclose(heavy[name], held[name], atol=2e-9 * np.abs(held[name]).max(), err_msg=name)
    np.testing.assert_allclose(heavy["event_time"], held["event_time"], rtol=1e-9) if "event_time" in held else None
    assert np.abs(heavy["hub_angle"]).max() < 1e-11


@pytest.mark.parametrize("groups", [{}, TURNING, {"shear": {}, **TURNING}, {"support": {"rotational_stiffness": 1e4}, **TURNING},
                                    {"body": {"position": 0.5, "mass": 1.0, "rotary_inertia": 0.01}, **TURNING}], ids=str)
def test_angular_momentum_is_kept_and_what_the_blow_brings(here, groups):
    result = here.simulate("a", hubbed(2.0, None if "stiffening" in groups else 0.3, **groups, release={"time": 0.03}))
    before, after, change = (result[name] for name in ("angular_momentum_before", "angular_momentum_after", "hub_rate_change"))
    np.testing.assert_allclose(after, before, rtol=1e-12)
    np.testing.assert_allclose(before, 0.2 * MASS * 1.3, rtol=1e-12)
    # all of it together turns on at the mean rate
    slim = 7870 * np.pi / 64 * 0.037**4 if "shear" in groups else 0.0
    body = 1.0 * 0.8**2 + 0.01 if "body" in groups else 0.0
    alone = 2.0 + MASS * (0.3**2 + 0.3 + 1 / 3) + slim + body
    np.testing.assert_allclose(change[:2].sum(), 0.2 * MASS * 1.3 / (alone + 0.2 * MASS * 1.3**2), rtol=1e-12)
    assert result["energy_after"][-1] < result["energy_before"][0]


def test_with_a_tolerance_the_hub_turns_at_the_mean_rate(here):
    result = here.simulate("a", hubbed(2.0, 0.3, modes=None, response={"duration": 2.0, "samples": 500, "points": [1.0]}))
    mean = 0.2 * MASS * 1.3 / (2.0 + MASS * (0.3**2 + 0.3 + 1 / 3) + 0.2 * MASS * 1.3**2)
    np.testing.assert_allclose(result["hub_rate_change"], [0.0, mean], rtol=1e-12)
    slope = np.polyfit(result["time"], result["hub_angle"], 1)[0]
    assert slope == pytest.approx(mean, rel=2e-2)  # the swing about it has an end of its own
    assert (result["displacement_error"] < 1e-4 * np.abs(result["displacement"]).max()).all()


@pytest.mark.parametrize("groups", [{}, TURNING], ids=["rest", "turning"])
def test_a_bound_of_more_modes_holds(here, groups):
    few = hubbed(0.5, **groups, modes={"before": 20, "after": 20})
    many = hubbed(0.5, **groups, modes={"before": 400, "after": 400})
    one, other = here.simulate("few", few), here.simulate("many", many)
    off = np.abs(one["displacement"] - other["displacement"]).max(axis=1)
    assert (off <= one["displacement_bound"]).all()
    assert (one["displacement_bound"] < 0.5 * np.abs(other["displacement"]).max(axis=1)).all()


@pytest.mark.parametrize("groups", [{}, TURNING], ids=["rest", "turning"])
def test_a_very_heavy_hub_is_one_whose_motion_is_prescribed(here, groups):
    heavy, held = here.simulate("heavy", hubbed(1e12, **groups)), here.simulate("held", hubbed(**{"hub": None, **groups}))
    np.testing.assert_allclose(heavy["angular_frequency"][1:], held["angular_frequency"][:-1], rtol=1e-10)
    # the rigid turn takes the place of one mode before and after
    heavy = here.simulate("heavy", hubbed(1e12, **groups, modes={"before": 9, "after": 9}), options=["--overwrite"])
    peak = np.abs(held["displacement"]).max()
    np.testing.assert_allclose(heavy["displacement"], held["displacement"], atol=1e-8 * peak)
    assert np.abs(heavy["hub_angle"]).max() < 1e-11


def test_a_light_hub_at_the_root_is_a_hinge(here):
    """Both are found by other ways: the hinge by exact modes of pieces."""
    here.scene("hub", {"beam": PAPER_BEAM, "hub": {"rotary_inertia": 1e-12}, "modes": {"before": 8}})
    here.scene("hinge", {"beam": PAPER_BEAM, "support": {"rotational_stiffness": 0.0}, "modes": {"before": 8}})
    np.testing.assert_allclose(here.run("hub")["angular_frequency"][1:], here.run("hinge")["angular_frequency"][1:], rtol=1e-10)


def test_what_holds_the_beam_to_another_frame_is_refused(here):
    out, still = {"rotation": {"angular_velocity": 50.0, "plane": "out"}}, {"rotation": {"angular_velocity": 50.0}}
    refused = {
        "out": ({**out, "stiffening": {}}, r"&hub: couples only with motion in the plane of rotation"),
        "untensed": (still, r"&hub: needs &stiffening if the beam rotates: without tension the rigid rotation would be unstable"),
        "radius": ({**still, "stiffening": {"hub_radius": 0.2}, "hub": {"radius": 0.3}}, r"hub%radius: is 0.3, and hub_radius .* is 0.2"),
        "spring": ({"body": {"position": 0.5, "mass": 0.0, "stiffness": 10.0}}, r"&body: has a spring to a frame that does not recoil"),
        "tip": ({"tip_support": {"stiffness": 10.0}}, r"&tip_support: has a spring to a frame"),
        "recontact": ({"capture": None, "recontact": {}}, r"&hub: excludes &recontact"),
        "absent": ({"hub": None}, None),
    }
    for name, (groups, _) in refused.items():
        here.scene(f"all/{name}", hubbed(**{key: value for key, value in groups.items() if key != "hub"})
                   | ({"hub": {"rotary_inertia": 2.0, **groups["hub"]}} if groups.get("hub") else {}))
    ended = here.beamwave("run", "all", status=2)
    for name, (_, words) in refused.items():
        if words:
            assert re.search(rf"^all/{name}\.nml(:\d+)?: {words}.*; accepted: ", ended.stderr, re.MULTILINE), (name, ended.stderr)


def test_a_swept_radius_is_that_of_the_stiffening(here):
    scene = hubbed(2.0, **TURNING)
    swept = here.simulate("swept", scene, {"parameter": "stiffening%hub_radius", "values": [0.1, 0.4]})
    assert swept["hub_radius"].tolist() == [0.1, 0.4]
    for case, radius in enumerate([0.1, 0.4]):
        one = here.simulate("one", scene | {"stiffening": {"hub_radius": radius}}, options=["--overwrite"])
        for name in ("angular_frequency", "hub_angle", "angular_momentum_after"):
            assert one[name].tobytes() == swept[name][case].tobytes(), name


def test_the_scene_of_a_hub_shows_what_it_promises(here):
    path = PROJECT / "input/effects/hub.nml"
    here.beamwave("run", path, status=0)
    result = here.result("hub")
    text = path.read_text(encoding="utf-8")
    promised = re.findall(r"\d+\.\d+", text[: text.index("&scene")])
    assert promised == [f"{result['angular_frequency'][1]:.2f}", f"{result['hub_rate_change'].sum():.4f}",
                        f"{np.degrees(result['hub_angle'][-1]):.2f}"]
