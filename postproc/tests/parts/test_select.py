"""What is drawn can be chosen, by a picture's words or by xarray's own, and what is not there is said."""

import numpy as np
import pytest

from beamwave_postproc import NothingToDraw, dispersion, displacement, open_result
from beamwave_postproc.parts.select import chosen, spread


@pytest.mark.parametrize(
    "wanted, said",
    [
        ({"points": 0.25}, r"no point at 0\.25; it has 0\.5"),
        ({"cases": [1, 9]}, "no case 9; it has 1, 2, 3"),
        ({"modes": 0}, "no mode 0; it has 1, 2"),
        ({"points": []}, "no point is chosen"),
    ],
)
def test_what_is_not_there_is_refused_with_what_there_is(paper_results, wanted, said):
    with open_result(paper_results / "fig6.nc") as ds, pytest.raises(NothingToDraw, match=said):
        chosen(ds, **wanted)


def test_cases_of_a_result_without_a_sweep_are_refused(full_result):
    with open_result(full_result) as ds, pytest.raises(NothingToDraw, match="no dimension case"):
        chosen(ds, cases=1)


def test_points_cases_and_modes_are_drawn_in_the_order_asked_for(full_result, paper_results):
    with open_result(full_result) as ds:
        labels = [axes.get_ylabel() for axes in displacement(ds, [1.0, 0.5]).axes]
        assert "= 1" in labels[0] and "= 0.5" in labels[1]
        modes = chosen(ds, modes=[3, 1])
        assert modes["mode"].values.tolist() == [3, 1] and set(modes["mode_before"].values) == {1, 3}
    with open_result(paper_results / "fig6.nc") as ds:
        axes = displacement(ds, cases=[3, 1]).axes[0]
        assert [line.get_label().split("\u00a0")[2] for line in axes.lines if "omega" in line.get_label()] == [
            "100",
            "0",
        ]


def test_a_selection_by_xarray_is_drawn_as_the_same_selection_by_words(full_result, paper_results):
    with open_result(full_result) as ds:
        by_words, by_xarray = displacement(ds, 1.0).axes[0], displacement(ds.isel(point=1)).axes[0]
        np.testing.assert_array_equal(by_words.lines[0].get_ydata(), by_xarray.lines[0].get_ydata())
        assert by_words.get_ylabel() == by_xarray.get_ylabel()
        assert len(dispersion(ds.sel(mode=2)).axes[0].lines) == len(dispersion(ds, modes=2).axes[0].lines)
    with open_result(paper_results / "fig6.nc") as ds:
        one = displacement(ds.isel(case=1)).axes[0].lines[0]
        np.testing.assert_array_equal(one.get_ydata(), displacement(ds, cases=2).axes[0].lines[0].get_ydata())


def test_a_dimension_that_no_result_has_is_refused(full_result):
    with open_result(full_result) as ds, pytest.raises(NothingToDraw, match="dimension run"):
        displacement(ds.expand_dims(run=2))


def test_spread_holds_both_ends():
    assert spread(3, 8).tolist() == [0, 1, 2] and spread(101, 5).tolist() == [0, 25, 50, 75, 100]
