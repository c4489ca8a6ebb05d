"""Histories: the points asked for, readable units, events at their times."""

import numpy as np
import pytest
import synthetic

from beamwave_postproc import NothingToDraw, displacement, open_result, velocity


def test_one_panel_per_point_and_a_curve_per_case(paper_results, full_result):
    with open_result(full_result) as ds:
        assert len(displacement(ds).axes) == 2
    with open_result(paper_results / "fig6.nc") as ds:
        (axes,) = displacement(ds, position=0.5).axes
        labels = axes.get_legend_handles_labels()[1]
    assert [label.split()[2] for label in labels] == ["0", "50", "100"]


def test_a_point_that_the_result_lacks_is_said(paper_results):
    with open_result(paper_results / "fig6.nc") as ds, pytest.raises(NothingToDraw, match=r"no point at 0\.25"):
        displacement(ds, position=0.25)


def test_the_unit_on_the_axis_is_that_of_the_numbers_drawn(paper_results):
    with open_result(paper_results / "fig6.nc") as ds:
        axes = displacement(ds).axes[0]
        drawn = axes.lines[0]
        assert "(mm)" in axes.get_ylabel() and "(ms)" in axes.get_xlabel()
        # One multiplication by a power of ten: half a unit in the last place.
        np.testing.assert_allclose(drawn.get_ydata(), 1e3 * ds["displacement"].values[0, 0], rtol=1e-15)
        np.testing.assert_allclose(drawn.get_xdata(), 1e3 * ds["time"].values, rtol=1e-15)


def test_compound_units_take_no_prefix(full_result):
    with open_result(full_result) as ds:
        assert r"(m s$^{-1}$)" in velocity(ds).axes[0].get_ylabel()


def test_each_kind_of_event_is_named_once(full_result):
    with open_result(full_result) as ds:
        assert [text.get_text() for text in displacement(ds).axes[0].texts] == ["impact, capture"]
        later = ds.drop_vars(["event", "event_time", "event_kind"]).assign(
            event_time=("event", [0.0, 0.25, 0.5, np.nan]),
            event_kind=("event", [1.0, 4.0, 4.0, np.nan], ds["event_kind"].attrs),
        )
        axes = displacement(later).axes[0]
    marks = [line.get_xdata()[0] for line in axes.lines if len(line.get_xdata()) == 2]
    assert marks == [0.0, 0.25, 0.5]
    assert [text.get_text() for text in axes.texts] == ["impact", "contact"]


def test_words_in_two_rows_stand_above_the_history(full_result):
    with open_result(full_result) as ds:
        crowded = ds.drop_vars(["event", "event_time", "event_kind"]).assign(
            event_time=("event", [0.0, 0.01]), event_kind=("event", [1.0, 4.0], ds["event_kind"].attrs)
        )
        fig = displacement(crowded)
    axes = fig.axes[0]
    fig.canvas.draw()
    lowest = min(word.get_window_extent().y0 for word in axes.texts)
    history = axes.lines[0]
    top = axes.transData.transform(np.column_stack([history.get_xdata(), history.get_ydata()]))[:, 1].max()
    rows = {round(word.get_window_extent().y0) for word in axes.texts}
    assert len(rows) == 2 and top < lowest


def test_a_result_without_events_has_a_history_without_marks(full_result):
    with open_result(full_result) as ds:
        axes = displacement(ds.drop_vars(["event_time", "event_kind"])).axes[0]
    assert len(axes.lines) == 1 and not axes.texts


def test_a_history_of_one_sample_is_drawn(tmp_path):
    settings = synthetic.scene(response={"duration": 1.0, "samples": 1})
    with open_result(synthetic.write(tmp_path / "short.nc", settings)) as ds:
        assert displacement(ds).axes[0].lines[0].get_ydata().tolist() == [0.0]
