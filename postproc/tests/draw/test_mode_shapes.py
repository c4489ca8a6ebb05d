"""Mode shapes: each on its own line, with its frequency."""

import numpy as np
import pytest

from beamwave_postproc import NothingToDraw, mode_shapes, open_result
from beamwave_postproc.draw.mode_shapes import HALF
from beamwave_postproc.parts.units import with_unit


def shapes_drawn(axes):
    return [line for line in axes.lines if len(line.get_xdata()) > 2]


def test_each_shape_stands_on_its_own_line_at_one_size(full_result):
    with open_result(full_result) as ds:
        (axes,) = mode_shapes(ds).axes
        expected = ds["mode_shape"].values
    drawn = shapes_drawn(axes)
    assert len(drawn) == 6
    for row, line in enumerate(drawn):
        sign = -1.0 if row == 0 else np.sign(expected[row][20])  # the first has the tip below, by (−1)^k
        shape = sign * expected[row] / np.abs(expected[row]).max()
        np.testing.assert_allclose(line.get_ydata(), row + HALF * shape, atol=1e-15 * 6)
        assert shape[np.flatnonzero(np.abs(shape) > 0.1)[0]] > 0.0  # every mode rises from the root


def test_the_head_says_how_many_modes_are_left_out(full_result):
    with open_result(full_result) as ds:
        assert any("6 of 40 modes in the file" in text.get_text() for text in mode_shapes(ds).texts)
        assert not any("modes in the file" in text.get_text() for text in mode_shapes(ds, modes=[1, 7]).texts)


def test_shapes_that_are_the_same_in_all_cases_are_drawn_once_without_a_frequency(paper_results):
    with open_result(paper_results / "fig2.nc") as ds:
        fig = mode_shapes(ds)
    assert len(shapes_drawn(fig.axes[0])) == 6 and not fig.legends
    assert any("the same for all ω" in text.get_text() for text in fig.texts)
    assert fig.axes[0].get_yticklabels()[0].get_text() == "mode 1"


def test_modes_are_called_by_number_and_frequency(full_result):
    with open_result(full_result) as ds:
        (axes,) = mode_shapes(ds, modes=[2, 5]).axes
        hertz = ds["angular_frequency"].sel(mode=[2, 5]).values / (2 * np.pi)
        unstable = ds.assign(
            angular_frequency=ds["angular_frequency"].where(ds["mode"] > 1), growth_rate=0.0 * ds["growth_rate"] + 1.0
        )
        grown = mode_shapes(unstable, modes=1).axes[0].get_yticklabels()[0].get_text()
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == [f"mode {mode}\n{with_unit(value, 'Hz')}" for mode, value in zip((2, 5), hertz)]
    assert grown == "mode 1\ngrows"


def test_a_shape_with_too_few_samples_is_drawn_as_samples(full_result):
    with open_result(full_result) as ds:
        fig = mode_shapes(ds.isel(profile=slice(None, None, 10)), modes=[1, 20])
    smooth, coarse = shapes_drawn(fig.axes[0])
    assert smooth.get_linestyle() != "None" and coarse.get_linestyle() == "None"
    assert any("21 samples do not show modes 20" in text.get_text() for text in fig.texts)


def test_cases_share_the_axes_of_each_mode_and_what_is_one_line_is_drawn_once(paper_results):
    with open_result(paper_results / "fig7.nc") as ds:
        fig = mode_shapes(ds, modes=[1, 2])
        shapes = ds["mode_shape"].sel(mode=1).values
    first, second = fig.axes
    scaled = shapes / np.abs(shapes).max(axis=1, keepdims=True)
    assert np.ptp(np.abs(scaled), axis=0).max() < 0.02 and "all alike" in first.get_title(loc="left")
    assert len(shapes_drawn(first)) == 1 and len(shapes_drawn(second)) == 4
    assert len(fig.legends[0].get_texts()) == 4


def test_a_turn_of_the_whole_that_leaves_rounding_is_a_straight_line(full_result):
    with open_result(full_result) as ds:
        shapes = ds["mode_shape"].values.copy()
        shapes[0] = 1e-15 * np.sign(shapes[1])
        (axes,) = mode_shapes(ds.assign(mode_shape=ds["mode_shape"].copy(data=shapes))).axes
    assert not shapes_drawn(axes)[0].get_ydata().any()


def test_without_shapes_there_is_nothing_to_draw(full_result):
    with open_result(full_result) as ds, pytest.raises(NothingToDraw, match="mode_shape"):
        mode_shapes(ds.drop_vars("mode_shape"))
