"""The film: the beam's line, the way of the mass, the moments that are shown, the GIF."""

from dataclasses import replace
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import synthetic
from PIL import Image

from beamwave_postproc import NothingToDraw, cli, motion, open_result, save_film
from beamwave_postproc.film.frames import Film
from beamwave_postproc.film.frames import limits as film_limits
from beamwave_postproc.film.mass_path import Tip, mass_path
from beamwave_postproc.film.moments import chosen_samples
from beamwave_postproc.parts.events import Event

POINTS = [round(0.05 * i, 2) for i in range(21)]


def struck(path, points, samples=1000):
    settings = synthetic.scene(
        rotation={"angular_velocity": 50.0},
        modes={"before": 6, "after": 6},
        response={"duration": 0.05, "samples": samples, "points": points},
    )
    return synthetic.write(path, settings, title="Struck")


@pytest.fixture(scope="session")
def film_result(tmp_path_factory):
    return struck(tmp_path_factory.mktemp("film") / "film.nc", POINTS)


def with_events(ds, *events, **variables):
    """The result with other events: (time, end, kind, impulse)."""
    names = ("event_time", "event_end", "event_kind", "event_impulse")
    columns = dict(zip(names, np.array(events, dtype=float).T))
    columns = {name: ("event", column, ds["event_kind"].attrs) for name, column in columns.items()}
    return ds.drop_vars(["event", "event_time", "event_end", "event_kind", "event_impulse"]).assign(
        **columns, **variables
    )


IMPACT, CAPTURE, RELEASE, CONTACT = 1.0, 2.0, 3.0, 4.0


def test_the_line_goes_through_the_points_and_the_root(film_result):
    with open_result(film_result) as ds:
        shown = motion(ds)
        after = shown.time >= 0.0
        for point in (5, 13, 20):
            there = np.argmin(np.abs(shown.place - POINTS[point]))
            drawn = np.array([np.interp(POINTS[point], shown.place, line) for line in shown.line[after]])
            held = ds["displacement"].sel(time=shown.time[after]).values[point]
            assert there > 0
            # Straight pieces of 1/200 of the beam, against a curvature of at most that of mode 6: 17² / 8 / 200² .
            np.testing.assert_allclose(drawn, held, atol=2e-3 * np.abs(held).max())
    assert np.all(shown.line[:, 0] == 0.0) and shown.place[0] == 0.0


def test_beam_and_mass_before_at_and_after_a_capture(film_result):
    with open_result(film_result) as ds:
        shown = motion(ds)
    before = shown.time < 0.0
    assert before.sum() == 12 and np.all(shown.line[before] == 0.0) and np.all(np.diff(shown.mass[before]) > 0.0)
    assert not shown.held[before].any() and shown.held[~before].all()
    np.testing.assert_array_equal(shown.mass[~before], shown.deflection[~before, -1])
    assert [event.kind for event in shown.events[12]] == ["impact", "capture"] and not any(shown.events[13:])
    np.testing.assert_allclose(shown.angle, 50.0 * shown.time)


def test_a_motion_that_may_be_nothing_but_error_says_so_in_the_film(film_result):
    with open_result(film_result) as ds:
        doubtful = motion(ds.assign(displacement_error=("point", np.full(21, 1e9))))
        assert motion(ds).warning == ""
    assert doubtful.warning.startswith("Warning: the displacement may be nothing but error")
    (told,) = (text for text in Film(doubtful).canvas.figure.texts if "Warning" in text.get_text())
    assert told.get_color() == "firebrick"


def test_a_rebounding_mass_keeps_its_jacobi_energy_in_the_guide(film_result):
    with open_result(film_result) as ds:
        case = with_events(ds, (0.0, 0.0, IMPACT, 0.1), mass_velocity=-0.3)
        tip = Tip(case["time"].values, case["displacement"].values[-1])
        time = np.linspace(0.0, 0.05, 5001)
        place, held = mass_path(case, tip, time)
    speed = np.gradient(place, time, edge_order=2)
    # Differences over 1e-5 s of a motion with rate 50, one-sided at the ends: (5e-4)²·⅔, of a speed grown by cosh 2.5.
    np.testing.assert_allclose(speed**2 - (50.0 * place) ** 2, 0.09, rtol=1e-5)
    assert place[0] == 0.0 and speed[0] < 0.0 and not held.any()


def test_a_released_mass_leaves_with_the_tip_s_place_and_velocity(film_result):
    with open_result(film_result) as ds:
        case = with_events(ds, (0.0, 0.0, IMPACT, 0.1), (0.0, 0.0, CAPTURE, 0.0), (0.02, 0.02, RELEASE, 0.0))
        tip = Tip(case["time"].values, case["displacement"].values[-1])
        time = case["time"].values
        place, held = mass_path(case, tip, time)
    free = int(np.flatnonzero(~held)[0])
    assert time[free] == pytest.approx(0.02, abs=1e-12)
    np.testing.assert_array_equal(place[:free], tip.displacement[:free])
    step = time[1]
    leaving = (tip.displacement[free] - tip.displacement[free - 2]) / (2.0 * step)
    # Both are differences of first order in a step of which mode 6 sees 0.8 rad.
    assert (place[free + 1] - place[free]) / step == pytest.approx(leaving, rel=0.3)


def test_a_contact_takes_its_impulse_from_the_mass_and_a_lasting_one_holds_it(film_result):
    with open_result(film_result) as ds:
        case = with_events(ds, (0.0, 0.0, IMPACT, 0.1), (0.01, 0.01, CONTACT, 0.2), (0.02, 0.03, CONTACT, 0.0))
        case = case.assign(mass_velocity=0.1, rotation_angular_velocity=0.0)
        tip = Tip(case["time"].values, case["displacement"].values[-1])
        place, held = mass_path(case, tip, np.array([0.005, 0.01, 0.015, 0.025, 0.035]))
    mass = 0.2 * 7870.0 * np.pi / 4.0 * 0.037**2
    assert place[0] == pytest.approx(0.1 * 0.005)
    assert place[2] - place[1] == pytest.approx((0.1 - 0.2 / mass) * 0.005)
    assert held.tolist() == [False, False, False, True, False]


def test_results_with_histories_can_be_filmed(results):
    filmed = 0
    for path in results:
        with open_result(path) as ds:
            if "displacement" not in ds:
                continue
            shown = motion(ds, frames=7)
            images = Film(shown).frames()
            assert next(images).size == next(images).size
            filmed += 1
    assert filmed > 0


def test_all_of_a_short_record_and_the_events_of_a_long_one_are_shown():
    short = np.arange(1000) * 1e-4
    assert np.unique(np.diff(chosen_samples(short, 0.05, [0.0]))).tolist() == [7]
    long = np.arange(100000) * 1e-4
    chosen = chosen_samples(long, 0.05, [0.0, 0.0, 4.0, 4.01, 9.99])
    assert chosen.size <= 160 and np.all(np.diff(chosen) > 0) and chosen[-1] < long.size
    for event in (0.0, 4.0, 4.01, 9.99):
        assert np.min(np.abs(long[chosen] - event)) < 0.05 / 20
    assert np.median(np.diff(long[chosen])) <= 0.05 / 24


def test_the_film_is_a_gif_that_stands_still_at_an_event(film_result, tmp_path):
    with open_result(film_result) as ds:
        save_film(motion(ds, frames=20), tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as film:
        assert (film.format, film.n_frames) == ("GIF", 12 + 20)
        durations = []
        for frame in range(film.n_frames):
            film.seek(frame)
            durations.append(film.info["duration"])
    assert durations == [50] * 12 + [500] + [50] * 19


def test_a_line_through_few_points_is_said_and_filmed(tmp_path, capsys):
    few = struck(tmp_path / "few.nc", [0.5, 0.9], samples=10)
    assert cli.main([str(few), "--animate", "--only", "velocity_jump"]) == 0
    out, err = capsys.readouterr()
    assert str(tmp_path / "few_motion.gif") in out.splitlines() and (tmp_path / "few_motion.gif").exists()
    assert "2 moving points" in err and "points = 0.05" in err and "tip, 1.0, is not among the points" in err


def test_what_cannot_be_filmed_is_said(tmp_path, capsys):
    modes = synthetic.write(tmp_path / "modes.nc", synthetic.scene(impact=None))
    assert cli.main([str(modes), "--animate"]) == 3
    assert "holds no displacement" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.gif"))
    with open_result(struck(tmp_path / "root.nc", [0.0])) as ds, pytest.raises(NothingToDraw, match="root, which is held"):
        motion(ds)


def test_the_first_case_of_a_sweep_is_filmed(paper_results):
    with open_result(paper_results / "fig6.nc") as ds:
        shown = motion(ds, frames=5)
    assert shown.angle is None and "first of 3 cases" in shown.remarks[-1] and any("omega" in part for part in shown.scene)
    assert shown.title == "synthetic"


def test_a_blow_inside_the_beam_has_its_mass_there(film_result):
    with open_result(film_result) as ds:
        inside = ds.assign(impact_position=0.5)
        shown, away = motion(inside, frames=9), motion(ds.assign(impact_position=0.51), frames=9)
    after = shown.time >= 0.0
    assert shown.struck == 0.5
    np.testing.assert_array_equal(shown.mass[after], shown.deflection[after, POINTS.index(0.5) - 1])
    assert away.mass is None and "0.51, is not among the points" in away.remarks[-1]


def test_a_growing_motion_fills_the_picture_all_along(tmp_path):
    settings = synthetic.scene(
        rotation={"angular_velocity": 150.0},
        modes={"before": 6, "after": 6},
        response={"duration": 0.5, "samples": 500, "points": POINTS},
    )
    with open_result(synthetic.write(tmp_path / "grows.nc", settings)) as ds:
        shown = motion(ds, frames=25)
        limits = film_limits(shown)
    assert shown.grows and limits[-1] > 10.0 * limits[0] and np.all(np.diff(limits) >= 0.0)
    assert np.all(np.abs(shown.line).max(axis=1) < limits)


def test_a_full_disk_leaves_no_film(film_result, tmp_path, monkeypatch):
    def fail(self, path, **options):
        Path(path).write_bytes(b"GIF89a")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("PIL.Image.Image.save", fail)
    with open_result(film_result) as ds, pytest.raises(OSError, match="No space"):
        save_film(motion(ds, frames=2), tmp_path / "film.gif")
    assert not (tmp_path / "film.gif").exists()


def test_a_mass_out_of_plane_is_not_driven_outward(tmp_path):
    path = struck(tmp_path / "out.nc", POINTS)
    with netCDF4.Dataset(path, "a") as file:
        file.scene = "&rotation\n angular_velocity = 50.0\n plane = 'out'\n/\n"
    with open_result(path) as ds:
        case = with_events(ds, (0.0, 0.0, IMPACT, 0.1), mass_velocity=-0.3)
        place, _ = mass_path(case, Tip(case["time"].values, case["displacement"].values[-1]), np.array([0.04]))
    assert place[0] == pytest.approx(-0.3 * 0.04)


@pytest.mark.parametrize("speed", [0.0, 50.0, 150.0])
def test_words_and_numbers_beside_the_film_are_inside_it(tmp_path, speed):
    settings = synthetic.scene(
        rotation={"angular_velocity": speed},
        modes={"before": 6, "after": 6},
        response={"duration": 0.5, "samples": 500, "points": POINTS},
    )
    with open_result(synthetic.write(tmp_path / "film.nc", settings)) as ds:
        film = Film(motion(ds, frames=9))
    axes = film.beam.axes
    for frame in range(film.shown.time.size):
        film.image(frame)
        assert axes.get_tightbbox().x0 >= 0.0
        assert max(abs(end) for end in axes.get_ylim()) >= 0.5 or "nm" in axes.get_ylabel()  # in a unit that suits


def test_the_key_names_what_the_film_shows(film_result):
    def words(shown):
        return [text.get_text() for text in Film(shown).canvas.figure.legends[0].get_texts()]

    with open_result(film_result) as ds:
        shown = motion(ds, frames=5)
    shown = replace(shown, mass=np.zeros_like(shown.time))
    assert words(shown) == ["beam", "mass that strikes"]
    carried = replace(shown.carried, place=np.array([0.4]), there=np.ones((shown.time.size, 1), bool), locked=shown.time > 0.0)
    jointed = replace(shown, mass=None, clamped=False, carried=carried)
    assert words(jointed) == ["beam", "joint", "locked joint", "body"]
    assert Film(jointed).beam.joint.get_visible() and not Film(shown).beam.joint.get_visible()
    leaves = replace(shown, mass=np.where(shown.time > 0.0, 10.0 * film_limits(shown), 0.0))
    assert words(leaves) == ["beam", "mass that strikes", "mass beyond the picture"]


def test_word_and_ring_of_a_contact_end_with_it_and_those_of_a_moment_stay_a_while(film_result):
    with open_result(film_result) as ds:
        shown = motion(ds)
    still = [[] for _ in shown.events]
    begin = int(np.flatnonzero(shown.time >= 0.0)[0]) + 5
    step = shown.time[begin + 1] - shown.time[begin]
    for end, last in ((2.5 * step, 2), (0.1 * step, 0), (0.0, 15)):
        event = Event(shown.time[begin], shown.time[begin] + end, "contact", 1.0)
        film = Film(replace(shown, events=[*still[:begin], [event], *still[begin + 1 :]]))
        told = []
        for frame in range(begin, begin + 20):
            film.image(frame)
            told += [frame - begin] if film.beam.words.get_text() == "contact" else []
            assert not film.beam.flash.get_visible() or told[-1:] == [frame - begin]
        assert told == list(range(last + 1))
