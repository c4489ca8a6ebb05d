"""Loads beside a contact of a finite duration while bodies come and leave, or the mass is captured: an integration, limits, sums."""

import numpy as np
import pytest
from contact_changes_reference import Body, Change, follow
from test_contact_changes import BLOW, CAPTURE, COMES, CONTACT, COUNT, LOCKS, blow_under, compare, goes_to_the_capture_at_once, of_body, run

PULSE = ("force", {"shape": "half_sine", "amplitude": 8.0, "start": 0.0021, "duration": 0.02, "position": 0.8})
TONE = ("force", {"shape": "sine", "amplitude": -5.0, "start": 0.0, "duration": 0.05, "frequency": 60.0, "position": 0.5})
SHAKEN = ("base", {"shape": "haversine", "amplitude": 30.0, "start": 0.001, "duration": 0.03})
CASES = {  # load, place, group, the body before and after, when
    "a body leaves in a flight under a half sine": (PULSE, 0.6, of_body(0.6, mass=0.3, until=0.0201), Body(0.6, 0.3), None, 0.0201),
    "a body comes in a contact under a tone": (TONE, 0.6, COMES, None, Body(0.6, 0.3, velocity=-0.4), 0.0041),
    "a body comes to a shaken beam": (SHAKEN, 0.6, of_body(0.6, mass=0.1, **{"from": 0.0201}), None, Body(0.6, 0.1), 0.0201),
    "a joint locks at the tip under a half sine": (PULSE, 1.0, LOCKS, None, Body(1.0, 0.0, 300.0, 50.0), 0.0041),
}


@pytest.mark.parametrize("name", CASES)
def test_contacts_and_changes_under_loads_are_those_of_an_integration(here, name):
    load, place, group, before, after, time = CASES[name]
    result = run(here, "a", group, load)
    changes = [Change(0.0, before, False), Change(time, after, after is not None)]
    compare(result, follow(blow_under(load), place, changes, COUNT))


@pytest.mark.parametrize("load", [PULSE, SHAKEN])
def test_a_capture_and_a_release_under_loads_are_those_of_an_integration(here, load):
    result = run(here, "a", load, ("capture", {}), ("release", {"time": 0.03}))
    assert list(result["event_kind"][:3]) == [CONTACT, CAPTURE, 3]
    compare(result, follow(blow_under(load), 1.0, [Change(0.0, None, False), Change(0.03, None, False)], COUNT, True))


def test_a_body_of_no_mass_changes_nothing_under_loads(here):
    beside = run(here, "beside", of_body(0.6, mass=0.0), TONE, SHAKEN)
    result = run(here, "a", of_body(0.6, mass=0.0, **{"from": 0.0041}), TONE, SHAKEN)
    for quantity, limit in (("displacement", 1e-12), ("velocity", 1e-9)):  # of a sample in the last of the contact
        np.testing.assert_allclose(result[quantity], beside[quantity], rtol=0, atol=limit * np.abs(beside[quantity]).max())


@pytest.mark.parametrize("groups", [(), (("capture", {}), ("release", {"time": 0.03}))])
def test_a_load_of_nothing_is_none(here, groups):
    groups = (*groups, of_body(0.6, mass=0.3, **{"from": 0.0041}))
    without = run(here, "without", *groups)
    result = run(here, "a", *groups, ("force", PULSE[1] | {"amplitude": 0.0}))
    for quantity, limit in (("displacement", 1e-12), ("velocity", 1e-9)):
        np.testing.assert_allclose(result[quantity], without[quantity], rtol=0, atol=limit * np.abs(without[quantity]).max())


def test_where_nothing_strikes_the_motion_is_that_without_a_contact(here):
    body = of_body(0.6, mass=0.3, **{"from": 0.0041})
    nothing = (("impact", {"mass_ratio": 0.0, "approach_velocity": 1.0}), BLOW[1])
    result = run(here, "a", body, PULSE, SHAKEN, blow=nothing, count=200)
    alone = run(here, "alone", body, PULSE, SHAKEN, blow=(), count=200)
    peak = np.abs(alone["displacement"]).max()
    np.testing.assert_allclose(result["displacement"], alone["displacement"], rtol=0, atol=1e-6 * peak)


def test_a_stiff_contact_that_captures_under_a_load_is_the_capture_at_once(here):
    groups = (("capture", {}), PULSE, ("release", {"time": 0.04}))
    assert goes_to_the_capture_at_once(here, [CONTACT, CAPTURE, 3], *groups)
