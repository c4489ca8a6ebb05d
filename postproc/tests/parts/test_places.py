"""Bodies, the struck place and beams by pieces: marked where a result has them, and no picture fails on them."""

import numpy as np
import pytest
import synthetic

from beamwave_postproc import compare, mode_shapes, motion, open_result, page_of, pictures, space_time, velocity_jump
from beamwave_postproc.film.frames import Film
from beamwave_postproc.parts.places import bodies_there, body_places, struck_inside

POINTS = [round(0.05 * i, 2) for i in range(21)]
BODIES = {
    "body_position": ("body", [0.75, 0.4, 0.4], {"units": "1"}),
    "body_mass": ("body", [0.2, np.nan, 0.1], {"units": "kg"}),
    "body_mass_ratio": ("body", [np.nan, 0.05, np.nan], {"units": "1"}),
}


@pytest.fixture(scope="module")
def struck(tmp_path_factory):
    """A beam at 21 points with all that can be asked for."""
    settings = synthetic.scene(
        rotation={"angular_velocity": 20.0},
        modes={"before": 8, "after": 8},
        response={"duration": 0.2, "samples": 1024, "points": POINTS, "velocity": True, "bending_moment": True},
        spectrum={"max_peaks": 4},
    )
    with open_result(synthetic.write(tmp_path_factory.mktemp("places") / "struck.nc", settings)) as ds:
        return ds.load()


@pytest.fixture(scope="module")
def laden(struck):
    """Two pieces, three bodies at two places, struck inside: as the program names and shapes them."""
    pieces = {
        "beam_length": ("piece", [0.7, 0.3], {"units": "m"}),
        "beam_diameter": ("piece", [0.037, 0.03], {"units": "m"}),
    }
    other = struck.assign({**pieces, **BODIES, "impact_position": ((), 0.6, {"units": "1"})})
    other = other.assign(angular_frequency=0.9 * other["angular_frequency"])
    return other.assign_attrs(effects=f"body {struck.attrs['effects']}")


def marks(axes):
    """Labelled lines across the axes: label and place."""
    found = {}
    for line in axes.lines:
        if line.get_label() in ("body", "bodies", "struck place"):
            found.setdefault(line.get_label(), []).append(
                float(line.get_xdata()[0] if line.get_xdata()[0] == line.get_xdata()[1] else line.get_ydata()[0])
            )
    return found


def test_places_are_those_of_the_file(laden, struck):
    assert body_places(laden).tolist() == [0.4, 0.75] and struck_inside(laden) == 0.6
    assert body_places(struck).size == 0 and struck_inside(struck) is None
    assert struck_inside(laden.assign(impact_position=1.0)) is None
    assert struck_inside(laden.assign(impact_position=("case", [0.5, 0.6]))) is None
    assert struck_inside(laden.assign(impact_position=("case", [0.5, 0.5]))) == 0.5


def test_pictures_along_the_beam_mark_bodies_and_the_struck_place(laden, struck):
    expected = {"bodies": [0.4, 0.75], "struck place": [0.6]}
    for picture in (mode_shapes, velocity_jump, space_time):
        fig = picture(laden)
        assert marks(fig.axes[0]) == expected
        assert {"bodies", "struck place"} <= {text.get_text() for text in fig.legends[0].get_texts()}
        assert not marks(picture(struck).axes[0])
    assert marks(mode_shapes(laden.isel(body=[0])).axes[0])["body"] == [0.75]


def test_the_film_carries_bodies_on_the_beam(laden):
    shown = motion(laden, frames=12)
    assert shown.carried.place.tolist() == [0.4, 0.75] and shown.struck == pytest.approx(0.6)
    film = Film(shown)
    last = shown.time.size - 1
    film.image(last)
    x, y = film.beam.bodies.get_data()
    assert x.tolist() == [0.4, 0.75]
    drawn = np.interp(x, film.beam.line.get_xdata(), film.beam.line.get_ydata())
    np.testing.assert_allclose(y, drawn, rtol=1e-12)
    assert len(film.hub.bodies.get_xdata()) == 2


def test_no_picture_fails_on_inputs_that_are_arrays(laden, struck):
    drawn = pictures(laden)
    assert set(drawn) == set(pictures(struck))
    for fig in drawn.values():
        words = fig.get_label().replace("\u00a0", " ")
        assert "body ξ = 0.75, mass = 0.2 kg; body ξ = 0.4, mass ratio = 0.05" in words
        assert "ξ₀ = 0.6" in words and "beam l = 0.7, 0.3 m" in words
    assert "body in A alone" in page_words(compare(laden, struck)["frequencies"])
    assert "<h2>Report</h2>" in page_of(laden, {})


def page_words(fig):
    return " ".join(text.get_text() for text in fig.texts).replace("\n", " ")


def test_bodies_are_there_from_when_they_come_until_they_leave(laden):
    times = {"body_from": ("body", [0.1, np.nan, 0.2]), "body_until": ("body", [0.3, 0.15, np.nan])}
    there = bodies_there(laden.assign(times), np.array([0.0, 0.1, 0.17, 0.2, 0.3]))
    assert body_places(laden).tolist() == [0.4, 0.75]
    assert there.T.tolist() == [[True, True, False, True, True], [False, True, True, True, False]]
    assert bodies_there(laden, np.zeros(2)).all()


def test_a_beam_that_nothing_strikes_is_filmed_with_its_bodies(laden):
    kinds = laden["event_kind"].copy(data=[5, 6])
    alone = laden.drop_vars([name for name in laden if name.startswith("impact_")])
    shown = motion(alone.assign(event_kind=kinds, body_from=("body", [0.1, np.nan, 0.0])))
    assert shown.mass is None and not shown.carried.there[0, 1] and shown.carried.there[-1].all()


def test_bodies_that_come_later_are_no_part_of_the_modes_at_first(laden):
    later = laden.assign(body_from=("body", [0.1, np.nan, 0.2]))
    for draw in (mode_shapes, velocity_jump):
        assert marks(draw(later).axes[0])["body"] == [0.4] and "bodies" in marks(draw(laden).axes[0])
