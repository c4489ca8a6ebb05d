"""Impacts that last: forces, contacts and histories, against figures from solvers of other kinds, limits and each other."""

import math

import contact_scenes
import numpy as np
import pytest
import xarray as xr
from workplace import PAPER_BEAM, example

HERTZ = 4 / 3 * 0.025**0.5 * 2e11 / (2 * 0.91)  # N/m^1.5: a steel sphere of 25 mm on a flat side
BALL = 7870 * 4 / 3 * math.pi * 0.025**3  # kg
LUMPED = {"length": 1.0, "mass_per_length": 8.0, "bending_stiffness": 2e4}
PLACES = {"duration": 0.01, "samples": 512, "points": [0.5, 1.0], "velocity": True, "bending_moment": True}


def struck(contact=None, impact=None, **groups):
    """The paper's beam at rest, struck by that ball."""
    scene = {"beam": dict(PAPER_BEAM), "impact": {"mass": BALL, **(impact or {})}, "contact": contact or {"stiffness": HERTZ}}
    return {**scene, "response": dict(PLACES), **groups}


def run(here, name, scene, status=0):
    here.simulate(name, scene, status=status)
    return here.dataset(f"{name}")


def test_the_scene_of_input_reaches_its_tolerance_with_few_modes(here):
    ds = run(here, "contact", example("contact"))
    assert int(ds["mode_count"]) <= 400 and int(ds["case_status"]) == 0
    for name in ("displacement", "velocity", "bending_moment"):
        assert float(ds[f"{name}_error"].max()) <= 1e-6 * float(np.abs(ds[name]).max()), name
    assert "velocity_jump" not in ds and "impulse" not in ds


def test_a_tolerance_takes_as_many_modes_as_a_short_contact_needs(here):
    # a light sphere on a long beam before reflections return: K = V = rho A sqrt(2 pi h) = 1, Lambda = m^(4/5) = 0.1
    beam = {"length": 60.0, "mass_per_length": 1.0, "bending_stiffness": 0.025330295910584444}
    mass = 0.1**1.25
    scene = struck({"stiffness": 1.0, "max_contacts": 1}, {"mass": mass, "position": 0.5}, beam=beam)
    scene["response"] = {"duration": 6.0, "samples": 64, "points": [0.5]}
    ds = run(here, "long", scene)
    assert int(ds["mode_count"]) > 256  # 64 do not bend within the contact
    # the universal table of the infinite beam, in units of m V/T with T = m^0.4
    assert float(ds["event_force"][0]) == pytest.approx(1.06465 * mass**0.6, rel=1e-4)
    assert float(ds["event_end"][0] - ds["event_time"][0]) == pytest.approx(3.1783 * mass**0.4, rel=1e-4)


def test_a_clamped_root_rests_and_has_no_error(here):
    scene = struck(rotation={"angular_velocity": 30.0}, damping={"ratio": 0.01}, modes={"before": 20})
    scene["response"]["points"] = [0.0, 1.0]
    ds = run(here, "root", scene)
    assert not ds["displacement"][0].values.any()
    root, tip = ds["displacement_error"].values
    assert root <= 1e-9 * float(np.abs(ds["displacement"]).max()) < tip  # rounding, and the modes that are left out


def test_a_ball_in_the_plane_of_rotation_leaves_an_inner_place(here):
    scene = struck(impact={"position": 0.7}, rotation={"angular_velocity": 50.0}, modes={"before": 120})
    ds = run(here, "inner", scene)
    assert float(ds["event_force"][0]) == pytest.approx(7971.446, rel=1e-6)
    assert float(ds["event_end"][0]) == pytest.approx(167.7e-6, abs=0.1e-6)
    assert (ds["event_kind"] > 0).sum() == 1
    # what it has lost is the impulse, but for the 1e-5 that the centrifugal force adds to a velocity in that time
    assert 1 - float(ds["event_impulse"][0]) / BALL == pytest.approx(-0.383432, rel=1e-3)


def test_many_modes_and_few_differ_by_no_more_than_the_error_that_is_given(here):
    many = run(here, "many", struck(modes={"before": 240}))
    for count in (16, 24, 40, 60):
        few = run(here, f"few{count}", struck(modes={"before": count}))
        for name in ("displacement", "velocity", "bending_moment"):
            error = np.abs(few[name] - many[name]).max("time")
            assert (error <= few[f"{name}_error"] + many[f"{name}_error"]).all(), (count, name)
        peak = float(many["contact_force"][0].max())
        assert float(np.abs(few["contact_force"][0] - many["contact_force"][0]).max()) <= float(few["contact_force_error"][0]) + 1e-9 * peak


@pytest.mark.parametrize("kind", ["plain", "initial", "loads"])
def test_estimates_are_near_the_errors_of_a_few_contacts(here, kind):
    """Modes beyond those that are summed hardly act back on a contact: what they add is the error."""
    scene = contact_scenes.draw(np.random.default_rng([1, 2]))
    if kind != "plain":
        scene = contact_scenes.draw_moving(np.random.default_rng([1, 2]), kind)
    ratios = [j.estimate for j in contact_scenes.judge_estimates(lambda scene: run(here, f"{kind}{scene['modes']['before']}", scene), scene)]
    assert len(ratios) >= 5 and min(ratios) >= 1 and np.median(ratios) <= 5, ratios


def test_estimates_are_numbers_of_a_single_mode_and_of_a_motion_that_is_not_known_to_its_end(here):
    cut = {"modes": {"before": 20}, "contact": {"radius": 0.025, "max_contacts": 1}}
    for name, changes, status in (("single", {"modes": {"before": 1}}, 0), ("cut", cut, 4)):
        found = run(here, name, struck({"radius": 0.025}) | changes, status)
        error, known = found["displacement_error"].values, np.abs(found["displacement"]).max("time").values
        assert ((error > 0) == (known > 0)).all() and (error <= 10 * known).all(), (name, error)
        told = float(found["event_end_error"][0] / found["event_end"][0])
        assert (told == 1) == (name == "single"), (name, told)  # of one mode no end is known


@pytest.mark.parametrize("number", [2, 8, 11, 22])
def test_random_contacts_are_those_of_an_integration_of_the_same_modes(here, number):
    """Up to five contacts, which hardly amplify what rounding and the steps leave, 1e-9 of the largest force; that of 2 damps."""
    scene = contact_scenes.draw(np.random.default_rng([1, number]))
    for j in contact_scenes.judge(lambda scene: run(here, f"random{number}", scene), scene):
        assert j.part <= 1e-9 and j.estimate >= 1 and j.contacts <= contact_scenes.FEW, j


def test_accelerations_and_shear_forces_are_those_of_the_motion(here):
    """Newton's law of the whole beam, by trapezoids, and velocities that accelerations integrate to."""
    points = np.linspace(0, 1, 401)
    asked = {"velocity": True, "acceleration": True, "shear_force": True}
    ds = run(here, "rates", struck(modes={"before": 80}, response={"duration": 1e-3, "samples": 2048, "points": points.tolist(), **asked}))
    weights = np.full(401, 7870 * math.pi * 0.037**2 / 4 / 400)
    weights[[0, -1]] /= 2
    acceleration, shear = ds["acceleration"].values, ds["shear_force"].values
    assert np.abs(weights @ acceleration - (shear[-1] - shear[0])).max() <= 1e-3 * np.abs(shear).max()
    force = ds["contact_force"][0].values  # at the tip the shear force is that of the contact
    assert np.abs(shear[-1]).max() == pytest.approx(force.max(), rel=1e-3)
    step = float(ds["time"][1])
    middle = slice(32, None)  # where velocities are smooth between samples
    change = (acceleration[:, 1:] + acceleration[:, :-1])[:, middle] * step / 2
    assert np.abs(np.diff(ds["velocity"].values)[:, middle] - change).max() <= 1e-3 * np.abs(change).max()
    few = run(here, "few_rates", struck(modes={"before": 30}, response={"duration": 1e-3, "samples": 512, "points": [0.5, 1.0], **asked}))
    many = run(here, "many_rates", struck(modes={"before": 240}, response={"duration": 1e-3, "samples": 512, "points": [0.5, 1.0], **asked}))
    for name in ("acceleration", "shear_force"):
        error = np.abs(few[name] - many[name]).max("time")
        estimate = few[f"{name}_error"]
        assert (error <= estimate).all() and float(estimate.max()) <= 30 * float(error.max()), name


def test_the_force_integrates_to_the_impulse_and_its_largest_value_is_given(here):
    ds = run(here, "force", struck(modes={"before": 60}))
    force = ds["contact_force"][0].values
    half = (ds["event_end"][0] - ds["event_time"][0]).item() / 2
    coefficients = np.polynomial.chebyshev.chebfit(-np.cos(np.pi * np.arange(128) / 127), force, 127)
    integral = np.polynomial.chebyshev.chebint(coefficients, lbnd=-1)
    assert half * np.polynomial.chebyshev.chebval(1.0, integral) == pytest.approx(ds["event_impulse"][0].item(), rel=1e-6)
    assert force.max() == pytest.approx(ds["event_force"][0].item(), rel=1e-3)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_the_largest_indentation_has_the_largest_force_of_a_contact_that_does_not_damp(here, exponent):
    ds = run(here, "deep", struck({"stiffness": 1e7, "exponent": exponent}, modes={"before": 20}))
    assert float(ds["event_force"].max()) == pytest.approx(1e7 * float(ds["largest_indentation"]) ** exponent, rel=1e-6)


def test_a_blow_from_the_other_side_is_the_mirrored_one(here):
    one = run(here, "one", struck(modes={"before": 20}))
    other = run(here, "other", struck(impact={"approach_velocity": -1.0}, modes={"before": 20}))
    for name in ("displacement", "velocity", "bending_moment", "contact_force", "event_impulse"):
        assert np.array_equal(one[name], -other[name], equal_nan=True), name
    assert float(one["restitution"]) == float(other["restitution"])


def test_without_a_mass_nothing_moves(here):
    ds = run(here, "nothing", struck(impact={"mass": 0.0}))
    assert (ds["displacement"] == 0).all() and (ds["event_kind"] == 0).all() and np.isnan(ds["restitution"])


def test_a_wall_of_beam_gives_the_ball_back(here):
    # a light ball on a heavy beam, hardly moved: Hertz's contact of a rigid wall, 2.9433 (m²/K²V)^0.2 long
    ds = run(here, "wall", struck(impact={"mass": 1e-6}, modes={"before": 120}, response={"duration": 1e-4, "samples": 4}))
    duration = 2.94327 * ((1.25 * 1e-6) / HERTZ) ** 0.4
    assert float(ds["event_end"][0]) == pytest.approx(duration, rel=1e-2) and float(ds["restitution"]) == pytest.approx(1, abs=0.01)


def test_an_ever_harder_contact_with_capture_goes_to_the_blow_of_the_paper(here):
    scene = {"impact": {"mass_ratio": 0.2}, "capture": {}, "response": {"duration": 0.05, "samples": 1024}}
    instant = run(here, "instant", {"beam": dict(PAPER_BEAM), **scene, "modes": {"before": 400}})
    peak = float(np.abs(instant["displacement"].sel(point=0)).max())
    differences = []
    for power in (9, 10, 11, 12):
        ds = run(here, f"hard{power}", {"beam": dict(PAPER_BEAM), **scene, "contact": {"stiffness": 10.0**power}, "modes": {"before": 64}})
        assert list(ds["event_kind"].values[:2]) == [4, 2]
        differences.append(float(np.abs(ds["displacement"] - instant["displacement"]).sel(point=0).max()) / peak)
    # as the time of capture, 286, 96, 31 and 10 microseconds
    assert differences == pytest.approx([6.9e-2, 2.4e-2, 8.0e-3, 2.7e-3], rel=0.1)


def test_the_motion_goes_on_through_a_capture_and_a_release(here):
    capture = {"capture": {"rotary_inertia": 1e-4}, "release": {"time": 0.005}, "rotation": {"angular_velocity": 40.0}, "stiffening": {}}
    ds = run(here, "held", struck(modes={"before": 60}, **capture, response={**PLACES, "samples": 4096}))
    kinds = list(ds["event_kind"].values[:3])
    assert kinds == [4, 2, 3]
    step = float(ds["time"][1])
    for event in (1, 2):  # the displacement at the tip moves on by its velocity, whatever changes
        j = int(float(ds["event_time"][event]) / step)
        moved = (ds["displacement"][1, j + 1] - ds["displacement"][1, j]).item()
        mean = 0.5 * (ds["velocity"][1, j + 1] + ds["velocity"][1, j]).item()
        assert moved == pytest.approx(mean * step, abs=2e-2 * step)
    assert float(ds["energy_after"][2]) <= float(ds["energy_before"][2]) * (1 + 1e-3)


def test_a_capture_in_a_contact_of_next_to_no_force_is_one(here):
    groups = {"rotation": {"angular_velocity": 28.0}, "stiffening": {}, "capture": {}, "modes": {"before": 5}}
    pulse = {"position": 0.7, "shape": "rectangle", "amplitude": 19.0, "duration": 1.3e-4}
    impact = {"mass": 12.0, "approach_velocity": 2e-9}
    scene = struck({"stiffness": 2e24, "exponent": 10.0}, impact, force=pulse, **groups)
    ds = run(here, "faint", {**scene, "response": {"duration": 0.04, "samples": 64}})
    assert list(ds["event_kind"].values[:2]) == [4, 2]


@pytest.mark.parametrize("tension", [{}, {"stiffening": {"hub_radius": 0.1}}])
def test_energy_goes_on_through_a_soft_contact_a_capture_and_a_release_in_plane(here, tension):
    # with the indentation the mass sits beside the axis, where its centrifugal potential is another one
    turning = {"capture": {}, "release": {"time": 0.008}, "rotation": {"angular_velocity": 50.0}, **tension}
    ds = run(here, "soft", struck({"stiffness": 1e6, "exponent": 1.0}, modes={"before": 60}, **turning))
    assert list(ds["event_kind"].values[:3]) == [4, 2, 3]
    before, after = ds["energy_before"].values[:3], ds["energy_after"].values[:3]
    assert after[0] == pytest.approx(before[0], rel=1e-11)
    assert before[1:] == pytest.approx(after[:2], rel=1e-11)
    lost = float(before[1] - after[1])
    assert 0 < lost < 0.5 * 1e6 * float(ds["event_force"][0]) ** 2 / 1e12 * 1.1  # little more than the stop has stored


def test_a_hard_contact_is_known_though_the_mass_chatters_before(here):
    # waves run ahead of a beam that is let go: many contacts of next to no force, which half of the modes show otherwise
    groups = {"initial": {"force": 200.0}, "modes": {"before": 256}, "response": {"duration": 0.03, "samples": 512}}
    impact = {"mass": 5.0, "approach_velocity": 0.0, "position": 0.5}
    ds = run(here, "plucked", struck({"stiffness": 1e6, "exponent": 1.0}, impact, **groups))
    force = ds["event_force"].values[ds["event_kind"].values == 4]
    hardest = int(force.argmax())
    assert hardest > 10 and force[0] < 1e-9 * force[hardest]
    assert 0 < float(ds["event_time_error"][hardest]) < 1e-6 * float(ds["event_time"][hardest])
    assert float(ds["contact_force_error"][hardest]) < 1e-5 * force[hardest]
    said = here.beamwave("run", "plucked.nml", "--overwrite").stdout
    assert f"  Contact {hardest + 1}, the one with the largest force, lasts" in said and "stay below a millionth of that" in said


def test_contacts_beyond_the_most_end_what_is_known(here):
    ds = run(here, "cut", struck({"stiffness": HERTZ, "max_contacts": 1}, modes={"before": 30}), status=4)
    assert ds.attrs["notes"].count("contacts used up") == 1
    known = np.isfinite(ds["displacement"][0].values)
    assert known[0] and not known[-1]


def test_a_sweep_keeps_sixteen_contacts_and_every_case_is_its_scene(here):
    scene = struck({"radius": 0.025}, modes={"before": 24})
    ds = here.simulate("swept", scene, {"parameter": "contact%radius", "values": [0.02, 0.03]})
    single = run(here, "single", struck({"radius": 0.03}, modes={"before": 24}))
    assert ds.sizes["event"] == 16
    assert np.array_equal(ds["displacement"][1], single["displacement"])
    assert np.array_equal(ds["contact_force"][1, 0], single["contact_force"][0])


def test_hertz_takes_the_material_of_the_piece_that_is_struck(here):
    beam = {"length": [0.5, 0.5], "density": 7870.0, "youngs_modulus": [2e11, 7e10], "width": 0.03, "height": [0.03, 0.04]}
    by_radius = struck({"radius": 0.02}, beam=beam, modes={"before": 24})
    here.scene("swept", by_radius, {"parameter": "impact%position", "values": [0.3, 0.9]})
    ended = here.beamwave("run", "swept.nml")
    assert ended.returncode == 0 and "stiffness of Hertz, p = 1.5" in ended.stdout
    swept = here.dataset("swept")
    for case, (place, modulus) in enumerate([(0.3, 2e11), (0.9, 7e10)]):
        stiffness = 4 / 3 * math.sqrt(0.02) * modulus / (2 * (1 - 0.3**2))
        scene = struck({"stiffness": stiffness}, {"position": place}, beam=beam, modes={"before": 24})
        single = run(here, f"by_stiffness_{case}", scene)
        assert swept["contact_force"][case, 0].values == pytest.approx(single["contact_force"][0].values, rel=1e-11, abs=1e-6)


@pytest.mark.parametrize(
    ("groups", "said"),
    [
        ({"impact": {"restitution": 0.5}}, "impact%restitution: has no meaning with &contact"),
        ({"contact": {"damping": 0.1}}, "has neither stiffness nor radius"),
        ({"contact": {"stiffness": 1e9, "radius": 0.02}}, "excludes"),
        ({"contact": {"stiffness": 1e9, "exponent": 0.5}}, "1 to 10"),
        ({"recontact": {}}, "excludes &recontact"),
        ({"capture": {}, "response": {**PLACES, "acceleration": True}}, "response%acceleration: does not converge after a capture"),
        ({"capture": {}, "response": {**PLACES, "shear_force": True}}, "response%shear_force: does not converge"),
        ({"beam": LUMPED, "contact": {"radius": 0.02}}, "contact%radius: needs the material of the beam"),
        ({"response": None}, "needs &response"),
    ],
)
def test_what_has_no_meaning_is_refused(here, groups, said):
    scene = struck(groups.get("contact"), groups.get("impact"), **{k: v for k, v in groups.items() if k not in ("contact", "impact")})
    here.scene("bad", {name: values for name, values in scene.items() if values is not None})
    ended = here.beamwave("run", "bad.nml")
    assert ended.returncode == 2 and said in ended.stderr, ended.stderr


def test_the_resolved_scene_gives_the_same_values_again(here):
    ds = run(here, "first", struck({"radius": 0.02, "damping": 0.2}, modes={"before": 20}))
    assert "restitution" not in ds.attrs["scene"] and "exponent" not in ds.attrs["scene"]
    here.write("again.nml", ds.attrs["scene"])
    assert np.array_equal(ds["displacement"], here.run("again")["displacement"])


@pytest.mark.parametrize("damping", [7.0, 10.0, 20.0, 1e3])
def test_a_contact_whose_force_is_not_found_says_so_and_is_no_fault(here, damping):
    scene = struck({"radius": 0.02, "damping": damping}, {"mass_ratio": 0.5, "mass": None})
    del scene["impact"]["mass"]
    scene["response"] = {"duration": 0.01, "samples": 50}
    name = here.scene("a", scene)
    assert here.beamwave("check", name).returncode == 0
    ended = here.beamwave("run", name)
    assert ended.returncode in (0, 4), ended.stderr
    if ended.returncode == 4:
        assert "not converged" in ended.stderr or "error of the displacement" in ended.stderr


def test_effects_compares_a_contact(here):
    scene = struck({"radius": 0.02}, response={"duration": 2e-3, "samples": 20})
    name = here.scene("a", scene)
    assert here.beamwave("effects", name).returncode == 0


def test_a_default_tolerance_that_relaxes_is_resolved_to_the_same_run(here):
    scene = struck({"exponent": 1.0, "stiffness": 1e6}, shear={}, stiffening={}, rotation={"angular_velocity": 30.0})
    scene["response"] = {"duration": 2e-3, "samples": 20}
    first = run(here, "first", scene)
    here.write("again.nml", first.attrs["scene"])
    np.testing.assert_array_equal(here.run("again")["displacement"], first["displacement"])


HINGED = {"support": {"rotational_stiffness": 0.0}, "modes": {"before": 40}}  # a beam that turns about its root


@pytest.mark.parametrize(("kind", "number"), [*(("initial", number) for number in (4, 7, 14)), *(("loads", number) for number in (0, 4, 14))])
def test_random_contacts_of_a_beam_that_moves_are_those_of_an_integration(here, kind, number):
    """Up to five contacts, which hardly amplify what rounding and the steps leave, 1e-9 of the largest force."""
    scene = contact_scenes.draw_moving(np.random.default_rng([1, number]), kind)
    for j in contact_scenes.judge(lambda scene: run(here, f"{kind}{number}", scene), scene):
        assert j.part <= 1e-9 and j.estimate >= 1 and j.contacts <= contact_scenes.FEW, j


def test_a_deflection_under_no_force_changes_nothing(here):
    still, let_go = (run(here, name, struck(modes={"before": 40}, **moving)) for name, moving in (("still", {}), ("none", {"initial": {"force": 0.0}})))
    for name in (*contact_scenes.HISTORIES, "contact_force", "event_time", "event_end", "event_impulse"):
        assert np.array_equal(still[name], let_go[name], equal_nan=True), name


def test_a_beam_that_turns_into_a_mass_at_rest_is_struck_as_by_a_mass_that_comes(here):
    """Without rotation a rigid turn moves the beam by what is no force: contacts are those of the mass's own speed."""
    comes = run(here, "comes", struck(impact={"approach_velocity": 2.0, "position": 0.8}, **HINGED))
    meets = run(here, "meets", struck(impact={"approach_velocity": 0.0, "position": 0.8}, initial={"angular_velocity": -2.5}, **HINGED))
    both = run(here, "both", struck(impact={"approach_velocity": 3.0, "position": 0.8}, initial={"angular_velocity": 1.25}, **HINGED))
    turn = comes["time"] * xr.DataArray(PLACES["points"], dims="point")
    for ds, rate in ((meets, -2.5), (both, 1.25)):
        for name, moved in (("event_force", 0.0), ("event_impulse", 0.0), ("displacement", rate * turn), ("bending_moment", 0.0)):
            error = np.abs(ds[name] - (comes[name] + moved)).max()
            assert error <= 1e-9 * np.abs(comes[name]).max(), (rate, name)  # of the force, what steps lack
        # the turn is a mode without a frequency, which nothing but the contact's impulse changes; the digits of its mass and shape
        contacts = ds.isel(event=(ds["event_kind"] > 0).values)
        assert np.allclose(contacts["momentum_before"], contacts["momentum_after"], rtol=1e-11, atol=0)
        assert float(ds["restitution"]) == pytest.approx(float(comes["restitution"]), rel=1e-8)


@pytest.mark.parametrize("place", [1.0, 0.7])
def test_a_mass_at_rest_is_struck_by_nothing_but_the_beam(here, place):
    """A beam bent by 0.02 m is let go: what its sums round to, 1e-17 m, is no contact. One that begins from rest has no restitution."""
    scene = struck(initial={"force": 1000.0, "position": 1.0}, modes={"before": 40})
    scene["impact"] = {"mass_ratio": 0.06, "approach_velocity": 0.0, "position": place}
    ds = run(here, "rest", scene)
    contacts = ds.isel(event=(ds["event_kind"] > 0).values)
    assert float(contacts["event_time"][0]) == 0 and np.isnan(ds["restitution"])
    assert float(contacts["event_force"].min()) > 1e-9 and float((contacts["event_end"] - contacts["event_time"]).min()) > 1e-9
    if place == 1:  # hardly otherwise than one that comes slowly, whose force begins as t^(3/2)
        slow = run(here, "slow", {**scene, "impact": {**scene["impact"], "approach_velocity": 1e-6}})
        for name in ("event_force", "event_end", "event_impulse"):
            assert float(contacts[name][0]) == pytest.approx(float(slow[name][0]), rel=1e-5), name


def test_a_mass_that_never_meets_the_beam_leaves_it_alone(here):
    turning = {"initial": {"angular_velocity": 5.0}, **HINGED}
    ds = run(here, "apart", struck(impact={"approach_velocity": 1.0}, **turning))
    assert ds.sizes.get("event", 0) == 0 or not (ds["event_kind"] > 0).any()
    turn = 5.0 * ds["time"] * xr.DataArray(PLACES["points"], dims="point")
    assert float(np.abs(ds["displacement"] - turn).max()) <= 1e-12 * float(turn.max())


def test_a_beam_comes_back_to_a_mass_that_it_has_left(here):
    """It is let go to the side away from the mass, which follows slowly; contacts conserve the energy of both."""
    scene = struck(impact={"approach_velocity": 0.05}, initial={"force": -500.0}, modes={"before": 30})
    scene["response"]["duration"] = 0.05
    ds = run(here, "back", scene)
    contacts = ds.isel(event=(ds["event_kind"] > 0).values)
    strongest = int(np.argmax(contacts["event_impulse"].values))
    assert float(contacts["event_time"][strongest]) > 0.01 and float(contacts["event_impulse"][strongest]) > 10 * float(contacts["event_impulse"][0])
    assert np.allclose(contacts["energy_after"], contacts["energy_before"], rtol=1e-10)
    assert np.allclose(contacts["energy_before"][1:], contacts["energy_after"][:-1], rtol=1e-10)


def test_a_load_of_nothing_changes_nothing(here):
    """Its histories are summed in another way, so that rounding differs; accelerations are found in the same way."""
    asked = {**PLACES, "acceleration": True, "shear_force": True}
    nothing = {"force": {"shape": "half_sine", "amplitude": 0.0, "duration": 0.002}, "base": {"shape": "sine", "amplitude": 0.0, "frequency": 500.0}}
    plain, loaded = (run(here, name, struck(modes={"before": 30}, response=asked, **loads)) for name, loads in (("plain", {}), ("zero", nothing)))
    for name in ("displacement", "velocity", "bending_moment", "acceleration", "shear_force", "contact_force", "event_time", "event_end", "event_impulse"):
        error = float(np.abs(plain[name] - loaded[name]).max())
        assert error <= 1e-11 * float(np.abs(plain[name]).max()), (name, error)  # five contacts amplify rounding


def test_a_mass_that_loads_never_bring_to_the_beam_leaves_their_motion_alone(here):
    force = {"position": 0.7, "shape": "haversine", "amplitude": 200.0, "start": 1e-3, "duration": 4e-3}
    base = {"shape": "half_sine", "amplitude": -30.0, "duration": 3e-3}
    turning = {"initial": {"angular_velocity": 5.0}, **HINGED}
    apart = run(here, "apart_loaded", struck(impact={"approach_velocity": 1.0}, force=force, base=base, **turning))
    assert apart.sizes.get("event", 0) == 0 or not (apart["event_kind"] > 0).any()
    scene = {"beam": dict(PAPER_BEAM), "force": force, "base": base, "response": dict(PLACES), **turning}
    alone = run(here, "alone_loaded", scene)
    for name in contact_scenes.HISTORIES:
        error, peak = np.abs(apart[name] - alone[name]).max("time"), float(np.abs(alone[name]).max())
        assert (error <= 1e-11 * peak).all(), name


@pytest.mark.parametrize("held", [{}, {"hub": {"rotary_inertia": 2.0}}])
def test_a_load_after_the_last_contact_adds_its_own_motion(here, held):
    """Until the mass is met again all is linear; what the two ways to sum leave, 1e-10 of the peak."""
    force = {"position": 1.0, "shape": "half_sine", "amplitude": -1000.0, "start": 1e-3, "duration": 4e-3}
    both = run(here, "both_act", struck({"radius": 0.025}, {"position": 0.8}, force=force, modes={"before": 40}, **held))
    struck_alone = run(here, "struck_alone", struck({"radius": 0.025}, {"position": 0.8}, modes={"before": 40}, **held))
    forced_alone = run(here, "forced_alone", {"beam": dict(PAPER_BEAM), "force": force, "modes": {"before": 40}, "response": dict(PLACES), **held})
    assert (both["event_kind"] > 0).sum() == 1 and float(both["event_end"][0]) < 1e-3
    for name in (*contact_scenes.HISTORIES, *(["hub_angle"] if held else [])):
        error = float(np.abs(both[name] - struck_alone[name] - forced_alone[name])[..., 1:].max())  # at first the force may jump to a slope
        assert error <= 1e-10 * float(np.abs(both[name]).max()), (name, error)
