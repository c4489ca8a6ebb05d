"""Bodies come and leave while a mass strikes the beam for some time, against an integration of its own, limits and balances."""

import contact_reference
import numpy as np
import pytest
from contact_changes_reference import Body, Change, follow
from contact_scenes import load_of
from workplace import group_text

UNIT_BEAM = {"length": 1.0, "mass_per_length": 1.0, "bending_stiffness": 1.0}
COUNT, MASS, STIFFNESS = 20, 0.06, 2e5
HISTORY = {"duration": 0.05, "samples": 200, "points": [0.4, 1.0], "velocity": True}
BLOW = (("impact", {"mass": MASS, "approach_velocity": 1.0}), ("contact", {"stiffness": STIFFNESS, "exponent": 1.5}))
CONTACT, CAPTURE, ARRIVAL = 4, 2, 5


def run(here, name, *groups, count=COUNT, blow=BLOW, beam=UNIT_BEAM, history=HISTORY):
    counts = ("modes", {"before": count, "after": count})
    here.write(
        f"{name}.nml",
        "".join(group_text(*group) for group in (("beam", beam), *blow, *groups, counts, ("response", history))),
    )
    return here.run(name)


def of_body(position, **values):
    return "body", {"position": position, **values}


LOCK = {"stiffness": 300.0, "rotational_stiffness": 50.0}
COMES = of_body(0.6, mass=0.3, **{"from": 0.0041}, velocity=-0.4)
LOCKS = of_body(1.0, mass=0.0, **{"from": 0.0041}, **LOCK)
LATE = of_body(0.6, mass=0.1, **{"from": 0.0201}, **LOCK)
CHANGES = {  # place, group, the body before and after, when
    "a body leaves between two contacts": (0.6, of_body(0.6, mass=0.3, until=0.0201), Body(0.6, 0.3), None, 0.0201),
    "a body comes with a velocity in a contact": (0.6, COMES, None, Body(0.6, 0.3, velocity=-0.4), 0.0041),
    "a joint locks at the tip in a contact": (1.0, LOCKS, None, Body(1.0, 0.0, 300.0, 50.0), 0.0041),
    "a joint locks between two contacts": (0.6, LATE, None, Body(0.6, 0.1, 300.0, 50.0), 0.0201),
    "a body comes at the struck place": (1.0, of_body(1.0, mass=0.1, **{"from": 0.0031}), None, Body(1.0, 0.1), 0.0031),
}


def blow_under(*loads):
    """What strikes in the scenes of `run`, for the integration."""
    times = np.arange(200) * 0.05 / 200
    blow = contact_reference.Blow(1, 1, 1, COUNT, MASS, 1.0, 1.0, STIFFNESS, 1.5, 0, 0, 0, False, [0.4, 1.0], times, 0.05, 100)
    blow.loads = [load_of(values, 1.0, 1.0 if kind == "base" else None) for kind, values in loads]
    return blow


def compare(result, motion):
    """Contacts and histories are those of the integration."""
    contacts = result["event_kind"] == CONTACT
    assert contacts.sum() == len(motion.start)
    for quantity, expected, limit in (("displacement", motion.displacement, 1e-9), ("velocity", motion.velocity, 2e-6)):
        expected = np.array(expected).T  # F' after 0.3 us
        np.testing.assert_allclose(result[quantity], expected, rtol=0, atol=limit * np.abs(expected).max())
    for quantity, expected in (("event_time", motion.start), ("event_end", motion.end), ("event_impulse", motion.impulse)):
        np.testing.assert_allclose(result[quantity][contacts], expected, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(result["event_force"][contacts], motion.largest, rtol=1e-8)


def goes_to_the_capture_at_once(here, kinds, *groups):
    """Whether a stiff contact does as modes are added, as count^(-3/2), until the mass leaves."""
    history = HISTORY | {"velocity": False}
    at_once = run(here, "once", *groups, blow=BLOW[:1], count=400, history=history)["displacement"]
    stiff = (BLOW[0], ("contact", {"stiffness": 1e13, "exponent": 1.0}))
    apart = []
    for count in (16, 64):
        result = run(here, f"n{count}", *groups, blow=stiff, count=count, history=history)
        assert list(result["event_kind"][: len(kinds)]) == kinds
        apart.append(np.abs(result["displacement"] - at_once)[:, :160].max() / np.abs(at_once).max())
    return apart[1] < 2e-4 and apart[1] < 0.15 * apart[0]


@pytest.mark.parametrize("name", CHANGES)
def test_contacts_and_changes_are_those_of_an_integration(here, name):
    place, group, before, after, time = CHANGES[name]
    result = run(here, "a", group)
    motion = follow(blow_under(), place, [Change(0.0, before, False), Change(time, after, after is not None)], COUNT)
    assert (result["event_kind"] > 0).sum() == len(motion.start) + 1
    compare(result, motion)


@pytest.mark.parametrize("time", [0.0, 0.0041, 0.0201])
def test_a_body_of_no_mass_changes_nothing(here, time):
    beside = run(here, "beside", of_body(0.6, mass=0.0))
    result = run(here, "a", of_body(0.6, mass=0.0, **{"from": time}))
    for quantity in ("displacement", "velocity"):
        limit = 1e-12 if quantity == "displacement" else 1e-9  # of a sample in the last of the contact
        np.testing.assert_allclose(
            result[quantity], beside[quantity], rtol=0, atol=limit * np.abs(beside[quantity]).max()
        )
    there = result["event_kind"] == CONTACT
    np.testing.assert_allclose(result["event_impulse"][there], beside["event_impulse"][: there.sum()], rtol=1e-10)
    np.testing.assert_allclose(result["energy_after"][there], beside["energy_after"][: there.sum()], rtol=1e-10)


def test_a_change_in_a_contact_takes_no_part_in_its_balance(here):
    """Nothing damps: the contact loses nothing, and what the body brings is that of the change."""
    result = run(here, "a", COMES, count=60)
    assert list(result["event_kind"][:2]) == [CONTACT, ARRIVAL]
    np.testing.assert_allclose(
        result["energy_after"][0], result["energy_before"][0], rtol=1e-4
    )  # the force jumps by what modes lack
    np.testing.assert_allclose(result["momentum_after"][1], result["momentum_before"][1], rtol=1e-11)


def test_a_contact_that_damps_goes_on_when_a_body_comes(here):
    """The force is nearly what it was: the new modes lack little of the gap, and the indentation goes on closing as it did."""
    blow = (
        ("impact", {"mass": 0.12538, "approach_velocity": -1.0}),
        ("contact", {"stiffness": 6.18e7, "exponent": 1.5, "damping": 0.14}),
    )
    history = HISTORY | {"duration": 0.003}
    groups = (of_body(0.681, mass=0.08, stiffness=157.0, rotational_stiffness=9.8, **{"from": 0.0023}),)
    result = run(here, "a", *groups, blow=blow, count=44, history=history)
    fine = run(here, "fine", *groups, blow=blow, count=176, history=history)
    assert list(result["event_kind"][:2]) == [CONTACT, ARRIVAL]
    peak = np.abs(fine["contact_force"][0]).max()
    np.testing.assert_allclose(result["contact_force"][0], fine["contact_force"][0], rtol=0, atol=0.15 * peak)
    assert (np.abs(result["displacement"] - fine["displacement"]).max(axis=1) <= result["displacement_error"]).all()


def test_a_tolerance_is_kept_where_a_body_comes_in_a_contact(here):
    groups = (of_body(0.6, mass=0.1, stiffness=300.0, **{"from": 0.0041}),)
    history = HISTORY | {"duration": 0.02, "velocity": False}
    fine = run(here, "fine", *groups, count=512, history=history)["displacement"]
    here.write(
        "a.nml",
        "".join(
            group_text(*group)
            for group in (("beam", UNIT_BEAM), *BLOW, *groups, ("modes", {"tolerance": 1e-4}), ("response", history))
        ),
    )
    result = here.run("a")
    assert result["displacement_error"].max() <= 1e-4 * np.abs(fine).max() * 1.01
    assert (np.abs(result["displacement"] - fine).max(axis=1) <= result["displacement_error"]).all()


def test_a_stiff_contact_that_captures_is_the_capture_at_once(here):
    """Also when a further body comes; how the modes share what is left when the mass leaves differs for long."""
    groups = (("capture", {}), of_body(0.5, mass=0.2, **{"from": 0.0201}, velocity=0.3), ("release", {"time": 0.04}))
    assert goes_to_the_capture_at_once(here, [CONTACT, CAPTURE, ARRIVAL, 3], *groups)


DIES = ("damping", {"stiffness_proportional": 1e-5})  # high modes do so at once
ESTIMATED = {
    "captured with its inertia": (("capture", {"rotary_inertia": 2e-3}),),
    "captured where high modes die": (("capture", {}), DIES),
    "captured and let go": (("capture", {}), ("damping", {"ratio": 0.01}), ("release", {"time": 0.03})),
    "a body comes with a velocity in a contact": (COMES, DIES),
    "a body leaves under a force": (
        of_body(0.6, mass=0.3, until=0.0201),
        ("force", {"position": 0.5, "amplitude": 3.0, "shape": "half_sine", "duration": 0.01}),
    ),
}


@pytest.mark.parametrize("name", ESTIMATED)
def test_estimates_are_near_the_errors_that_changes_leave(here, name):
    """What the motion hands on to modes that are missing is counted, and so is what they would have handed on to those that are not."""
    history = HISTORY | {"bending_moment": True, "samples": 60}
    few, many = (run(here, f"n{count}", *ESTIMATED[name], count=count, history=history) for count in (24, 192))
    ratios = []
    for quantity in ("displacement", "velocity", "bending_moment"):
        error = np.abs(few[quantity] - many[quantity]).max(axis=1)
        told = few[f"{quantity}_error"]
        assert (error <= told).all(), quantity
        ratios.extend((told[error > 0] / error[error > 0]).tolist())
    assert np.median(ratios) <= 8


def test_what_a_long_contact_presses_goes_over_as_a_light_body_leaves(here):
    """Modes that are not summed give way to it, and hand that on; what is told counts that later octaves fall slowly."""
    blow = (
        ("impact", {"mass": 2.8, "position": 0.574, "approach_velocity": 0.0154}),
        ("contact", {"stiffness": 2720.0, "exponent": 1.5}),
    )
    history = HISTORY | {"duration": 0.1, "samples": 512, "points": [0.25, 0.5], "bending_moment": True}
    body = of_body(0.85, mass=0.017, until=0.0295)
    few, many = (run(here, f"n{count}", body, blow=blow, count=count, history=history) for count in (20, 160))
    for quantity in ("velocity", "bending_moment"):
        error = np.abs(few[quantity] - many[quantity]).max(axis=1)
        assert (error <= few[f"{quantity}_error"]).all() and (few[f"{quantity}_error"] <= 8 * error).all(), quantity


def test_a_capture_from_the_other_side_has_the_same_errors(here):
    """Where its time follows from the error of the force."""
    beam = {"length": 1.0, "width": 0.04, "height": 0.012, "youngs_modulus": 7e10, "density": 2700.0}
    told = []
    for name, velocity in (("above", 1.0), ("below", -1.0)):
        impact = {"mass": 0.3, "position": 0.8, "approach_velocity": velocity}
        blow = (("impact", impact), ("contact", {"stiffness": 1e7, "exponent": 1.5}))
        told.append(run(here, name, ("capture", {}), blow=blow, beam=beam)["event_end_error"][:2])
    np.testing.assert_allclose(told[0], told[1], rtol=1e-6)  # rounding of a difference
