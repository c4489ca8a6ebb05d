"""Histories: the points asked for, readable units, events at their times."""

import numpy as np
import pytest
import synthetic
import xarray as xr
from matplotlib.figure import Figure

from beamwave_postproc import NothingToDraw, bending_moment, displacement, hub_angle, open_result, velocity


def test_one_panel_per_point_and_a_curve_per_case(paper_results, full_result):
    with open_result(full_result) as ds:
        assert len(displacement(ds).axes) == 2
    with open_result(paper_results / "fig6.nc") as ds:
        (axes,) = displacement(ds, 0.5).axes
        labels = axes.get_legend_handles_labels()[1]
    assert [label.replace("\u00a0", " ").split()[2] for label in labels] == ["0", "50", "100"]


def test_a_point_that_the_result_lacks_is_said(paper_results):
    with open_result(paper_results / "fig6.nc") as ds, pytest.raises(NothingToDraw, match=r"no point at 0\.25"):
        displacement(ds, points=0.25)


def test_the_unit_on_the_axis_is_that_of_the_numbers_drawn(paper_results):
    with open_result(paper_results / "fig6.nc") as ds:
        (axes,) = displacement(ds, 0.5).axes
        drawn = axes.lines[0]
        assert "(mm)" in axes.get_ylabel() and "(ms)" in axes.get_xlabel()
        # One multiplication by a power of ten: half a unit in the last place.
        np.testing.assert_allclose(drawn.get_ydata(), 1e3 * ds["displacement"].values[0, 0], rtol=1e-15)
        np.testing.assert_allclose(drawn.get_xdata(), 1e3 * ds["time"].values, rtol=1e-15)


def test_compound_units_take_no_prefix(full_result):
    with open_result(full_result) as ds:
        assert "(m/s)" in velocity(ds).axes[0].get_ylabel()


def test_a_history_of_one_sample_is_drawn(tmp_path):
    settings = synthetic.scene(response={"duration": 1.0, "samples": 1})
    with open_result(synthetic.write(tmp_path / "short.nc", settings)) as ds:
        assert displacement(ds).axes[0].lines[0].get_ydata().tolist() == [0.0]


def test_points_are_rows_and_panels_of_cases_are_columns_of_one_scale(grid_history):
    fig = displacement(grid_history)
    grid = np.array(fig.axes).reshape(2, 2)
    assert [axes.get_title("left") for axes in grid[0]] == ["$\\gamma$\u00a0=\u00a00.1", "$\\gamma$\u00a0=\u00a00.5"]
    assert all(axes.get_ylim() == grid[row, 0].get_ylim() for row in (0, 1) for axes in grid[row])
    prefix = 1e3 if "(mm)" in grid[1, 0].get_ylabel() else 1e6
    last = grid_history["displacement"].values[-1, 1]
    drawn = [line.get_ydata() for line in grid[1, 1].lines if len(line.get_ydata()) > 2]
    np.testing.assert_allclose(drawn[1], prefix * last, rtol=1e-15)


@pytest.fixture
def grid_history(tmp_path):
    """Two mass ratios, two speeds, two points."""
    settings = synthetic.scene(modes={"before": 3, "after": 3}, response={"duration": 0.1, "samples": 64})
    sweep = {"impact_mass_ratio": [0.1, 0.5], "rotation_angular_velocity": [0.0, 50.0]}
    with open_result(synthetic.write(tmp_path / "grid.nc", settings, sweep)) as ds:
        return ds.load()


def test_a_dense_history_is_a_band_and_the_head_says_so(full_result):
    with open_result(full_result) as ds:
        fast = np.sin(2 * np.pi * 3000.0 * ds["time"].values)
        fig = displacement(ds.assign(displacement=ds["displacement"].copy(data=np.stack([fast, fast]))), 1.0)
        lean = displacement(ds, 1.0)
    assert fig.axes[0].collections and not lean.axes[0].collections
    assert any("smallest to largest" in text.get_text() for text in fig.texts)


def touched_by(ds, *contacts):
    """The result with contacts of these begins, ends (s) and impulses (N s) as its events."""
    begin, end, impulse = (("event", list(column)) for column in zip(*contacts))
    kind = ("event", [4.0] * len(contacts), {"flag_values": [4], "flag_meanings": "contact"})
    bare = ds.drop_vars([name for name in ds.variables if name.startswith("event")])
    return bare.assign(event_time=begin, event_end=end, event_impulse=impulse, event_kind=kind)


@pytest.mark.parametrize(
    ("contacts", "end"),
    [
        ([(0.0, 0.004, 1.0), (0.02, 0.04, 1.0)], 1.5 * 0.04),
        ([(0.0, 0.004, 1.0), (0.02, 0.04, 1.0), (0.8, 0.81, 0.1)], 1.5 * 0.04),  # the last one gives less than a tenth
        ([(0.0, 0.004, 1.0), (0.8, 0.81, 1.0)], None),  # contacts all along the record
        ([(0.0, 0.06, 1.0)], None),  # wide enough to be seen
    ],
)
def test_the_part_in_which_a_short_force_acts_stands_enlarged_beside_the_record(full_result, contacts, end):
    with open_result(full_result) as ds:
        struck = touched_by(ds.load(), *contacts)
    fig = displacement(struck, 1.0)
    whole, *near = fig.axes
    assert len(near) == (end is not None)
    assert ("right, enlarged: the first 60" in words(fig)) == (end is not None)
    if near:
        assert near[0].get_xlim() == pytest.approx((0.0, 1e3 * end), rel=2e-3)  # to within a sample, in ms
        line = near[0].lines[0]
        np.testing.assert_array_equal(line.get_ydata(), whole.lines[0].get_ydata()[: line.get_ydata().size])
    alone = displacement(struck, 1.0, ax=Figure().subplots())
    assert len(alone.axes) == 1  # the caller's


def test_a_short_load_is_enlarged_where_it_begins(full_result):
    load = {"force_start": ("force", [0.3]), "force_duration": ("force", [0.01]), "applied_impulse": ("force", [1.0])}
    with open_result(full_result) as ds:
        _, near = displacement(touched_by(ds.load()[["displacement", "time"]], (np.nan,) * 3).assign(load), 1.0).axes
    assert near.get_xlim() == pytest.approx((300.0, 315.0), rel=1e-3)


def test_the_worst_point_is_named_with_its_error(full_result):
    with open_result(full_result) as ds:
        peaks = np.abs(ds["displacement"]).max("time").values
        told = displacement(ds.assign(displacement_error=("point", peaks * [0.013, 2e-7])))
        alone = displacement(ds.assign(displacement_error=("point", peaks * [0.013, 2e-7])), 1.0)
    notes = " ".join(text.get_text() for text in told.texts)
    assert "estimated error 1.3 % of the peak at ξ = 0.5, the largest here" in notes
    notes = " ".join(text.get_text() for text in alone.texts)
    assert "2e-7 of the peak at ξ = 1" in notes and "largest" not in notes


def test_the_bound_of_the_error_stands_beside_it_and_is_rounded_up(full_result):
    with open_result(full_result) as ds:
        peaks = np.abs(ds["displacement"]).max("time").values
        errors, bounds = ("point", peaks * [0.013, 2e-7]), ("point", peaks * [0.0412, 3.01e-6])
        told = displacement(ds.assign(displacement_error=errors, displacement_bound=bounds))
        alone = displacement(ds.assign(displacement_error=errors, displacement_bound=bounds), 1.0)
    notes = " ".join(text.get_text() for text in told.texts).replace("\n", " ")
    assert "estimated error 1.3 % of the peak at ξ = 0.5, surely below 4.2 %, the largest here" in notes
    notes = " ".join(text.get_text() for text in alone.texts).replace("\n", " ")
    assert "2e-7 of the peak at ξ = 1, surely below 3.1e-6" in notes


def test_a_history_that_may_be_nothing_but_error_carries_a_warning(full_result):
    with open_result(full_result) as ds:
        peaks = np.abs(ds["displacement"]).max("time").values
        doubtful = displacement(ds.assign(displacement_error=("point", peaks * [0.5, 1.3])))
        near = displacement(ds.assign(displacement_error=("point", peaks * [0.5, 0.99])))
    warning = doubtful.texts[1].get_text().replace("\n", " ")
    told = "Warning: the displacement may be nothing but error, which is estimated at 130 % of its peak at ξ = 1"
    assert warning == told
    assert not any("estimated error" in text.get_text() or "Warning" in text.get_text() for text in doubtful.texts[2:])
    assert not any("Warning" in text.get_text() for text in near.texts)


def test_points_at_which_nothing_is_given_are_named_and_take_no_panel(five_points):
    given = five_points["displacement"].where(five_points["point_position"] != 0.25)
    fig = displacement(five_points.assign(displacement=given))
    assert len(fig.axes) == 3
    notes = " ".join(text.get_text() for text in fig.texts).replace("\n", " ")
    assert "zero throughout at ξ = 0" in notes and "not given, as the notes say, at ξ = 0.25" in notes


def test_the_turn_of_a_hub_belongs_to_no_point(five_points):
    turn = xr.DataArray(1e-4 * np.sin(five_points["time"].values), dims="time", attrs={"units": "rad"})
    fig = hub_angle(five_points.assign(hub_angle=turn))
    (axes,) = fig.axes
    assert "(µrad)" in axes.get_ylabel() and "xi" not in axes.get_ylabel()
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 1e6 * turn.values, rtol=1e-15)
    with pytest.raises(NothingToDraw):
        hub_angle(five_points)


@pytest.fixture
def five_points(tmp_path):
    """A history at five points from the root, which rests, to the tip, whose bending moment is zero."""
    points = [0.0, 0.25, 0.5, 0.75, 1.0]
    settings = synthetic.scene(response={"duration": 0.1, "samples": 64, "points": points, "bending_moment": True})
    with open_result(synthetic.write(tmp_path / "five.nc", settings)) as ds:
        moment = ds["bending_moment"].where(ds["point_position"] < 1.0, 0.0)
        return ds.load().assign(bending_moment=moment, displacement=ds["displacement"].where(ds["point"] > 0, 0.0))


def words(fig):
    return " ".join(text.get_text() for text in fig.texts).replace("\n", " ")


def test_points_that_rest_throughout_are_named_in_the_head_and_take_no_panel(five_points):
    fig = displacement(five_points)
    assert len(fig.axes) == 4 and "zero throughout at ξ = 0" in words(fig)
    fig = bending_moment(five_points)
    assert len(fig.axes) == 4 and "zero throughout at ξ = 1" in words(fig)
    assert all(axes.child_axes for axes in fig.axes)
    chosen = bending_moment(five_points, points=[0.5, 1.0])  # what is asked for is drawn
    assert len(chosen.axes) == 2 and chosen.axes[1].get_yticks().tolist() == [0.0]
    assert not chosen.axes[1].child_axes  # no axis of a stress that is nothing but zero


def test_all_panels_have_one_unit_unless_numbers_become_too_small(five_points):
    def units(fig):
        return [axes.get_ylabel().rsplit("(")[-1] for axes in fig.axes]

    size = xr.DataArray([1.0, 3e-2, 1.0, 0.2, 1e-5], dims="point") / np.abs(five_points["displacement"]).max("time")
    scaled = five_points.assign(displacement=five_points["displacement"] * size.where(np.isfinite(size), 0.0))
    assert units(displacement(scaled)) == ["m)", "m)", "m)", "µm)"]
    assert len(set(units(bending_moment(five_points)))) == 1


def test_labels_stay_beside_their_panels(five_points):
    fig = bending_moment(five_points)
    fig.draw_without_rendering()
    for axes in fig.axes:
        for label in (axes.yaxis.label, axes.child_axes[0].yaxis.label):
            assert label.get_window_extent().height < 1.1 * axes.bbox.height
