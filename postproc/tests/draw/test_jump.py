"""The jump in velocity: no form is drawn that the numbers do not have."""

import numpy as np
import pytest
import synthetic

from beamwave_postproc import NothingToDraw, compare, open_result, velocity_jump


def notes(fig):
    return " ".join(text.get_text() for text in fig.texts)


def test_the_jump_gathers_at_the_tip_as_modes_are_added(paper_results):
    with open_result(paper_results / "fig3.nc") as ds:
        lines = velocity_jump(ds).axes[0].lines
    share = [np.mean(line.get_ydata() ** 2) for line in lines]
    tip = [line.get_ydata()[-1] for line in lines]
    assert (np.diff(share) < 0).all() and (np.diff(tip) > 0).all()


def test_every_curve_has_a_whole_marker_at_the_tip(paper_results):
    with open_result(paper_results / "fig3.nc") as ds:
        for line in velocity_jump(ds, cases=[1, 2]).axes[0].lines:
            assert line.get_markevery()[-1] == 200 and not line.get_clip_on()


def test_a_jump_of_the_tip_alone_has_no_picture_and_beside_another_no_ramp(full_result):
    with open_result(full_result) as ds:
        limit = ds.assign(
            velocity_jump=ds["velocity_jump"].copy(data=np.where(ds["profile_position"] == 1.0, 1.0, 0.0))
        )
        with pytest.raises(NothingToDraw, match="infinitely many modes"):
            velocity_jump(limit)
        rest, mark = compare(limit, ds)["velocity_jump"].axes[0].lines[:2]
    assert not rest.get_ydata().any() and (mark.get_xdata(), mark.get_ydata()) == ([1.0], [1.0])
    assert mark.get_linestyle() == "None"


def test_inputs_that_do_not_change_the_jump_make_no_curves(grid_result, tmp_path):
    with open_result(grid_result) as ds:
        (axes,) = velocity_jump(ds).axes  # the mass ratios in one panel: the speed leaves the jump as it is
        assert len(axes.lines) == 4 and "the same for all ω" in notes(velocity_jump(ds))
        assert "ω from 0 to 150" in notes(velocity_jump(ds)).replace("\u00a0", " ")
        alone = velocity_jump(ds.isel(case=slice(3)))
    assert len(alone.axes[0].lines) == 1 and not alone.legends
    settings = synthetic.scene(modes={"before": 5, "after": 5})
    path = synthetic.write(tmp_path / "v.nc", settings, {"impact_approach_velocity": [1.0, 1.0 + 1e-9]})
    with open_result(path) as ds:
        assert len(velocity_jump(ds).axes[0].lines) == 2  # a small difference is one


def test_no_jump_is_a_line_at_zero(full_result):
    with open_result(full_result) as ds:
        fig = velocity_jump(ds.assign(velocity_jump=0.0 * ds["velocity_jump"]))
    (line,) = fig.axes[0].lines
    assert not line.get_ydata().any() and "no jump" in notes(fig)
    assert fig.axes[0].get_yticks().tolist() == [0.0]  # and no number that is invented


def test_too_few_samples_for_the_waves_are_drawn_as_samples(tmp_path):
    for points, joined in ((201, True), (61, False)):
        settings = synthetic.scene(modes={"before": 40, "after": 5}, impact={"profile_points": points})
        with open_result(synthetic.write(tmp_path / "jump.nc", settings)) as ds:
            fig = velocity_jump(ds)
        (line,) = fig.axes[0].lines
        assert (line.get_linestyle() != "None") == joined
        assert ("61 samples do not show 40 modes" in notes(fig)) != joined
