"""The table of `beamwave effects` as a picture: its words, its frames, what is left out."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.patches import Rectangle

from beamwave_postproc import NothingToDraw, changes
from beamwave_postproc.draw.effect_table import percent

NAN = float("nan")


@pytest.fixture
def study():
    """Three effects, two modes: one matters from mode 2 on, one is impossible, one has a mode 1 without frequency."""
    flags = {"flag_values": [1, 2, 3], "flag_meanings": "rotation shear recontact"}
    states = {"flag_values": [1, 2, 3], "flag_meanings": "off on not_combined"}
    return xr.Dataset(
        {
            "effect_state": ("effect", [2, 1, 3], states),
            "matters_from_mode": ("effect", [1, 2, 0]),
            "frequency_tolerance": ((), 1e-3),
            "frequency_change": (("effect", "mode"), [[NAN, -1e-9, NAN], [-5e-4, -0.12, NAN], [NAN, NAN, NAN]]),
            "angular_frequency_without": (("effect", "mode"), [[1.0, 9.0, NAN], [1.0, 9.0, NAN], [NAN, NAN, NAN]]),
            "response_change": ("effect", [0.75, 0.031, NAN]),
            "cost": ("effect", [1.04, 171.3, NAN]),
        },
        {"effect": ("effect", [1, 2, 3], flags), "mode": [1, 2, 3]},
    )


def test_rows_are_the_effects_that_were_compared_and_cells_their_changes(study):
    (axes,) = changes(study).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["rotation (on)", "shear (off)"]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["1", "2", "response", "run time"]
    cells = [text.get_text() for text in axes.texts]
    assert cells == ["–", "−1·10$^{-7}$%", "−0.05%", "−12%", "75%", "× 1", "3.1%", "× 170"]


def test_the_first_mode_that_an_effect_matters_for_is_framed(study):
    (axes,) = changes(study).axes
    frames = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    middles = [(frame.get_x() + frame.get_width() / 2, frame.get_y() + frame.get_height() / 2) for frame in frames]
    np.testing.assert_allclose(middles, [(0, 0), (1, 1)], atol=1e-12)


def test_a_study_without_anything_compared_is_not_drawn(study):
    with pytest.raises(NothingToDraw, match="no effect"):
        changes(study.isel(effect=[2]))
    with pytest.raises(NothingToDraw, match="frequency_change"):
        changes(study.drop_vars("frequency_change"))


def test_changes_are_written_with_two_digits_and_a_sign():
    assert [percent(value) for value in (0.1234, -0.2, -3e-16, 1.5, NAN)] == ["+12%", "−20%", "0", "+150%", "–"]
