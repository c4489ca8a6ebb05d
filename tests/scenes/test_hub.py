"""A hub that is free to turn: its modes, what blows do to it, and what it cannot be combined with."""

import re

import numpy as np
import pytest
from conftest import PROJECT
from results import FILL
from workplace import PAPER_BEAM, captured_beam

MASS = 7870 * np.pi / 4 * 0.037**2
STIFF = 2e11 * np.pi / 64 * 0.037**4
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
    ended = here.beamwave("run", "all")
    assert ended.returncode == 0, ended.stderr
    for number, (case, beta) in enumerate(rows()):
        result = here.result(f"c{number}")
        np.testing.assert_allclose(result["angular_frequency"][1 : beta.size + 1], beta, rtol=1e-11, err_msg=str(case))
        # the rigid turn is no wave, and measured from the hub's own line it is no motion
        assert result["angular_frequency"][0] == 0 and result["growth_rate"][0] == 0
        assert result["phase_velocity"][0] == FILL and result["group_velocity"][0] == FILL
        assert np.abs(result["mode_shape"][0]).max() < 1e-12
        assert (result["mode_shape"][:, 0] == 0).all() or "support" in result.attributes["effects"]


def ritz(inertia, radius, gamma, functions=18):
    """Functions (value at x), mass and stiffness of the beam that does not rotate; the first function is the rigid turn by 1."""
    point, weight = np.polynomial.legendre.leggauss(60)
    x = (point + 1) / 2
    basis = [np.polynomial.Polynomial([radius, 1.0])] + [
        np.polynomial.Polynomial([0, 0, 1]) * np.polynomial.Legendre.basis(j, [0, 1]).convert(kind=np.polynomial.Polynomial)
        for j in range(functions)
    ]
    value, bend = np.array([f(x) for f in basis]), np.array([f.deriv(2)(x) for f in basis])
    tip = np.array([f(1.0) for f in basis])
    mass = MASS * (value * weight / 2) @ value.T + gamma * MASS * np.outer(tip, tip)
    mass[0, 0] += inertia
    return basis, tip, mass, STIFF * (bend * weight / 2) @ bend.T


def modes_of(mass, stiffness, count):
    """Squares of the frequencies, and modes of mass 1."""
    root = np.linalg.inv(np.linalg.cholesky(mass))
    square, vector = np.linalg.eigh(root @ stiffness @ root.T)
    return np.maximum(square[:count], 0), root.T @ vector[:, :count]


def test_a_captured_blow_moves_beam_and_hub_as_a_model_of_its_own_does(here):
    inertia, radius, gamma, count = 0.7, 0.25, 0.2, 8
    here.scene("a", hubbed(inertia, radius))
    result = here.run("a")
    basis, tip, mass, stiffness = ritz(inertia, radius, 0.0)
    _, free = modes_of(mass, stiffness, count)
    square, loaded = modes_of(ritz(inertia, radius, gamma)[2], stiffness, count)
    struck = tip @ free
    impulse = 1 / (1 / (gamma * MASS) + (struck**2).sum())
    rate = loaded.T @ (mass @ free @ (struck * impulse) + tip * (gamma * MASS - impulse))
    time, beta = result["time"], np.sqrt(square[1:])
    q = np.vstack([rate[:1, None] * time, rate[1:, None] * np.sin(np.outer(beta, time)) / beta[:, None]])
    turn = loaded[0] @ q
    # 18 functions, whose powers of x lose some eight digits
    np.testing.assert_allclose(result["hub_angle"], turn, atol=1e-7 * np.abs(turn).max())
    for point, history in zip(HISTORY["points"], result["displacement"]):
        own = np.array([f(point) for f in basis[1:]]) @ loaded[1:] @ q
        np.testing.assert_allclose(history, own, atol=1e-6 * np.abs(own).max(), err_msg=str(point))


@pytest.mark.parametrize("groups", [{}, TURNING, {"shear": {}, **TURNING}, {"support": {"rotational_stiffness": 1e4}, **TURNING},
                                    {"body": {"position": 0.5, "mass": 1.0, "rotary_inertia": 0.01}, **TURNING}], ids=str)
def test_angular_momentum_is_kept_and_what_the_blow_brings(here, groups):
    here.scene("a", hubbed(2.0, None if "stiffening" in groups else 0.3, **groups, release={"time": 0.03}))
    result = here.run("a")
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
    here.scene("a", hubbed(2.0, 0.3, modes=None, response={"duration": 2.0, "samples": 500, "points": [1.0]}))
    result = here.run("a")
    mean = 0.2 * MASS * 1.3 / (2.0 + MASS * (0.3**2 + 0.3 + 1 / 3) + 0.2 * MASS * 1.3**2)
    np.testing.assert_allclose(result["hub_rate_change"], [0.0, mean], rtol=1e-12)
    slope = np.polyfit(result["time"], result["hub_angle"], 1)[0]
    assert slope == pytest.approx(mean, rel=2e-2)  # the swing about it has an end of its own
    assert (result["displacement_error"] < 1e-4 * np.abs(result["displacement"]).max()).all()


@pytest.mark.parametrize("groups", [{}, TURNING], ids=["rest", "turning"])
def test_a_bound_of_more_modes_holds(here, groups):
    few = hubbed(0.5, **groups, modes={"before": 20, "after": 20})
    many = hubbed(0.5, **groups, modes={"before": 400, "after": 400})
    here.scene("few", few)
    here.scene("many", many)
    one, other = here.run("few"), here.run("many")
    off = np.abs(one["displacement"] - other["displacement"]).max(axis=1)
    assert (off <= one["displacement_bound"]).all()
    assert (one["displacement_bound"] < 0.5 * np.abs(other["displacement"]).max(axis=1)).all()


@pytest.mark.parametrize("groups", [{}, TURNING], ids=["rest", "turning"])
def test_a_very_heavy_hub_is_one_whose_motion_is_prescribed(here, groups):
    here.scene("heavy", hubbed(1e12, **groups))
    here.scene("held", hubbed(**{"hub": None, **groups}))
    heavy, held = here.run("heavy"), here.run("held")
    np.testing.assert_allclose(heavy["angular_frequency"][1:], held["angular_frequency"][:-1], rtol=1e-10)
    # the rigid turn takes the place of one mode before and after
    here.scene("heavy", hubbed(1e12, **groups, modes={"before": 9, "after": 9}))
    heavy = here.run("heavy", "--overwrite")
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
        "out": ({**out, "stiffening": {}}, r"&hub: couples with motion in the plane of rotation alone"),
        "untensed": (still, r"&hub: needs &stiffening where the beam rotates: without tension its rigid turn would grow"),
        "radius": ({**still, "stiffening": {"hub_radius": 0.2}, "hub": {"radius": 0.3}}, r"hub%radius: is 0.3, and hub_radius .* is 0.2"),
        "spring": ({"body": {"position": 0.5, "mass": 0.0, "stiffness": 10.0}}, r"&body: has a spring to a frame that does not recoil"),
        "tip": ({"tip_support": {"stiffness": 10.0}}, r"&tip_support: has a spring to a frame"),
        "recontact": ({"capture": None, "recontact": {}}, r"&hub: excludes &recontact"),
        "absent": ({"hub": None}, None),
    }
    for name, (groups, _) in refused.items():
        here.scene(f"all/{name}", hubbed(**{key: value for key, value in groups.items() if key != "hub"})
                   | ({"hub": {"rotary_inertia": 2.0, **groups["hub"]}} if groups.get("hub") else {}))
    ended = here.beamwave("run", "all")
    assert ended.returncode == 2
    for name, (_, words) in refused.items():
        if words:
            assert re.search(rf"^all/{name}\.nml(:\d+)?: {words}.*; accepted: ", ended.stderr, re.MULTILINE), (name, ended.stderr)


def test_a_swept_radius_is_that_of_the_stiffening(here):
    scene = hubbed(2.0, **TURNING)
    here.scene("swept", scene, {"parameter": "stiffening%hub_radius", "values": [0.1, 0.4]})
    swept = here.run("swept")
    assert swept["hub_radius"].tolist() == [0.1, 0.4]
    for case, radius in enumerate([0.1, 0.4]):
        here.scene("one", scene | {"stiffening": {"hub_radius": radius}})
        one = here.run("one", "--overwrite")
        for name in ("angular_frequency", "hub_angle", "angular_momentum_after"):
            assert one[name].tobytes() == swept[name][case].tobytes(), name


def test_the_scene_of_a_hub_shows_what_it_promises(here):
    path = PROJECT / "input/effects/hub.nml"
    ended = here.beamwave("run", path)
    assert ended.returncode == 0, ended.stderr
    result = here.result("hub")
    text = path.read_text(encoding="utf-8")
    promised = re.findall(r"\d+\.\d+", text[: text.index("&scene")])
    assert promised == [f"{result['angular_frequency'][1]:.2f}", f"{result['hub_rate_change'].sum():.4f}",
                        f"{np.degrees(result['hub_angle'][-1]):.2f}"]
