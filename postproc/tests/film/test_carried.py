"""What the beam carries in a film: a payload before, on and after the beam, a joint that locks, and the first mode meanwhile."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc.film.carried import carried_in, first_mode, named
from beamwave_postproc.parts.events import Event

MOMENTS = np.array([0.0, 0.01, 0.02, 0.03, 0.05, 0.06])
LENGTH = 2.0


@pytest.fixture
def arm():
    """The tip of an arm moves at 1 m/s; a payload comes at -0.5 m/s after 20 ms and leaves after 50, and the joint locks after 30."""
    time = np.linspace(0.0, 0.1, 101)
    held = {
        "body_position": [1.0, 0.0],
        "body_mass": [0.4, 0.0],
        "body_rotational_stiffness": [0.0, 1e7],
        "body_velocity": [-0.5, np.nan],
        "body_from": [0.02, 0.03],
        "body_until": [0.05, np.nan],
    }
    variables = {name: ("body", values) for name, values in held.items()}
    variables["displacement"] = (("point", "time"), np.outer([0.5, 1.0], time))
    variables["configuration_start"] = ("configuration", [0.0, 0.03])
    variables["configuration_angular_frequency"] = (("configuration", "mode"), [[0.0], [40.0 * np.pi]])
    return xr.Dataset(variables, {"point_position": ("point", [0.5, 1.0]), "time": time}, {"effects": "support body"})


def test_a_payload_flies_to_the_beam_rides_on_it_and_leaves_with_its_velocity(arm):
    carried = carried_in(arm, MOMENTS, LENGTH)
    assert carried.place.tolist() == [LENGTH] and carried.free_place.tolist() == [LENGTH]
    assert carried.there[:, 0].tolist() == [False, False, True, True, False, False]
    np.testing.assert_allclose(carried.free[:, 0], [0.03, 0.025, np.nan, np.nan, 0.05, 0.06], rtol=1e-12)


def test_a_body_that_leaves_a_rotating_beam_is_not_drawn(arm):
    assert carried_in(arm.assign(rotation_angular_velocity=50.0), MOMENTS, LENGTH).free_place.size == 0


def test_a_spring_at_the_joint_locks_it_and_is_no_body(arm):
    assert carried_in(arm, MOMENTS, LENGTH).locked.tolist() == [False, False, False, True, True, True]
    clamped = carried_in(arm.assign_attrs(effects="body"), MOMENTS, LENGTH)
    assert not clamped.locked.any() and clamped.place.tolist() == [0.0, LENGTH]


def test_events_of_bodies_are_named_by_what_comes_and_leaves(arm):
    def words(time, kind):
        event, places = named(arm, Event(time, time, kind, 0.0))
        return event.kind, places

    assert words(0.02, "arrival") == ("body arrives", [1.0])
    assert words(0.03, "arrival") == ("joint locks", [0.0])
    assert words(0.05, "departure") == ("body leaves", [1.0])
    assert words(0.05, "release") == ("release", None)


def test_the_first_mode_is_that_of_the_configuration(arm):
    assert first_mode(arm, MOMENTS) == ["mode 1: rigid body"] * 3 + ["mode 1: 20\u00a0Hz"] * 3
    assert first_mode(arm.isel(configuration=[0]), MOMENTS) == [""] * 6


def test_a_beam_without_bodies_carries_nothing(arm):
    alone = carried_in(arm.drop_vars([name for name in arm if name.startswith("body_")]), MOMENTS, LENGTH)
    assert alone.place.size == alone.free_place.size == 0 and alone.there.shape == alone.free.shape == (6, 0)
