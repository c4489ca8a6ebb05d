"""Dispersion, phase and group velocity: the pictures show what the paper says of Figs 2, 4 and 5."""

import numpy as np
import pytest
import synthetic
import xarray as xr

from beamwave_postproc import NothingToDraw, dispersion, group_velocity, open_result, phase_velocity
from beamwave_postproc.parts.relation import relation_of

PICTURES = {
    "angular_frequency": dispersion,
    "phase_velocity": phase_velocity,
    "group_velocity": group_velocity,
}


def smooth_lines(axes):
    return [line for line in axes.lines if line.get_marker() == "" and line.get_xdata().size > 2]


def modes_drawn(axes):
    return [line for line in axes.lines if line.get_linestyle() == "None" and line.get_marker() != "x"]


@pytest.mark.parametrize("name", PICTURES)
def test_modes_lie_on_the_smooth_relation(paper_results, name):
    with open_result(paper_results / "fig2.nc") as ds:
        axes = PICTURES[name](ds).axes[0]
    assert len(smooth_lines(axes)) == len(modes_drawn(axes)) == 3
    for smooth, modes in zip(smooth_lines(axes), modes_drawn(axes)):
        on_curve = np.interp(np.log(modes.get_xdata()), np.log(smooth.get_xdata()), np.log(smooth.get_ydata()))
        # Linear interpolation between 4000 points, worst at mode 1 near the cut-off.
        np.testing.assert_allclose(on_curve, np.log(modes.get_ydata()), atol=1e-3)


@pytest.mark.parametrize("name", PICTURES)
def test_rotation_lowers_frequency_and_phase_velocity_and_raises_group_velocity(paper_results, name):
    """And the lower the mode, the more."""
    direction = 1 if name == "group_velocity" else -1
    with open_result(paper_results / "fig2.nc") as ds:
        still, *turning = [line.get_ydata() for line in modes_drawn(PICTURES[name](ds).axes[0])]
    for values in turning:
        change = direction * (values - still) / still
        assert (change > 0).all()
        assert (np.diff(change) < 0).all()


def test_every_mode_is_inside_the_axes(paper_results):
    for name, picture in PICTURES.items():
        with open_result(paper_results / "fig2.nc") as ds:
            axes = picture(ds).axes[0]
            (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
            assert x0 < ds["wavenumber"].min() and ds["wavenumber"].max() < x1
            assert y0 < ds[name].min() and ds[name].max() < y1


def test_an_unstable_mode_is_not_drawn(tmp_path):
    path = synthetic.write(tmp_path / "fast.nc", synthetic.scene(rotation={"angular_velocity": 130.0}))
    with open_result(path) as ds:
        (modes,) = modes_drawn(dispersion(ds).axes[0])
        np.testing.assert_array_equal(modes.get_xdata(), ds["wavenumber"].values[1:])


def test_a_result_with_nothing_but_unstable_modes_has_no_picture(tmp_path):
    settings = synthetic.scene(rotation={"angular_velocity": 130.0}, modes={"before": 1, "after": 1})
    with open_result(synthetic.write(tmp_path / "one.nc", settings)) as ds, pytest.raises(NothingToDraw):
        dispersion(ds)


@pytest.mark.parametrize("name", PICTURES)
def test_modes_that_obey_another_relation_are_marks_alone_beside_the_paper_s_in_grey(full_result, name):
    with open_result(full_result) as ds:
        damped = ds.assign({other: 0.99 * ds[other] for other in PICTURES})
        assert relation_of(damped) is None
        axes = PICTURES[name](damped).axes[0]
    (plain,) = smooth_lines(axes)
    assert plain.get_linestyle() == ":" and plain.get_label().endswith("for comparison")
    assert all(line.get_linestyle() == "None" for line in axes.lines if line is not plain)


def out_of_plane(ds):
    """The result with its plane of rotation in its scene."""
    return ds.assign_attrs(scene="&rotation\n  plane = 'out'\n/\n")


@pytest.mark.parametrize("name", PICTURES)
def test_out_of_plane_the_speed_does_not_enter_what_tension_is_compared_with(paper_results, name):
    with open_result(paper_results / "fig2.nc") as ds:
        stiffened = ds.assign({other: 1.3 * ds[other] for other in PICTURES})
        in_plane, out = (PICTURES[name](case).axes[0] for case in (stiffened, out_of_plane(stiffened)))
        h = relation_of(ds.isel(case=0)).h
    assert [line.get_label().split(",")[1] for line in smooth_lines(in_plane)] == [" for comparison"] * 3
    (line,) = smooth_lines(out)  # one for all speeds
    p, shown = line.get_xdata(), line.get_ydata()
    expected = {"angular_frequency": h * p**2, "phase_velocity": h * p, "group_velocity": 2 * h * p}[name]
    # The picture goes from P to β and back.
    np.testing.assert_allclose(shown, expected, rtol=1e-12)


def test_a_beam_of_pieces_has_marks_alone(full_result):
    with open_result(full_result) as ds:
        pieces = ds.drop_vars("beam_length").assign(beam_length=("piece", [0.5, 0.5]))
        assert not smooth_lines(dispersion(pieces).axes[0])


def test_the_right_axis_is_the_frequency_in_hertz(full_result):
    with open_result(full_result) as ds:
        fig = dispersion(ds)
    fig.draw_without_rendering()
    (right,) = fig.axes[0].child_axes
    np.testing.assert_allclose(np.multiply(right.get_ylim(), 2 * np.pi), fig.axes[0].get_ylim())
    assert right.get_ylabel() == "Frequency (Hz)"


def test_modes_that_grow_are_named(tmp_path):
    path = synthetic.write(tmp_path / "fast.nc", synthetic.scene(rotation={"angular_velocity": 130.0}))
    with open_result(path) as ds:
        assert any("mode 1 grows and is not drawn" in text.get_text() for text in dispersion(ds).texts)


def test_the_head_says_that_more_modes_were_summed_than_the_file_holds(full_result):
    with open_result(full_result) as ds:
        few, every = (phase_velocity(ds.assign(mode_count=count)).texts for count in (487, 40))
    assert any("the first 40 modes, which are in the file" in text.get_text() for text in few)
    assert not any("in the file" in text.get_text() for text in every)


def test_out_of_plane_modes_lie_on_the_relation_without_rotation(full_result):
    with open_result(full_result) as ds:
        relation = relation_of(ds)
        still = ds.assign(angular_frequency=relation.h * ds["wavenumber"] ** 2)
        assert relation.omega == 50.0
        assert relation_of(still).omega == 0.0


def test_one_case_shows_the_modes_before_the_capture_too(full_result):
    with open_result(full_result) as ds:
        texts = [text.get_text() for text in dispersion(ds).legends[0].get_texts()]
    assert texts == ["modes after the capture", "modes before the capture"]


def test_a_beam_of_area_and_second_moment_has_the_same_relation(full_result):
    with open_result(full_result) as ds:
        radius = float(ds["beam_diameter"]) / 2
        section = {"beam_area": np.pi * radius**2, "beam_second_moment": np.pi / 4 * radius**4}
        other = ds.drop_vars("beam_diameter").assign(section)
        # h from one formula or the other, a few roundings apart.
        assert relation_of(other).h == pytest.approx(relation_of(ds).h, rel=1e-14)


def test_group_velocity_leaves_the_picture_at_the_cut_off(full_result):
    with open_result(full_result) as ds:
        axes = group_velocity(ds).axes[0]
    assert smooth_lines(axes)[0].get_ydata()[0] > axes.get_ylim()[1]


def test_an_input_that_leaves_the_modes_as_they_are_adds_no_curves(full_result):
    with open_result(full_result) as ds:
        one = ds.load()
    places = [one.assign_coords(impact_position=0.1 * i, case=i) for i in (3, 5, 7)]
    fig = dispersion(xr.concat(places, dim="case", data_vars="all", coords="different", compat="equals"))
    assert any("the same for all ξ₀" in text.get_text() for text in fig.texts)
    assert len(modes_drawn(fig.axes[0])) == len(modes_drawn(dispersion(one).axes[0]))
