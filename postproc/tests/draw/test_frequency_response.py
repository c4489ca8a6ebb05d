"""Magnitude and phase of the response to a harmonic force."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import NothingToDraw, frequency_response

FREQUENCY = np.geomspace(1.0, 100.0, 200)
PLACES = [0.5, 1.0]


def answers(ratio, scale=1.0):
    """Of one mode at 10 Hz, at two points."""
    answer = scale / (10.0**2 - FREQUENCY**2 + 2j * ratio * 10.0 * FREQUENCY)
    return np.array([0.3 * answer, answer])


def result(values, **more):
    """A result with these answers, (point, frequency), or (case, point, frequency)."""
    dims = ("case", "point", "response_frequency")[-values.ndim :]
    units = {"units": "m N-1"}
    return xr.Dataset(
        {
            "frequency_response_real": (dims, values.real, units),
            "frequency_response_imag": (dims, values.imag, units),
            "frequency_response_position": 1.0,
            **more,
        },
        {
            "response_frequency": ("response_frequency", FREQUENCY, {"units": "Hz"}),
            "point_position": ("point", PLACES, {"units": "1"}),
        },
        {"source": "beamwave", "effects": "", "scene": ""},
    )


def test_each_point_has_a_curve_of_magnitude_and_one_of_phase():
    fig = frequency_response(result(answers(0.05)))
    magnitude, phase = fig.axes
    for line, turned, expected in zip(magnitude.lines, phase.lines, answers(0.05)):
        np.testing.assert_allclose(line.get_ydata(), np.abs(expected))
        np.testing.assert_allclose(turned.get_ydata(), np.degrees(np.angle(expected)))
    assert [line.get_label() for line in magnitude.lines] == ["ξ = 0.5", "ξ = 1"]
    assert magnitude.get_ylabel() == "Receptance (m/N)"
    low, high = magnitude.get_ylim()
    assert low < np.abs(answers(0.05)).min() and high > np.abs(answers(0.05)).max()


def test_a_phase_that_has_turned_once_begins_anew_behind_a_gap():
    """Of two points, on different sides of a node: the second mode lags by another 180 degrees, and no antiresonance is between."""
    modes = [1.0 / (f**2 - FREQUENCY**2 + 2j * 0.02 * f * FREQUENCY) for f in (8.0, 30.0)]
    phase = frequency_response(result(np.array([modes[0] + modes[1], modes[0] - modes[1]]))).axes[1]
    same, opposite = (line.get_ydata() for line in phase.lines)
    assert np.nanmax(np.abs(np.diff(opposite))) < 90.0 and np.isnan(opposite).sum() == 1
    assert np.nanmin(opposite) >= -181.0 and opposite[-1] == pytest.approx(0.0, abs=10.0)
    assert same[-1] == pytest.approx(-180.0, abs=10.0) and opposite[0] == pytest.approx(0.0, abs=1.0)


def test_what_is_180_degrees_but_for_rounding_is_drawn_at_minus_180():
    rounded = np.array([answers(0.05)[1], -1.0 + 1e-17j * np.ones(FREQUENCY.size)])
    assert frequency_response(result(rounded)).axes[1].lines[1].get_ydata() == pytest.approx(-180.0)


def test_an_acceleration_leads_the_force_from_180_degrees_on():
    ds = result(-((2.0 * np.pi * FREQUENCY) ** 2) * answers(0.05))
    for name in ("frequency_response_real", "frequency_response_imag"):
        ds[name].attrs["units"] = "m s-2 N-1"
    for line in frequency_response(ds).axes[1].lines:
        assert line.get_ydata()[0] == pytest.approx(180.0, abs=1.0) and (np.diff(line.get_ydata()) < 0.0).all()


def test_without_damping_there_is_no_phase_to_draw():
    assert len(frequency_response(result(answers(0.0).real + 0j)).axes) == 1


def test_the_cases_of_a_sweep_are_curves_at_the_first_point():
    values = np.array([answers(0.05), answers(0.1), answers(0.2)])
    swept = {"case": ("case", [1, 2, 3]), "damping_ratio": ("case", [0.05, 0.1, 0.2], {"units": "1"})}
    ds = result(values, **swept)
    ds["frequency_response_real"].attrs["coordinates"] = "damping_ratio"
    magnitude = frequency_response(ds).axes[0]
    for line, expected in zip(magnitude.lines, values[:, 0]):
        np.testing.assert_allclose(line.get_ydata(), np.abs(expected))
    assert len({line.get_label() for line in magnitude.lines}) == 3


def test_a_force_that_moves_nothing_is_not_drawn():
    with pytest.raises(NothingToDraw):
        frequency_response(result(0 * answers(0.05)))
