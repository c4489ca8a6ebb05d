"""Histories that grow, or do not move: the bounded part is seen, and the head says what was done."""

import numpy as np
import pytest
import synthetic

from beamwave_postproc import bending_moment, displacement, open_result


def notes(fig):
    """What the head says."""
    return " ".join(text.get_text() for text in fig.texts)


@pytest.fixture(scope="module")
def growing(tmp_path_factory):
    """A beam at 0 and at 2000 rad/s, the second filled from the sample on at which it would overflow."""
    settings = synthetic.scene(response={"duration": 1.0, "samples": 1000})
    path = tmp_path_factory.mktemp("growing") / "growing.nc"
    synthetic.write(path, settings, {"rotation_angular_velocity": [0.0, 2000.0]})
    with open_result(path) as ds:
        ds.load()
    return ds.assign(displacement=ds["displacement"].where((ds["case"] == 1) | (ds["time"] < 0.3495)))


def test_the_bounded_history_keeps_a_fair_share_of_the_axis(growing):
    axes = displacement(growing).axes[0]
    peak = np.abs(axes.lines[0].get_ydata()).max()
    foot, head, zero, top = axes.transData.transform([(0, -peak), (0, peak), (0, 0), (0, axes.get_ylim()[1])])[:, 1]
    assert axes.get_yscale() == "symlog" and axes.get_ylim()[0] < -1.1 * peak  # which is not cut
    assert (head - foot) > 0.15 * (top - foot) and top > head > zero
    assert axes.get_xlim()[1] == pytest.approx(1.0)  # one of the curves lasts
    assert "1 of these unstable" in notes(displacement(growing))


def test_a_history_that_overflows_is_drawn_to_its_last_number(growing):
    alone = displacement(growing.isel(case=1))
    assert alone.axes[1].get_xlim()[1] == pytest.approx(0.35)  # one step after the last
    assert "unstable" in notes(alone) and "overflow after 0.349 s" in notes(alone)
    assert all(np.isfinite(axes.get_ylim()).all() for axes in alone.axes)


def test_numbers_up_to_the_largest_have_an_axis(growing):
    case = growing.isel(case=1)
    share = np.finfo(float).max / np.abs(case["displacement"]).max()
    fig = displacement(case.assign(displacement=case["displacement"] * share))
    fig.draw_without_rendering()
    assert all(np.isfinite(axes.get_ylim()).all() for axes in fig.axes)


def test_a_moment_whose_stress_overflows_is_drawn_without_it(growing):
    case = growing.isel(case=1)
    moment = (case["displacement"] * (1e302 / np.abs(case["displacement"]).max())).assign_attrs(units="N m")
    fig = bending_moment(case.assign(bending_moment=moment))
    fig.draw_without_rendering()
    assert all(not axes.child_axes and np.isfinite(axes.get_ylim()).all() for axes in fig.axes)


def test_a_bounded_history_has_a_linear_axis_and_no_note(growing):
    fig = displacement(growing.isel(case=0))
    assert fig.axes[0].get_yscale() == "linear" and "unstable" not in notes(fig)


def test_a_point_at_rest_says_zero_and_invents_no_number(growing):
    case = growing.isel(case=0)
    axes = displacement(case.assign(displacement=0.0 * case["displacement"])).axes[0]
    assert axes.get_yticks().tolist() == [0.0]
    assert "zero" in [text.get_text() for text in axes.texts]


def test_a_bounded_history_that_ends_early_says_when_and_why(growing):
    case = growing.isel(case=0)
    status = ((), 2, {"flag_values": np.array([0, 1, 2]), "flag_meanings": "done diverged not_converged"})
    short = case.assign(displacement=case["displacement"].where(case["time"] < 0.2), case_status=status)
    said = notes(displacement(short)).replace("\u00a0", " ")
    assert "the numbers end at 199 ms (not converged)" in said and "unstable" not in said
    assert displacement(short).axes[1].get_xlim()[1] == pytest.approx(0.2)
    assert "end at" not in notes(displacement(case))
