"""Shares of a wave's power that bodies and steps transmit."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import NothingToDraw, transmission

FREQUENCY = np.geomspace(1.0, 100.0, 50)


def result(shares, **more):
    """A result with these shares, (junction, frequency), or (case, junction, frequency)."""
    dims = ("case", "junction", "response_frequency")[-shares.ndim :]
    places = np.broadcast_to([0.2, 0.7], shares.shape[:-1])
    return xr.Dataset(
        {"transmitted_power": (dims, shares, {"units": "1"}), "junction_position": (dims[:-1], places, {"units": "1"}), **more},
        {"response_frequency": ("response_frequency", FREQUENCY, {"units": "Hz"})},
        {"source": "beamwave", "effects": "", "scene": ""},
    )


SHARES = np.array([1.0 / (1.0 + FREQUENCY), 1.0 - 0.001 * FREQUENCY])


def test_each_body_or_step_has_a_curve():
    axes = transmission(result(SHARES)).axes[0]
    for line, expected in zip(axes.lines, SHARES, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), expected)
    assert [line.get_label() for line in axes.lines] == ["ξ = 0.2", "ξ = 0.7"]


def test_the_cases_of_a_sweep_are_curves_at_the_first_junction():
    values = np.array([SHARES, 0.5 * SHARES])
    ds = result(values, case=("case", [1, 2]), body_mass=("case", [1.0, 2.0], {"units": "kg"}))
    ds["transmitted_power"].attrs["coordinates"] = "body_mass"
    axes = transmission(ds).axes[0]
    for line, expected in zip(axes.lines, values[:, 0], strict=True):
        np.testing.assert_array_equal(line.get_ydata(), expected)


def test_a_beam_without_bodies_and_steps_is_not_drawn():
    with pytest.raises(NothingToDraw):
        transmission(result(np.full((2, 50), np.nan)))
