"""Forces and motions of the base: closed sums, published figures, limits, balances and each other."""

import itertools

import load_scenes
import numpy as np
import pytest
import xarray as xr
from closed_form import bisect, roots, shapes
from workplace import PAPER_BEAM, example

from conftest import PROJECT

QUANTITIES = ("displacement", "velocity", "acceleration", "bending_moment", "shear_force")
EVERYTHING = dict.fromkeys(QUANTITIES[1:], True)
HALF_SINE = {"amplitude": 100.0, "duration": 1e-3}
PLACES = {"duration": 0.05, "samples": 4096, "points": [0.0, 0.5, 1.0], **EVERYTHING}
BENDING = 2e11 * np.pi * 0.037**4 / 64
MASS = 7870 * np.pi * 0.037**2 / 4


def run(here, name, groups, status=0, **response):
    """A scene of the paper's beam, or of its own."""
    here.simulate(name, {"beam": dict(PAPER_BEAM), "response": {**PLACES, **response}, **groups}, status=status)
    return here.dataset(f"{name}")


def part_between(one, other, quantity):
    """The largest difference of two histories over the peak."""
    return float(np.abs(one[quantity] - other[quantity]).max() / np.abs(other[quantity]).max())


def test_a_half_sine_moves_the_paper_beam_as_its_closed_sum(here):
    reference = np.genfromtxt(PROJECT / "tests/reference/half_sine_responses.txt", skip_header=2, names=True)
    ds = run(here, "half_sine", {"force": HALF_SINE, "modes": {"before": 40}})
    at = {"point": xr.DataArray((2 * reference["xi"]).astype(int)), "time": xr.DataArray(reference["sample"].astype(int))}
    for name in QUANTITIES:
        history = ds[name]
        assert np.abs(history.isel(at) - reference[name]).max() <= 1e-12 * np.abs(history).max(), name
    assert float(ds["applied_impulse"][0]) == pytest.approx(100 * 1e-3 * 2 / np.pi, rel=1e-14)
    assert float(ds["applied_force"][0]) == 100.0


def test_a_tolerance_is_kept_and_few_modes_differ_from_many_by_no_more_than_is_said(here):
    asked = {"acceleration": False, "shear_force": False}
    fine = run(here, "fine", {"force": HALF_SINE, "modes": {"tolerance": 1e-7}}, **asked)
    many = run(here, "many", {"force": HALF_SINE, "modes": {"before": 2048}})
    for name in ("displacement", "velocity", "bending_moment"):
        assert part_between(fine, many, name) <= 1e-7, name
        assert float(fine[f"{name}_error"].max()) <= 1e-7 * float(np.abs(many[name]).max()), name
    few = run(here, "few", {"force": HALF_SINE, "modes": {"before": 16}})
    for name in QUANTITIES:
        error = np.abs(few[name] - many[name]).max("time")
        assert (error <= few[f"{name}_error"] + many[f"{name}_error"]).all(), name
    assert (np.abs(few["displacement"] - many["displacement"]).max("time") <= few["displacement_bound"]).all()


@pytest.mark.parametrize(
    "groups",
    [
        {"rotation": {"angular_velocity": 1e-6}, "stiffening": {}},
        {"beam": {**PAPER_BEAM, "length": [0.3, 0.7]}},
        {"support": {"stiffness": 1e13, "rotational_stiffness": 1e11}},
    ],
    ids=["galerkin", "pieces", "support"],
)
@pytest.mark.parametrize("load", [{"force": {**HALF_SINE, "position": 0.8}}, {"base": {"shape": "triangle", "amplitude": 9.0, "duration": 3e-3}}])
def test_other_ways_to_the_same_modes_give_the_same_motion(here, groups, load):
    # such a root lowers frequencies by some 2e-7, and mode 12 turns 3000 times a radian
    one = run(here, "one", {**load, "modes": {"before": 12}})
    other = run(here, "other", {**load, **groups, "modes": {"before": 12}})
    for name in QUANTITIES:
        assert part_between(other, one, name) <= (1e-3 if "support" in groups else 1e-8), name


@pytest.mark.parametrize("shear", [{}, {"shear": {}}], ids=["bending", "shear"])
def test_a_tip_that_is_held_holds_alike_in_either_way_of_modes(here, shear):
    groups = {"tip_support": {"rotational_stiffness": 0.0}, "base": {"amplitude": 9.0, "duration": 3e-3}, **shear, "modes": {"before": 24}}
    one = run(here, "one", groups)
    other = run(here, "other", {**groups, "rotation": {"angular_velocity": 1e-6}, "stiffening": {}})
    for name in QUANTITIES:
        assert part_between(other, one, name) <= 1e-8, name


def test_what_moves_slowly_follows_its_load_statically(here):
    """A haversine of 20 s: deflection, moment and shear force of a cantilever, as formulas have them, with a body's weight."""
    slow = {"shape": "haversine", "duration": 20.0}
    asked = {"duration": 20.0, "samples": 3, "points": [0.0, 0.4, 1.0]}
    xi = np.array(asked["points"])
    modes = {"modes": {"before": 10}}
    sample = 1  # 6.67 s, where it is 3/4
    ds = run(here, "force", {"force": {**slow, "amplitude": 40.0, "position": 1.0}, **modes}, **asked).isel(time=sample)
    assert ds["displacement"].values == pytest.approx(30 * xi**2 * (3 - xi) / (6 * BENDING), rel=1e-5)
    assert ds["bending_moment"].values == pytest.approx(30 * (1 - xi), rel=1e-5, abs=1e-6)
    assert ds["shear_force"].values == pytest.approx([30.0, 30.0, 30.0], rel=1e-5)
    body = {"body": {"position": 1.0, "mass": 2.0}}
    ds = run(here, "base", {"base": {**slow, "amplitude": -4.0}, **body, **modes}, **asked).isel(time=sample)
    assert ds["shear_force"].values == pytest.approx(3 * (MASS * (1 - xi) + 2.0), rel=1e-5)
    assert ds["bending_moment"].values == pytest.approx(3 * (MASS * (1 - xi) ** 2 / 2 + 2 * (1 - xi)), rel=1e-5, abs=1e-5)
    assert ds["displacement"].values == pytest.approx(
        3 * (MASS * xi**2 * (6 - 4 * xi + xi**2) / (24 * BENDING) + 2 * xi**2 * (3 - xi) / (6 * BENDING)), rel=1e-5
    )


def test_the_root_holds_what_the_beam_does_not_take(here):
    """Momentum: the impulses of the base's and the root's forces are what beam and body move with, here at many points."""
    points = np.linspace(0, 1, 401)
    groups = {"base": {"shape": "half_sine", "amplitude": 50.0, "duration": 2e-3}, "body": {"position": 1.0, "mass": 3.0}}
    ds = run(here, "momentum", {**groups, "modes": {"before": 60}}, duration=4e-3, samples=4096, points=points.tolist())
    velocity = ds["velocity"].values
    weights = np.full(401, 1 / 400.0)
    weights[[0, -1]] /= 2
    momentum = MASS * weights @ velocity + 3.0 * velocity[-1]
    times = ds["time"].values
    base = np.where(times < 2e-3, 50 * np.sin(np.pi * times / 2e-3), 0)
    force = -(MASS + 3.0) * base - ds["shear_force"].isel(point=0).values
    impulse = np.concatenate([[0], np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(times))])
    assert np.abs(momentum - impulse).max() <= 1e-4 * np.abs(momentum).max()  # of the trapezoids


def test_loads_add_up_with_each_other_and_with_a_blow(here):
    modes = {"modes": {"before": 16, "after": 16}}
    force = {"shape": "triangle", "amplitude": 80.0, "duration": 2e-3, "position": 0.6}
    base = {"shape": "sine", "amplitude": 5.0, "frequency": 300.0, "start": 1e-3}
    blow = {"impact": {"mass_ratio": 0.1}, "capture": {}}
    plain = {"acceleration": False, "shear_force": False}
    body = {"body": {"position": 1.0, "mass_ratio": 0.1}}
    alone = [run(here, f"alone{i}", {**groups, **modes}, **plain) for i, groups in enumerate([{"force": force, **body}, {"base": base, **body}, blow])]
    together = run(here, "together", {"force": force, "base": base, **blow, **modes}, **plain)
    for name in ("displacement", "velocity", "bending_moment"):
        total = sum(ds[name] for ds in alone)
        assert float(np.abs(together[name] - total).max()) <= 1e-11 * float(np.abs(total).max()), name
    assert "applied_impulse" in together and list(together["event_kind"].values) == [1, 2]


def test_loads_go_on_through_a_capture_and_a_release(here):
    """A speck of dust that comes and leaves changes nothing, while a force and the base move the beam."""
    loads = {"force": {"shape": "haversine", "amplitude": 60.0, "duration": 0.012}, "base": {"shape": "half_sine", "amplitude": 20.0, "duration": 0.02, "start": 0.002}}
    modes = {"modes": {"before": 24}}
    plain = {"acceleration": False, "shear_force": False}
    alone = run(here, "alone", {**loads, **modes}, **plain)
    dust = {"impact": {"mass_ratio": 1e-11, "approach_velocity": 1e-6}, "capture": {}, "release": {"time": 0.0101}}
    both = run(here, "both", {**loads, **dust, **modes}, **plain)
    for name in ("displacement", "velocity", "bending_moment"):
        assert part_between(both, alone, name) <= 1e-7, name


def pushed(beta, modal, state, pulse, begin, end):
    """Modal displacements and velocities at `end`, from those at `begin`, under the half sine or after it."""
    amplitude, start, rate = pulse
    q, v = state
    driven = modal * amplitude / (beta**2 - rate**2) if start <= begin < start + np.pi / rate else 0.0 * modal
    q = q - driven * np.sin(rate * (begin - start))
    v = v - driven * rate * np.cos(rate * (begin - start))
    turn = beta * (end - begin)
    q, v = q * np.cos(turn) + v / beta * np.sin(turn), v * np.cos(turn) - q * beta * np.sin(turn)
    return q + driven * np.sin(rate * (end - start)), v + driven * rate * np.cos(rate * (end - start))


def test_a_force_goes_on_while_a_mass_comes_and_leaves(here):
    """Against sums of 200 modes in closed form: a force begins at 9 ms and ends at 13 ms, a mass comes at 11 ms and leaves at 40 ms."""
    count, ratio, place, arrival, departure = 200, 0.3, 0.7, 0.011, 0.04
    pulse = (200.0, 0.009, np.pi / 0.004)
    node, weight = np.polynomial.legendre.leggauss(800)
    node, weight = (node + 1) / 2, weight / 2
    alpha = [roots(count, 0.0), roots(count, ratio)]
    along = [shapes(a, node) for a in alpha]
    tip = [shapes(a, [1.0])[0] for a in alpha]
    modal = [weight @ along[0] ** 2, weight @ along[1] ** 2 + ratio * tip[1] ** 2]
    beta = [np.sqrt(BENDING / MASS) * a**2 for a in alpha]
    drive = [shapes(a, [place])[0] / (MASS * m) for a, m in zip(alpha, modal)]
    shared = along[1].T @ (weight[:, np.newaxis] * along[0])
    state = (np.zeros(count), np.zeros(count))
    state = pushed(beta[0], drive[0], state, pulse, pulse[1], arrival)
    come = tuple((shared @ s + ratio * tip[1] * (tip[0] @ s)) / modal[1] for s in state)
    late = pushed(beta[1], drive[1], come, pulse, arrival, 0.013)
    late = pushed(beta[1], drive[1], late, pulse, 0.013, departure)
    energy = MASS / 2 * (modal[1] @ (late[1] ** 2 + (beta[1] * late[0]) ** 2))
    left = tuple(shared.T @ s / modal[0] for s in late)
    groups = {"force": {"position": place, "amplitude": pulse[0], "start": pulse[1], "duration": 0.004}, "modes": {"before": 64, "after": 64},
              "body": {"position": 1.0, "mass_ratio": ratio, "from": arrival, "until": departure}}  # fmt: skip
    plain = {"acceleration": False, "shear_force": False, "points": [0.5, 1.0], "samples": 500}
    ds = run(here, "a", groups, **plain)
    times = ds["time"].values
    for begin, end, first in ((arrival, 0.013, 0), (0.013, departure, 0), (departure, 0.05, 1)):
        inside = times[(times >= begin) & (times < end)]
        at = [come, pushed(beta[1], drive[1], come, pulse, arrival, 0.013), left][(begin > arrival) + (begin >= departure)]
        which = 1 - first
        moved = np.stack([shapes(alpha[which], [0.5, 1.0]) @ pushed(beta[which], drive[which], at, pulse, begin, t)[0] for t in inside], axis=1)
        off = np.abs(ds["displacement"].sel(time=inside).values - moved).max(axis=1)
        assert (off <= ds["displacement_error"].values).all(), (begin, off)
    peak = np.abs(ds["displacement"]).max("time").values
    assert (ds["displacement_error"].values <= 2e-6 * peak).all()
    np.testing.assert_allclose(ds["energy_before"][1], energy, rtol=1e-5)
    np.testing.assert_allclose(ds["momentum_after"], ds["momentum_before"], rtol=1e-10)


def test_a_spring_that_comes_to_a_beam_under_a_force_pulls_towards_where_it_met_it(here):
    """All is slow: deflections are static ones, and what they lag behind is in the tolerance."""
    stiffness, turning, b, met = 2e6, 3e4, 0.6, 1000.0
    groups = {"force": {"shape": "haversine", "amplitude": met, "duration": 40.0}, "damping": {"ratio": 0.05}, "modes": {"before": 32, "after": 32},
              "body": {"position": b, "mass": 0.0, "stiffness": stiffness, "rotational_stiffness": turning, "from": 20.0}}  # fmt: skip
    ds = run(here, "a", groups, acceleration=False, shear_force=False, duration=36.0, samples=64, points=[b, 1.0])
    by_force = np.array([b**2 * (3 - b) / 6, (2 * b - b**2) / 2, 1 / 3]) / BENDING  # deflection and slope at the spring, deflection at the tip
    by_spring = np.array([[b**3 / 3, b**2 / 2, b**2 * (3 - b) / 6], [b**2 / 2, b, b**2 / 2 + b * (1 - b)]]) / BENDING  # under its force, its moment
    held = by_spring[:, :2].T * [stiffness, turning]
    late = ds.sel(time=slice(25, None))
    force = met / 2 * (1 - np.cos(2 * np.pi * late["time"].values / 40))
    at_spring = np.linalg.solve(np.eye(2) + held, np.outer(by_force[:2], force) + np.outer(held @ by_force[:2], np.full_like(force, met)))
    pulled = (np.array([stiffness, turning]) * by_spring[:, 2]) @ (at_spring - met * by_force[:2, np.newaxis])
    expected = np.stack([at_spring[0], by_force[2] * force - pulled])
    np.testing.assert_allclose(late["displacement"].values, expected, rtol=1e-5)
    np.testing.assert_allclose(ds["energy_after"], met**2 / 2 * by_force[2], rtol=1e-5)


def test_a_rigid_spring_comes_to_a_beam_under_a_force_and_leaves(here):
    """Against sums of clamped-free and clamped-pinned modes: the tip is held where it is from 5.3 to 11.7 ms."""
    count, place, arrival, ends, departure, points = 220, 0.5, 0.0053, 0.008, 0.0117, [0.3, 0.7]
    pulse = (1000.0, 0.0, np.pi / ends)
    node, weight = np.polynomial.legendre.leggauss(900)
    node, weight = (node + 1) / 2, weight / 2
    turns = np.pi * np.arange(1, count + 1)
    alpha = [roots(count, 0.0), bisect(lambda a: np.cos(a) * np.tanh(a) - np.sin(a), turns + 0.5, turns + 1.0)]
    along, beta = [shapes(a, node) for a in alpha], [np.sqrt(BENDING / MASS) * a**2 for a in alpha]
    modal = [weight @ s**2 for s in along]
    drive = [shapes(a, [place])[0] / (MASS * m) for a, m in zip(alpha, modal)]
    moved = [s.T * weight / m[:, np.newaxis] for s, m in zip(along, modal)]  # modal displacements of a shape at the nodes

    def follow(which, state, begin, end):
        return pushed(beta[which], drive[which], state, pulse, begin, end)

    def bent(x):
        return (3 * np.square(x) - np.power(x, 3)) / 2  # by a tip that moves by 1

    start = (np.zeros(count), np.zeros(count))
    free = follow(0, start, 0.0, arrival)
    tip = shapes(alpha[0], [1.0])[0] @ free[0]
    come = (moved[1] @ (along[0] @ free[0] - tip * bent(node)), moved[1] @ along[0] @ free[1])
    pushed_no_more = follow(1, come, arrival, ends)
    late = follow(1, pushed_no_more, ends, departure)
    left = (moved[0] @ (along[1] @ late[0] + tip * bent(node)), moved[0] @ along[1] @ late[1])
    groups = {"force": {"position": place, "amplitude": pulse[0], "duration": ends}, "modes": {"before": 32, "after": 32},
              "body": {"position": 1.0, "mass": 0.0, "stiffness": 1e24, "from": arrival, "until": departure}}  # fmt: skip
    ds = run(here, "a", groups, acceleration=False, shear_force=False, points=points, samples=500)
    parts = [(0, start, 0.0, arrival), (1, come, arrival, ends), (1, pushed_no_more, ends, departure), (0, left, departure, 0.05)]
    expected = [
        which * tip * bent(np.array(points)) + shapes(alpha[which], points) @ follow(which, state, begin, t)[0]
        for which, state, begin, end in parts
        for t in ds["time"].values[(ds["time"] >= begin) & (ds["time"] < end)]
    ]
    off, peak = np.abs(ds["displacement"].values - np.transpose(expected)).max(axis=1), np.abs(expected).max()
    told = ds["displacement_error"].values
    assert (off <= told).all() and (told <= 0.01 * peak).all(), (off / peak, told / peak)
    assert ds["momentum_after"].isnull().values.tolist() == [True, False]  # per unit of the tip's displacement, which is held first


def test_loads_add_to_a_beam_that_is_let_go_and_meets_bodies(here):
    plain = {"acceleration": False, "shear_force": False}
    bodies = {"body": {"position": 0.6, "mass": 2.0, "stiffness": 1e5, "rotational_stiffness": 1e4, "from": 0.01, "velocity": 0.5}, "modes": {"before": 24, "after": 24}}
    loads = {"force": {"position": 0.4, "amplitude": 300.0, "duration": 0.02}, "base": {"shape": "sine", "amplitude": 5.0, "frequency": 90.0}}
    start = {"initial": {"force": 200.0}}
    still = {"body": {**bodies["body"], "velocity": 0.0}}
    whole = run(here, "whole", {**bodies, **loads, **start}, **plain)
    parts = [run(here, "free", {**bodies, **start}, **plain), run(here, "loads", {**bodies, **still, **loads}, **plain)]
    for name in ("displacement", "velocity", "bending_moment"):
        total = sum(ds[name] for ds in parts)
        assert float(np.abs(whole[name] - total).max()) <= 1e-12 * float(np.abs(total).max()), name
    assert (whole["energy_after"] != parts[0]["energy_after"]).all()  # of the whole motion, not of that without loads


def test_a_force_from_a_file_is_read_in_its_own_units_and_times(here):
    """A triangle, as a logger has it in kN and ms, with a pretrigger, and as bare numbers; neither fits the samples of the histories."""
    times = np.arange(-40, 200) * 2e-5
    triangle = np.clip(1 - np.abs(times / 1e-3 - 1), 0, None) * 70
    rows = "\n".join(f"{1e3 * t:.6f};{f / 1e3:.12g};{i}" for i, (t, f) in enumerate(zip(times, triangle)))
    here.write("hammer.csv", f"time [ms];force [kN];count\n{rows}\n")
    here.write("bare.txt", "\n".join(f"{f:.12g}" for f in triangle) + "\n")
    modes = {"modes": {"before": 12}}
    shape = run(here, "shape", {"force": {"shape": "triangle", "amplitude": 70.0, "duration": 2e-3, "position": 0.5}, **modes})
    measured = {"shape": "file", "position": 0.5}
    named = run(here, "named", {"force": {**measured, "file": "hammer.csv", "column": "force"}, **modes})
    bare = run(here, "bare", {"force": {**measured, "file": "bare.txt", "sample_rate": 5e4, "start": -8e-4}, **modes})
    for name in QUANTITIES:
        assert part_between(named, shape, name) <= 1e-10 and part_between(bare, shape, name) <= 1e-10, name
    assert float(named["applied_impulse"][0]) == pytest.approx(0.07, rel=1e-9)


@pytest.mark.parametrize("contact", [{}, {"impact": {"mass": 0.1, "approach_velocity": 1.0}, "contact": {"stiffness": 1e6}}])
def test_what_of_a_force_comes_before_the_start_is_said(here, contact):
    force = {"shape": "triangle", "amplitude": 10.0, "duration": 0.004, "start": -0.001}
    groups = {**contact, "modes": {"before": 8}}
    noted = run(here, "cut", {"force": force, **groups}).attrs["notes"]
    assert "force 1: 12.5 % of its impulse lies before t = 0" in noted  # a quarter of the base, an eighth of the area
    assert "before t = 0" not in run(here, "whole", {"force": {**force, "start": 0.0}, **groups}).attrs.get("notes", "")


def test_a_force_from_a_result_of_beamwave_is_read(here):
    """The acceleration of one beam's tip shakes another beam: a NetCDF file, a column by its name."""
    shaker = run(here, "shaker", {"force": HALF_SINE, "modes": {"before": 8}}, samples=512)
    groups = {"base": {"shape": "file", "file": "output/shaker.nc", "column": "acceleration(3)"}, "modes": {"before": 8}}
    shaken = here.simulate("shaken", {"beam": dict(PAPER_BEAM), "response": {"duration": 0.05, "samples": 256}, **groups})
    assert float(shaken["applied_acceleration"][0]) == float(np.abs(shaker["acceleration"][2]).max())


def test_a_file_that_has_changed_is_another_scene(here):
    here.write("pulse.csv", "time,force\n0,0\n0.001,5\n0.002,0\n")
    here.scene("pulse", {"beam": dict(PAPER_BEAM), "force": {"shape": "file", "file": "pulse.csv"}, "response": {"duration": 0.01, "samples": 64}})
    assert here.beamwave("run", "pulse.nml").returncode == 0
    assert "nothing to do" in here.beamwave("run", "pulse.nml").stdout
    here.write("pulse.csv", "time,force\n0,0\n0.001,6\n0.002,0\n")
    again = here.beamwave("run", "pulse.nml")
    assert again.returncode == 3 and "--overwrite" in again.stderr


def test_waves_are_measured_after_the_load(here):
    ds = run(here, "hammer", example("force"))
    free = ds["angular_frequency"].values[:6]
    for beta in free:
        peak = int(np.abs(ds["measured_angular_frequency"] - beta).argmin("peak"))
        assert abs(float(ds["measured_angular_frequency"][peak]) - beta) <= float(ds["measured_angular_frequency_error"][peak])
    driven = run(here, "driven", {"force": {"shape": "sine", "frequency": 30.0, "amplitude": 1.0}, "spectrum": {}}, samples=512)
    assert int(driven["peak_count"]) == 0 and "no sample comes after" in driven.attrs["notes"]


def test_a_rectangle_has_no_acceleration_and_a_slow_tolerance_for_shear(here):
    step = {"force": {"shape": "rectangle", "amplitude": 10.0, "position": 0.5}}
    ds = run(here, "step", {**step, "modes": {"before": 64}}, acceleration=False)
    wide = run(here, "wide", {**step, "modes": {"before": 512}}, acceleration=False)
    for name in ("displacement", "velocity", "bending_moment"):
        assert (np.abs(ds[name] - wide[name]).max("time") <= ds[f"{name}_error"] + wide[f"{name}_error"]).all(), name


def test_a_growing_mode_is_driven_too(here):
    """Above the critical speed: until numbers run out, and as the closed form of one mode grows."""
    groups = {"rotation": {"angular_velocity": 400.0}, "force": {"shape": "rectangle", "amplitude": 1.0, "duration": 0.01}}
    ds = run(here, "grows", {**groups, "modes": {"before": 8}}, acceleration=False, duration=0.05)
    beta, tip, mass = float(ds["growth_rate"][0]), 2.0, float(ds["modal_mass"][0])
    late = ds.isel(time=-1)
    grown = tip**2 / mass / beta**2 * (np.cosh(beta * float(late["time"])) - np.cosh(beta * (float(late["time"]) - 0.01)))
    assert float(late["displacement"].isel(point=2)) == pytest.approx(grown, rel=1e-3)
    long = run(here, "overflows", {**groups, "modes": {"before": 8}}, status=4, acceleration=False, duration=5.0, samples=128)
    assert int(long["case_status"]) == 1 and "overflow" in long.attrs["notes"]


@pytest.mark.parametrize(
    "groups, words",
    [
        ({"force": {"duration": 1e-3}}, "force%amplitude: is missing"),
        ({"force": {"shape": "sine", "amplitude": 1.0}}, "force%frequency: is missing"),
        ({"force": {"amplitude": 1.0, "frequency": 3.0}}, "force%frequency: has no meaning"),
        ({"force": {"shape": "file", "amplitude": 1.0, "file": "a.csv"}}, "force%amplitude: has no meaning"),
        ({"force": {"shape": "square", "amplitude": 1.0}}, "force%shape"),
        ({"force": {"amplitude": 1.0, "start": 1.0}}, "after the end of the histories"),
        ({"force": {"amplitude": 1.0, "position": 1.5}}, "force%position"),
        ({"force": {"shape": "rectangle", "amplitude": 1.0}}, "response%acceleration: does not converge"),
        ({"force": {"shape": "sine", "amplitude": 1.0, "frequency": 100.0, "duration": 0.0123}}, "response%acceleration: does not converge"),
        ({"impact": {"mass_ratio": 0.1}, "modes": {"before": 5}}, "after an instantaneous blow; accepted: .false., or &contact"),
        ({"initial": {"force": 1.0}}, "response%acceleration: does not converge if bodies come or leave"),
        ({"force": HALF_SINE, "body": {"position": 0.5, "mass": 1.0, "until": 0.01}}, "does not converge if bodies come or leave"),
        (
            {"force": HALF_SINE, "impact": {"mass_ratio": 0.1}, "contact": {"radius": 0.02}, "capture": {}},
            "response%acceleration: does not converge after a capture",
        ),
        ({}, "needs &impact, &force, &base, &initial or &body"),
    ],
)
def test_what_has_no_meaning_is_refused_with_its_place(here, groups, words):
    here.scene("bad", {"beam": dict(PAPER_BEAM), **groups, "response": dict(PLACES)})
    ended = here.beamwave("run", "bad.nml")
    assert ended.returncode == 2 and words in ended.stderr, ended.stderr
    assert all(line.startswith("bad.nml:") for line in ended.stderr.splitlines())


@pytest.mark.parametrize(
    "text, names, status, words",
    [
        ("time,force\n0,1\n0.001,0\n", {}, 2, "begins or ends abruptly, with 1 N"),
        ("time,force\n0,0\n0.001,1\n0.002,0\n", {"start": -0.0005}, 2, "accepted: a later start"),
        ("time,force,second\n0,0,0\n0.001,0,0\n", {}, 2, "a.csv has 2 columns"),
        ("time,force\n0,0\n0.001,0\n", {"column": "Force"}, 2, "force%column"),
        ("1\n2\n", {}, 2, "force%time: no such column"),
        ("time,force\n0,0\n", {}, 2, "fewer than two samples"),
        ("time,force\n0,0\n0.002,1\n0.001,0\n", {}, 3, "is not above the one before it"),
        ("time,force\n0,0\n0.002,1\n0.003,0\n", {"start": -0.003}, 2, "force%start: all of it lies before t = 0"),
        ("time [s],force [K]\n0,0\n0.002,1\n0.003,0\n", {}, 2, "force%scale: is missing"),
        (None, {}, 3, "a.csv: cannot be read"),
    ],
)
def test_a_file_without_a_force_is_refused_before_any_work(here, text, names, status, words):
    if text is not None:
        here.write("a.csv", text)
    here.scene("bad", {"beam": dict(PAPER_BEAM), "force": {"shape": "file", "file": "a.csv", **names}, "response": dict(PLACES)})
    for command in ("check", "run"):
        ended = here.beamwave(command, "bad.nml")
        assert ended.returncode == status and words in ended.stderr, ended.stderr
    assert not list(here.directory.glob("output/bad*"))


def test_a_force_that_ends_with_its_rounding_leaves_accelerations_a_limit(here):
    here.write("pulse.csv", "time,force\n0,0\n0.001,2000\n0.002,4.75e-12\n")
    groups = {"force": {"shape": "file", "file": "pulse.csv"}, "response": {**PLACES, "acceleration": True}}
    assert np.isfinite(run(here, "rounded", groups)["acceleration_error"]).all()


@pytest.mark.parametrize("kind", ["force", "base", "hub_base", "let_go"])
def test_estimates_and_bounds_hold_in_random_scenes(here, kind):
    rng = np.random.default_rng(2026)

    def run_scene(scene):
        return run(here, f"scene{next(number)}", scene)

    number = itertools.count()
    judged = [j for _ in range(8) for j in load_scenes.judge(run_scene, load_scenes.draw(rng, kind), int(rng.choice(load_scenes.COUNTS)))]
    assert len(judged) > 33 and min(j.bound for j in judged) >= 1
    ratios = np.array([j.estimate for j in judged])
    assert ratios.min() >= 1 and np.median(ratios) <= 8


def test_the_bound_of_a_beam_that_is_let_go_is_its_error_at_the_force_at_first(here):
    asked = {"points": [0.5, 1.0], **dict.fromkeys(EVERYTHING, False)}
    ds = run(here, "let_go", {"initial": {"force": 1000.0}, "modes": {"before": 8}}, **asked)
    at_rest = 1000.0 / BENDING * np.array([0.5**2 / 2 - 0.5**3 / 6, 1 / 3])
    error = np.abs(ds["displacement"].isel(time=0) - at_rest)
    assert (error <= ds["displacement_bound"]).all()
    assert float(error[1]) == pytest.approx(float(ds["displacement_bound"][1]), rel=1e-8)


@pytest.mark.parametrize(
    ("root", "turning"),
    [({"hub": {"rotary_inertia": 2.0}}, {}), ({"support": {"rotational_stiffness": 1e4}}, {"angular_velocity": 3.0})],
    ids=["hub", "turning"],
)
def test_a_beam_that_turns_too_when_it_is_let_go_has_an_estimate_alone(here, root, turning):
    asked = {"samples": 64, **dict.fromkeys(EVERYTHING, False)}
    ds = run(here, "turning", {**root, "initial": {"force": 10.0, **turning}, "modes": {"before": 8}}, **asked)
    assert "displacement_bound" not in ds and (ds["displacement_error"] > 0).any()
