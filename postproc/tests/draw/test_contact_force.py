"""Contacts that last: their forces, and the mass that they move."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from beamwave_postproc import NothingToDraw, contact_force, open_result
from beamwave_postproc.film.motion import motion
from beamwave_postproc.parts.contacts import mass_at_beam, mass_in_contact, struck_mass
from beamwave_postproc.parts.sheet import of_size

BEGIN, END, PEAK = 0.2, 0.3, 5.0  # s, s, N: half a sine, of the impulse 2 PEAK (END − BEGIN)/π
SAMPLES = 128


@pytest.fixture
def touched(full_result):
    """A result of which the mass is free but for one contact, whose force is half a sine; room for a second one."""
    parts = 0.5 * (1.0 - np.cos(np.pi * np.arange(SAMPLES) / (SAMPLES - 1)))
    force = np.full((2, SAMPLES), np.nan)
    force[0] = PEAK * np.sin(np.pi * parts)
    columns = {
        "event_time": ("event", [BEGIN, np.nan], {"units": "s"}),
        "event_end": ("event", [END, np.nan], {"units": "s"}),
        "event_kind": ("event", [4.0, np.nan], {"flag_values": [4], "flag_meanings": "contact"}),
        "event_impulse": ("event", [2.0 * PEAK * (END - BEGIN) / np.pi, np.nan], {"units": "N s"}),
    }
    with open_result(full_result) as ds:
        bare = ds.drop_vars([name for name in ds.variables if name.startswith("event")]).load()
    still = bare.assign(rotation_angular_velocity=((), 0.0, {"units": "rad s-1"}))
    return still.assign({**columns, "contact_force": (("event", "contact_sample"), force, {"units": "N"})})


def test_the_mass_is_slowed_by_the_impulse_over_its_mass(touched):
    speed, impulse = float(touched["impact_approach_velocity"]), 2.0 * PEAK * (END - BEGIN) / np.pi
    before, after = np.array([0.1, 0.2]), np.array([0.4, 0.5])
    np.testing.assert_allclose(mass_in_contact(touched, before), speed * before, rtol=1e-12)
    late = speed - impulse / struck_mass(touched)
    # The sine is symmetric: the mass moves as if its whole impulse came in the middle. 127 intervals err by their squares.
    middle = 0.5 * (BEGIN + END)
    np.testing.assert_allclose(mass_in_contact(touched, after), speed * middle + late * (after - middle), rtol=1e-3)


def test_force_and_way_of_the_mass_are_drawn(touched):
    force, motion_of_both = contact_force(touched).axes
    line = force.lines[0]
    assert line.get_xdata()[-1] == pytest.approx(100.0) and line.get_ydata().max() == pytest.approx(PEAK, rel=1e-3)  # ms, N
    assert {line.get_label() for line in motion_of_both.lines} >= {"mass", "beam at the struck place"}
    (alone,) = contact_force(touched.isel(point=[0])).axes  # no history where the mass strikes
    assert alone.get_ylabel() == "Contact force (N)"


def test_many_contacts_lie_on_one_axes_in_the_colours_of_their_order_and_the_hardest_are_named(touched):
    count = 50
    begin = 0.01 * np.arange(count)
    peaks = np.where(np.arange(count) % 10 == 3, 1.0 + 0.01 * np.arange(count), 0.1)  # 4, 14, 24, 34 and 44 are hard
    half_sine = np.sin(np.pi * 0.5 * (1.0 - np.cos(np.pi * np.arange(SAMPLES) / (SAMPLES - 1))))
    columns = {
        "event_time": ("event", begin),
        "event_end": ("event", begin + 0.005),
        "event_kind": ("event", np.full(count, 4.0), touched["event_kind"].attrs),
        "contact_force": (("event", "contact_sample"), peaks[:, None] * half_sine),
    }
    many = touched.drop_dims(["event"]).isel(point=[0]).assign(columns)
    together, bar = contact_force(many).axes
    assert len(together.lines) == count and bar.get_ylabel() == "Contact"
    named = [line for line in together.lines if not line.get_label().startswith("_")]
    assert [line.get_label().split(",")[0] for line in named] == [f"contact {number}" for number in (44, 34, 24, 14)]
    # Darker is earlier, in grey, too: the lines lie from the hardest to the softest, contacts of one force in their order.
    light = [to_rgb(line.get_color()) @ np.array([0.2126, 0.7152, 0.0722]) for line in together.lines[5:]]
    assert np.all(np.diff(light) >= 0.0) and light[-1] - light[0] > 0.5


def test_two_contacts_share_axes_where_there_is_room_for_one(touched):
    force = touched["contact_force"].copy()
    force[1] = 3.0 * force[0].values
    times = {"event_time": ("event", [BEGIN, 0.4]), "event_end": ("event", [END, 0.41])}
    two = touched.assign(**times, event_kind=("event", [4.0, 4.0], touched["event_kind"].attrs), contact_force=force)
    with of_size((85 / 25.4, 120 / 25.4)):
        fig = contact_force(two)
    assert [line.get_ydata().max() for line in fig.axes[0].lines] == pytest.approx([3.0 * PEAK, PEAK], rel=1e-3)
    assert any("2 contacts, named those of the largest force" in text.get_text() for text in fig.texts)


def test_a_beam_on_a_hub_that_turns_is_where_the_mass_meets_it(touched):
    turn = 1e-3 * touched["time"].values  # rad
    turned = touched.assign(hub_radius=((), 0.5), hub_angle=("time", turn))
    (_, ours), (_, held) = contact_force(turned).axes, contact_force(touched).axes
    assert ours.get_ylabel() == held.get_ylabel() == "Position (mm)"
    moved = ours.lines[1].get_ydata() - held.lines[1].get_ydata()
    arm = 0.5 + float(touched["beam_length"])  # of the tip
    np.testing.assert_allclose(moved, 1e3 * arm * turn[: moved.size], rtol=1e-9, atol=1e-12)
    film, fixed = motion(turned, frames=40), motion(touched, frames=40)  # which has the beam at rest
    np.testing.assert_allclose(film.mass - fixed.mass, -arm * 1e-3 * np.maximum(film.time, 0.0), rtol=1e-9, atol=1e-12)


def test_a_mass_beside_a_beam_that_is_let_go_starts_on_it(touched):
    bent = touched.assign(displacement=touched["displacement"] + 0.036)
    (_, ours), (_, straight) = contact_force(bent).axes, contact_force(touched).axes
    assert ours.lines[0].get_ydata()[0] == pytest.approx(ours.lines[1].get_ydata()[0])
    film, still = motion(bent, frames=40), motion(touched, frames=40)
    first = bent["displacement"].isel(point=1).values[0] - touched["displacement"].isel(point=1).values[0]
    np.testing.assert_allclose(film.mass - still.mass, first, rtol=1e-9)
    assert straight.lines[0].get_ydata()[0] == pytest.approx(straight.lines[1].get_ydata()[0])


def test_a_mass_that_a_base_moves_is_not_drawn(touched):
    shaken = touched.assign(applied_acceleration=("base", [50.0], {"units": "m s-2"}))
    (alone,) = contact_force(shaken).axes
    assert alone.get_ylabel() == "Contact force (N)"
    assert np.isnan(motion(shaken, frames=40).mass).all()


def test_contacts_have_the_numbers_of_their_events(touched):
    force = touched["contact_force"].copy()
    force[1] = force[0].values
    at_once = {"event_time": ("event", [BEGIN, END]), "event_end": ("event", [BEGIN, 0.4])}  # over as soon as it began
    two = touched.assign(**at_once, event_kind=("event", [4.0, 4.0], touched["event_kind"].attrs), contact_force=force)
    assert contact_force(two).axes[0].get_title(loc="left").startswith("contact 2")


def test_a_captured_mass_goes_on_with_the_beam_and_keeps_its_indentation(touched):
    kinds = {"event_kind": ("event", [4.0, 2.0], {"flag_values": [2, 4], "flag_meanings": "capture contact"})}
    times = {"event_time": ("event", [BEGIN, END], {"units": "s"})}
    held = touched.assign({**kinds, **times, "event_end": ("event", [END, END], {"units": "s"})})
    at = np.array([END - 1e-9, 0.5, 0.9])
    beam = np.interp(at, held["time"], held["displacement"].isel(point=1))
    mass = mass_at_beam(held, at, beam)
    # Between the two first moments the mass moves by less than 1e-8 m.
    np.testing.assert_allclose(mass[1:] - beam[1:], mass[0] - beam[0], atol=1e-7)


def test_the_film_has_the_mass_where_the_forces_put_it(touched):
    shown = motion(touched, frames=40)
    np.testing.assert_allclose(shown.mass, mass_in_contact(touched, shown.time))
    assert not shown.held.any()


def test_without_a_contact_that_lasts_there_is_nothing_to_draw(full_result, touched):
    with open_result(full_result) as ds, pytest.raises(NothingToDraw, match="contact_force"):
        contact_force(ds)
    with pytest.raises(NothingToDraw, match="no contact force"):
        contact_force(touched.assign(contact_force=np.nan * touched["contact_force"]))


@pytest.mark.parametrize(("exponents", "unit"), [(1.0, "N m-1"), (1.5, "N m-1.5"), ([1.0, 1.5], "N")])
def test_the_stiffness_of_a_contact_is_in_newtons_over_metres_to_its_exponent(touched, tmp_path, exponents, unit):
    dims = "case" if np.ndim(exponents) else ()
    touched.assign(
        contact_stiffness=((), 1e8, {"units": "N"}), contact_exponent=(dims, exponents, {"units": "1"})
    ).to_netcdf(tmp_path / "a.nc")
    with open_result(tmp_path / "a.nc") as ds:
        assert ds["contact_stiffness"].attrs["units"] == unit
