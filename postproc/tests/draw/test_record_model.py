"""Lines beside modes, and what was identified from them."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import NothingToDraw, identified, record_model

MODELLED = np.array([20.0, 125.0, np.nan, 350.0])
AWAY = np.array([1e-3, -2e-3, np.nan, 0.0])


@pytest.fixture
def held():
    """Four lines of which the third is no mode."""
    return xr.Dataset(
        {
            "measured_angular_frequency": ("peak", np.nan_to_num(MODELLED * (1 + AWAY), nan=200.0), {"units": "rad s-1"}),
            "measured_angular_frequency_error": ("peak", 1e-3 * np.nan_to_num(MODELLED, nan=200.0)),
            "measured_decay_rate": ("peak", [0.1, 0.2, 0.3, 0.4], {"units": "s-1"}),
            "measured_decay_rate_error": ("peak", [0.01, 0.02, 0.03, 0.04]),
            "modelled_angular_frequency": ("peak", MODELLED, {"units": "rad s-1"}),
            "modelled_decay_rate": ("peak", [0.11, 0.22, np.nan, 0.0]),
            "peak_mode": ("peak", [1, 2, 0, 4]),
            "misfit_probability": ((), 1e-5),
            "misfit_freedom": ((), 3),
            "model_scatter": ((), 0.002),
            "identified": ("unknown", [7e10, 1e4]),
            "identified_error": ("unknown", [1e9, 9e3]),
            "identified_low": ("unknown", [6.9e10, 1e3]),
            "identified_high": ("unknown", [7.1e10, 1e5]),
            "identified_correlation": (("unknown", "unknown_too"), [[1.0, -0.9], [-0.9, 1.0]]),
            "identified_parameter": ("unknown", ["beam%youngs_modulus", "support%stiffness"]),
            "identified_unit": ("unknown", ["Pa", "N m-1"]),
            "identified_first": ("unknown", [6e10, 1e3]),
            "identified_last": ("unknown", [8e10, 1e5]),
        },
        {"peak": [1, 2, 3, 4], "unknown": [1, 2]},
        {"title": "A ring-down", "effects": ""},
    )


def test_lines_that_are_modes_stand_at_their_numbers_in_per_cent(held):
    fig = record_model(held)
    above, below = fig.axes
    marks = above.containers[0].lines[0]
    np.testing.assert_allclose(marks.get_xdata(), [1, 2, 4])
    np.testing.assert_allclose(marks.get_ydata(), [0.1, -0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(below.containers[0].lines[0].get_ydata(), [0.1, 0.2, 0.4])
    assert any("off by 0.2 %" in text.get_text() for text in fig.texts)


def test_each_number_has_an_axis_of_its_own_over_its_range(held):
    modulus, correlation, stiffness = identified(held).axes
    assert modulus.get_xlim() == pytest.approx((60.0, 80.0)) and modulus.get_xscale() == "linear"
    assert stiffness.get_xlim() == pytest.approx((1e3, 1e5)) and stiffness.get_xscale() == "log"
    for axes, (low, high) in ((modulus, (69.0, 71.0)), (stiffness, (1e3, 1e5))):
        (bar,) = axes.containers[0].lines[2][0].get_segments()
        np.testing.assert_allclose(bar[:, 0], [low, high])
    assert [line.get_marker() for line in stiffness.lines if line.get_marker() in "<>"] == ["<", ">"]  # beyond the range
    assert [text.get_text() for text in correlation.texts] == ["−0.90"]


def test_numbers_on_the_correlations_are_read_on_every_colour(held):
    for value in (-1.0, 0.0, 1.0):
        (image,) = identified(held.assign(identified_correlation=held["identified_correlation"] * 0 + value)).axes[1].images
        red, green, blue = image.cmap(image.norm(value))[:3]
        assert 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.35  # bright enough for black letters


def test_a_single_unknown_has_no_correlation(held):
    alone = held.isel(unknown=[0], unknown_too=[0])
    assert len(identified(alone).axes) == 1


def test_numbers_have_the_digits_that_their_intervals_tell(held):
    def titles(ds):
        axes = identified(ds).axes
        return [axes[i].get_title(loc="left").split(":  ")[1] for i in (0, 2)]

    assert titles(held) == ["70.0 (69.0 … 71.0) GPa", "10000 (not fixed within the range) N/m"]
    sharp = held.assign(
        identified=("unknown", [6.98765432e10, 0.5]),
        identified_low=("unknown", [6.98765e10, 0.4]),
        identified_high=("unknown", [6.98767e10, 1e5]),
        identified_first=("unknown", [6e10, 0.1]),
        identified_unit=("unknown", ["Pa", "1"]),
    )
    assert titles(sharp) == ["69.87654 (69.87650 … 69.87670) GPa", "0.5 (at least 0.4)"]


def test_the_head_does_not_tell_where_a_search_began(held):
    scene = held.assign(
        beam_length=((), 0.5, {"units": "m"}), beam_youngs_modulus=((), 6.5e10, {"units": "Pa"}),
        body_mass=("body", [0.3, 0.4], {"units": "kg"}), body_position=("body", [0.5, 1.0], {"units": "1"}),
        identified_parameter=("unknown", ["beam%youngs_modulus", "body(2)%mass"]),
    )  # fmt: skip
    scene.attrs["effects"] = "beam body"
    head = identified(scene).get_label()
    assert "0.5\u00a0m" in head and "0.3\u00a0kg" in head
    assert "GPa" not in head and "0.4\u00a0kg" not in head
    # nor of one piece; what is unknown of a further scene is none of this one
    pieces = scene.assign(
        beam_youngs_modulus=("piece", [6.5e10, 7.1e10], {"units": "Pa"}),
        identified_parameter=("unknown", ["beam%youngs_modulus(1)", "beam%length (other)"]),
    )
    head = identified(pieces).get_label()
    assert "0.5\u00a0m" in head and "–,\u00a071\u00a0GPa" in head


def test_without_a_model_there_is_nothing_to_draw(held):
    with pytest.raises(NothingToDraw):
        record_model(held.drop_vars("modelled_angular_frequency"))
    with pytest.raises(NothingToDraw):
        identified(held.drop_vars("identified"))
