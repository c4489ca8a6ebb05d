"""Lines of a record: amplitude and decay over frequency, with intervals and status."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import NothingToDraw, lines

HERTZ = np.array([3.0, 19.0, 54.0])
STATUS = {"flag_values": [1, 2, 3], "flag_meanings": "line close_pair harmonic", "units": "1"}


@pytest.fixture
def record():
    """Three lines at two sensors, the last a harmonic, the second without an interval."""
    return xr.Dataset(
        {
            "measured_angular_frequency": ("peak", 2 * np.pi * HERTZ, {"units": "rad s-1"}),
            "measured_angular_frequency_error": ("peak", [0.1, np.nan, 0.3]),
            "measured_decay_rate": ("peak", [0.2, -0.1, 1.5], {"units": "s-1"}),
            "measured_decay_rate_error": ("peak", [0.01, np.nan, 0.1]),
            "measured_amplitude": (("point", "peak"), [[1e-3, 1e-4, 1e-5], [2e-3, 3e-4, np.nan]], {"units": "m"}),
            "peak_status": ("peak", [1, 1, 3], STATUS),
        },
        {"peak": [1, 2, 3], "point_position": ("point", [0.5, 1.0])},
        {"title": "A ring-down", "effects": "record"},
    )


def test_amplitudes_stand_by_sensor_and_decay_by_status(record):
    fig = lines(record)
    above, below = fig.axes
    first, second = (box.lines[0] for box in above.containers)
    np.testing.assert_allclose(first.get_xdata(), HERTZ)
    np.testing.assert_array_equal(second.get_ydata(), [2e-3, 3e-4])
    single, harmonic = (box.lines[0] for box in below.containers)
    np.testing.assert_array_equal(single.get_ydata(), [0.2, -0.1])
    assert single.get_marker() != harmonic.get_marker()
    words = [text.get_text() for text in fig.legends[0].get_texts()]
    assert words[2:] == ["line", "harmonic"] and "0.5" in words[0]
    assert any("negative decay rates grow" in text.get_text() for text in fig.texts)


def test_intervals_are_half_as_wide_as_their_bars(record):
    _, below = lines(record).axes
    bars = below.containers[1].lines[2]
    across, along = (bar.get_segments()[0] for bar in bars)
    assert np.ptp(across[:, 0]) == pytest.approx(2 * 0.3 / (2 * np.pi)) and np.ptp(along[:, 1]) == pytest.approx(0.2)


def test_a_record_without_places_or_amplitudes_has_its_decay_alone(record):
    fig = lines(record.drop_vars(["measured_amplitude", "point_position", "peak_status"]))
    assert [axes.get_visible() for axes in fig.axes] == [False, True]
    assert len(fig.axes[1].containers[0].lines[0].get_xdata()) == 3


def test_a_record_that_is_a_sweep_of_repeats_has_a_colour_for_each(record):
    twice = xr.concat([record, record], dim="case").assign_coords(case=[1, 2], point_position=("point", [0.5, 1.0]))
    fig = lines(twice)
    assert [text.get_text() for text in fig.legends[0].get_texts()] == ["case 1", "case 2"]


def test_a_simulation_has_no_decay_to_draw(record):
    with pytest.raises(NothingToDraw, match="measured_decay_rate"):
        lines(record.drop_vars("measured_decay_rate"))


def test_repeats_have_axes_for_each_sensor_and_a_marker_for_each_file(record):
    repeats = xr.concat([record, record], dim="case", data_vars="all", coords="minimal")
    repeats = repeats.assign_coords(case=[1, 2], record_file=("case", [1, 2], {"units": "1", "long_name": "file"}))
    first, second, decay = lines(repeats).axes
    for axes, sizes in ((first, [1e-3, 1e-4, 1e-5]), (second, [2e-3, 3e-4])):
        assert len(axes.containers) == 2
        np.testing.assert_array_equal(axes.containers[1].lines[0].get_ydata(), sizes)
    assert decay.get_ylabel().startswith("Decay rate")
