"""Impulses of a mass that bounces."""

import numpy as np
import pytest

from beamwave_postproc import NothingToDraw, impulses, open_result

KINDS = {"flag_values": [1, 2, 3, 4], "flag_meanings": "impact capture release contact"}


@pytest.fixture
def bounces(full_result):
    """An impact and three contacts, the last of which stays to the end, and room for one more."""
    columns = {
        "event_time": [0.0, 0.1, 0.2, 0.6, np.nan],
        "event_end": [0.0, 0.1, 0.3, np.nan, np.nan],
        "event_kind": [1.0, 4.0, 4.0, 4.0, np.nan],
        "event_impulse": [0.5, 0.25, 0.125, 0.0625, np.nan],
    }
    with open_result(full_result) as ds:
        bare = ds.drop_vars(["event", *columns]).load()
    units = {"event_time": "s", "event_end": "s", "event_impulse": "N s"}
    attributes = {name: {"units": units.get(name, "1"), **(KINDS if name == "event_kind" else {})} for name in columns}
    return bare.assign({name: ("event", column, attributes[name]) for name, column in columns.items()})


def test_each_impulse_stands_at_its_time_and_lasts_as_its_contact(bounces):
    fig = impulses(bounces)
    (axes,) = fig.axes
    marks = next(line for line in axes.lines if line.get_marker() == "o")
    np.testing.assert_array_equal(marks.get_xdata(), [0.0, 0.1, 0.2, 0.6])
    np.testing.assert_array_equal(marks.get_ydata(), [0.5, 0.25, 0.125, 0.0625])
    spans = [
        band.get_paths()[0].vertices[:, 0] for band in axes.collections if band.get_paths()[0].vertices.shape[0] > 4
    ]
    assert [(span.min(), span.max()) for span in spans] == [(0.2, 0.3), (0.6, pytest.approx(1.0, abs=1e-4))]
    assert any("3 contacts" in text.get_text() for text in fig.texts) and "(N s)" in axes.get_ylabel()


def test_a_single_impulse_is_no_picture(full_result):
    with open_result(full_result) as ds, pytest.raises(NothingToDraw, match="two impulses"):
        impulses(ds)


def test_the_axis_of_time_ends_with_the_numbers(bounces):
    short = bounces.assign(displacement=bounces["displacement"].where(bounces["time"] < 0.25))
    assert impulses(short).axes[0].get_xlim()[1] == pytest.approx(1.015 * 0.6)  # the last contact
    early = short.assign(event_time=bounces["event_time"] / 10.0)
    assert impulses(early).axes[0].get_xlim()[1] == pytest.approx(1.015 * 250.0, rel=1e-3)  # ms
