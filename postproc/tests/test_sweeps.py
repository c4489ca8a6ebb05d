"""Sweeps: which cases are drawn, what they are called, and the map over two inputs."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import NothingToDraw, dispersion, open_result, sweep_map, swept_inputs, velocity_jump
from beamwave_postproc.curves import curves_of, heading
from beamwave_postproc.style import MAX_CURVES


def test_swept_inputs_come_slowest_first(grid_result, full_result):
    with open_result(grid_result) as ds:
        assert swept_inputs(ds) == ["impact_mass_ratio", "rotation_angular_velocity"]
    with open_result(full_result) as ds:
        assert swept_inputs(ds) == []


def test_many_cases_are_thinned_evenly_and_the_legend_says_so(grid_result):
    with open_result(grid_result) as ds:
        curves = curves_of(ds)
        assert len(curves) == MAX_CURVES
        assert [int(curve.data["case"]) for curve in curves][:: MAX_CURVES - 1] == [1, 64]
        assert "8 of 64 cases" in dispersion(ds).axes[0].get_legend().get_title().get_text()


def test_the_legend_title_holds_only_what_all_cases_share(paper_results):
    with open_result(paper_results / "fig2.nc") as ds:
        assert heading(ds, "rotation_angular_velocity", "impact_mass_ratio") == r"$\gamma$ = 0.2"


def test_the_map_holds_each_case_at_its_place(grid_result):
    with open_result(grid_result) as ds:
        axes = sweep_map(ds).axes[0]
        drawn = axes.collections[0].get_array().reshape(4, 16)
        first = ds["angular_frequency"].isel(mode=0).values.reshape(4, 16)
        np.testing.assert_array_equal(np.ma.filled(drawn, -1.0), np.nan_to_num(first, nan=-1.0))
        assert r"$\omega$" in axes.get_xlabel() and r"$\gamma$" in axes.get_ylabel()
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["no oscillation"]


def test_one_swept_input_makes_no_map(paper_results):
    with open_result(paper_results / "fig2.nc") as ds, pytest.raises(NothingToDraw):
        sweep_map(ds)


def test_the_jump_gathers_at_the_tip_as_modes_are_added(paper_results):
    with open_result(paper_results / "fig3.nc") as ds:
        lines = velocity_jump(ds).axes[0].lines
    share = [np.mean(line.get_ydata() ** 2) for line in lines]
    tip = [line.get_ydata()[-1] for line in lines]
    assert (np.diff(share) < 0).all() and (np.diff(tip) > 0).all()


def test_the_line_of_critical_speed_parts_what_oscillates_from_what_grows(grid_result):
    with open_result(grid_result) as ds:
        ratio, speed = ds["impact_mass_ratio"], ds["rotation_angular_velocity"]
        first = ds["angular_frequency"].isel(mode=0)
        at_rest = dict(zip(ratio.values[speed.values == 0.0], first.values[speed.values == 0.0]))  # h P², Eq. 31
        critical = xr.DataArray([at_rest[value] for value in ratio.values], dims="case")
        (line,) = sweep_map(ds.assign(critical_angular_velocity=critical)).axes[0].lines
    drawn = dict(zip(line.get_ydata(), line.get_xdata()))
    for value, omega, frequency in zip(ratio.values, speed.values, first.values):
        assert np.isnan(frequency) == (omega > drawn[value])
