"""The Campbell diagram: closed-form frequencies over the speed, crossings, growth and the critical speed."""

import numpy as np
import pytest
import synthetic
import xarray as xr
from matplotlib.patches import Polygon

from beamwave_postproc import NothingToDraw, campbell, crossings, open_result
from beamwave_postproc.parts.sheet import of_size

RPM = 30.0 / np.pi
SPEEDS = [float(speed) for speed in range(0, 201, 20)]


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """Three modes from rest to beyond the critical speed of the first, 121.8 rad/s."""
    settings = synthetic.scene(modes={"before": 3, "after": 3})
    path = tmp_path_factory.mktemp("campbell") / "sweep.nc"
    with open_result(synthetic.write(path, settings, {"rotation_angular_velocity": SPEEDS})) as ds:
        return ds.load()


def curves(axes):
    """The smooth curves of the modes by their labels."""
    return {line.get_label(): line for line in axes.lines if line.get_label().startswith("mode")}


def test_between_the_cases_the_curves_follow_the_closed_form(sweep):
    assert list(curves(campbell(sweep).axes[0])) == ["mode 1", "mode 2"]  # 8P meets the second and not the third
    drawn = curves(campbell(sweep, modes=[1, 2, 3]).axes[0])
    assert list(drawn) == ["mode 1", "mode 2", "mode 3"]
    elastic = sweep["angular_frequency"].isel(case=0).values  # at rest: h P²
    for line, rest in zip(drawn.values(), elastic):
        speed, shown = line.get_xdata() / RPM, line.get_ydata()
        square = rest**2 - speed**2
        clear = square > 1e-3 * rest**2  # the root of a difference keeps few digits near 0
        np.testing.assert_allclose(shown[clear], np.sqrt(square[clear]) / (2 * np.pi), rtol=1e-10)
        assert np.isnan(shown[square < -1e-3 * rest**2]).all()


def test_cases_are_marked_where_they_are_few(sweep):
    (axes,) = campbell(sweep, modes=2).axes
    (marks,) = (line for line in axes.lines if line.get_marker() == "o")
    np.testing.assert_allclose(marks.get_xdata(), RPM * np.array(SPEEDS))
    np.testing.assert_allclose(marks.get_ydata(), sweep["angular_frequency"].sel(mode=2) / (2 * np.pi), rtol=1e-12)


def test_growth_is_shaded_from_the_critical_speed_on_and_named_at_the_foot(sweep):
    fig = campbell(sweep)
    (axes,) = fig.axes
    limit = float(sweep["critical_angular_velocity"][0])
    (span,) = axes.patches
    places = span.get_xy()[:, 0] if isinstance(span, Polygon) else (span.get_x(), span.get_x() + span.get_width())
    assert (min(places), max(places)) == pytest.approx((RPM * limit, RPM * 200.0))
    assert f"critical speed {RPM * limit:.0f} rpm (121.8 rad/s)" in axes.get_title("left")
    foot = next(line for line in axes.lines if line.get_linewidth() == 4.0)
    held = np.isfinite(foot.get_ydata())
    np.testing.assert_array_equal(held, np.array(SPEEDS) > limit)
    assert foot.get_color() == curves(axes)["mode 1"].get_color()
    assert any("grows" in text.get_text() for text in fig.legends[0].get_texts())


def test_modes_are_followed_through_a_crossing():
    speed = np.linspace(0.0, 100.0, 21)
    squares = np.stack([2e4 - 0.9 * speed**2, 1.3e4 + 0.5 * speed**2], axis=1)
    ds = xr.Dataset(
        {"angular_frequency": (("case", "mode"), np.sqrt(np.sort(squares, axis=1)))},
        {"case": np.arange(1, 22), "mode": [1, 2], "rotation_angular_velocity": ("case", speed)},
    )
    first, second = curves(campbell(ds).axes[0]).values()
    np.testing.assert_allclose(first.get_ydata(), np.sqrt(1.3e4 + 0.5 * (first.get_xdata() / RPM) ** 2) / (2 * np.pi))
    np.testing.assert_allclose(second.get_ydata(), np.sqrt(2e4 - 0.9 * (second.get_xdata() / RPM) ** 2) / (2 * np.pi))


def test_multiples_of_the_speed_are_lines_with_names(sweep):
    (axes,) = campbell(sweep).axes
    names = {text.get_text() for text in axes.texts}
    lines = [line for line in axes.lines if line.get_linestyle() == ":"]
    assert "1P" in names and len(names) == len(lines)
    for line in lines:
        order = line.get_ydata()[-1] / (line.get_xdata()[-1] / 60.0)
        assert f"{order:.0f}P" in names and order == pytest.approx(round(order))


def test_a_second_input_makes_panels(grid_result):
    with open_result(grid_result) as ds:
        fig = campbell(ds)
    assert len(fig.axes) == 4 and "0.5" in fig.axes[2].get_title("left")


@pytest.mark.parametrize("cases", [slice(0, 2), slice(0, 1)])
def test_fewer_than_three_speeds_are_no_diagram(sweep, cases):
    with pytest.raises(NothingToDraw, match="three values"):
        campbell(sweep.isel(case=cases))


def design(speeds, masses):
    """Cases of one mode with these speeds and masses."""
    masses = xr.DataArray(masses, dims="case", attrs={"units": "kg"})
    frequency = np.sqrt(2e4 / (1.0 + masses.values) - 0.5 * np.square(speeds))
    return xr.Dataset(
        {"angular_frequency": (("case", "mode"), frequency[:, None], {"coordinates": "rotation_angular_velocity impact_mass"})},
        {"case": np.arange(1, len(speeds) + 1), "mode": [1], "rotation_angular_velocity": ("case", speeds), "impact_mass": masses},
    )


@pytest.mark.filterwarnings("error")
def test_a_design_whose_speeds_are_scattered_is_no_diagram():
    dice = np.random.default_rng(1)
    with pytest.raises(NothingToDraw, match="sweep over the angular velocity"):
        campbell(design(dice.uniform(0.0, 100.0, 60), dice.uniform(0.1, 2.0, 60)))


@pytest.mark.filterwarnings("error")
def test_values_that_come_with_three_speeds_are_panels_and_a_speed_that_comes_twice_counts_once():
    fig = campbell(design([0.0, 90.0, 40.0, 40.0, 0.0, 10.0, 10.0, 50.0], [2.0, 2.0, 2.0, 2.0, 0.5, 0.5, 0.5, 1.0]))
    (axes,) = fig.axes
    assert axes.get_title("left") == "$m_j$\u00a0=\u00a02\u00a0kg"
    (marks,) = (line for line in axes.lines if line.get_marker() == "o")
    np.testing.assert_allclose(marks.get_xdata(), RPM * np.array([0.0, 40.0, 90.0]))


def test_other_sweeps_are_no_diagram(paper_results):
    with open_result(paper_results / "fig7.nc") as ds, pytest.raises(NothingToDraw, match="angular velocity"):
        campbell(ds)


def test_a_mode_that_is_chosen_is_followed_beyond_those_that_are_not():
    speed = np.linspace(0.0, 100.0, 21)
    squares = np.stack([2e4 - 0.9 * speed**2, 1.3e4 + 0.5 * speed**2], axis=1)
    ds = xr.Dataset(
        {"angular_frequency": (("case", "mode"), np.sqrt(np.sort(squares, axis=1)))},
        {"case": np.arange(1, 22), "mode": [1, 2], "rotation_angular_velocity": ("case", speed)},
    )
    (second,) = curves(campbell(ds, modes=2).axes[0]).values()
    assert list(curves(campbell(ds, modes=[2, 1]).axes[0])) == ["mode 2", "mode 1"]
    np.testing.assert_array_equal(curves(campbell(ds, modes=[2, 1]).axes[0])["mode 2"].get_ydata(), second.get_ydata())
    np.testing.assert_allclose(second.get_ydata(), np.sqrt(2e4 - 0.9 * (second.get_xdata() / RPM) ** 2) / (2 * np.pi))


def test_where_no_mode_oscillates_there_is_no_diagram(sweep):
    with pytest.raises(NothingToDraw, match="oscillates"):
        campbell(sweep.sel(case=slice(8, None)), modes=1)


def test_all_panels_of_a_second_input_have_one_scale_that_shows_every_mode(grid_result):
    with open_result(grid_result) as ds:
        heavy = ds.assign(angular_frequency=ds["angular_frequency"].where((ds["case"] < 49) | (ds["case"] > 51)))
        fig = campbell(heavy)  # of the last mass most cases of mode 1 have no frequency
    limits = {(axes.get_yscale(), axes.get_ylim()) for axes in fig.axes}
    assert len(limits) == 1
    ((scale, (bottom, top)),) = limits
    first = ds["angular_frequency"].sel(mode=1).values / (2 * np.pi)
    assert scale == "linear" and bottom == 0 and top > first[0]
    assert any("of 6 modes in the file" in text.get_text() for text in fig.texts)


@pytest.mark.parametrize(("beta", "size"), [([2200.0, 3100.0], None), ([55.0, 200.0, 600.0, 1000.0, 1500.0], (3.35, 2.2))])
def test_names_of_multiples_stand_apart(beta, size):
    speed = np.linspace(0.0, 60.0, 11)  # to 573 rpm, below modes that are near each other and far above the multiples
    ds = xr.Dataset(
        {"angular_frequency": (("case", "mode"), np.tile(beta, (11, 1)))},
        {"case": np.arange(1, 12), "mode": np.arange(len(beta)) + 1, "rotation_angular_velocity": ("case", speed)},
    )
    with of_size(size):
        (axes,) = campbell(ds).axes
    axes.figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.texts]
    assert axes.texts[0].get_text() == "1P" and len(boxes) > 1
    assert not any(one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[:i])


def test_multiples_of_the_speed_meet_the_modes_where_the_closed_form_says(sweep):
    table = crossings(sweep, orders=(1, 3))
    elastic = dict(zip(sweep["mode"].values, sweep["angular_frequency"].isel(case=0).values))  # β² = elastic² - ω²
    expected = {(mode, order): rest / np.hypot(1, order) for mode, rest in elastic.items() for order in (1, 3)}
    expected = {key: speed for key, speed in expected.items() if speed < SPEEDS[-1]}
    assert {(row.mode, row.order): row.angular_velocity for row in table.itertuples()} == pytest.approx(expected, rel=1e-9)
    np.testing.assert_allclose(table["frequency"], table["order"] * table["rpm"] / 60, rtol=1e-12)
    assert (np.diff(table["rpm"]) > 0).all()
    (axes,) = campbell(sweep, orders=(1, 3)).axes
    assert axes.get_yscale() == "linear"
    marked = np.concatenate([line.get_xdata() for line in axes.lines if line.get_marker() == "D"])
    assert sorted(marked) == pytest.approx(sorted(table["rpm"]))


def test_crossings_of_two_swept_inputs_are_refused(grid_result):
    with open_result(grid_result) as ds, pytest.raises(NothingToDraw, match="alone"):
        crossings(ds)
