"""The map of frequencies over a sweep of two inputs."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh

from beamwave_postproc import NothingToDraw, open_result, sweep_map


def maps(axes):
    """The image of frequencies on the axes of one mode."""
    return [mesh for mesh in axes.collections if isinstance(mesh, QuadMesh) and mesh.get_cmap().name == "cividis"]


def test_the_map_holds_each_case_s_frequency_in_hertz_at_its_place(grid_result):
    with open_result(grid_result) as ds:
        fig = sweep_map(ds)
        axes = fig.axes[0]
        (mesh,) = maps(axes)
        first = ds["angular_frequency"].isel(mode=0).values.reshape(4, 16) / (2.0 * np.pi)
        np.testing.assert_array_equal(
            np.ma.filled(mesh.get_array().reshape(4, 16), -1.0), np.nan_to_num(first, nan=-1.0)
        )
        assert r"$\omega$" in axes.get_xlabel() and r"$\gamma$" in axes.get_ylabel()
        assert [text.get_text() for text in fig.legends[0].get_texts()] == ["grows", "critical speed"]
        assert len(sweep_map(ds, modes=2).axes) == 2  # the map and its colours


def test_a_case_without_numbers_is_told_from_one_that_grows(grid_result):
    with open_result(grid_result) as ds:
        failed = ds["case"] == 3
        holed = ds.assign({name: ds[name].where(~failed) for name in ("angular_frequency", "growth_rate")})
        fig = sweep_map(holed)
    lacking = [mesh for mesh in fig.axes[1].collections if isinstance(mesh, QuadMesh) and mesh not in maps(fig.axes[1])]
    assert [np.flatnonzero(~np.ma.getmaskarray(mesh.get_array()).ravel()).tolist() for mesh in lacking] == [[2]]
    assert "no numbers" in [text.get_text() for text in fig.legends[0].get_texts()]


def test_swept_numbers_of_pieces_and_bodies_have_short_labels(grid_result):
    with open_result(grid_result) as ds:
        names = {"impact_mass_ratio": "beam_length_2", "rotation_angular_velocity": "body_position_1"}
        swept = ds.rename(names)
        swept["beam_length_2"].attrs = {"units": "m", "long_name": "length from the root to the tip; piece 2"}
        swept["body_position_1"].attrs = {"units": "1", "long_name": "place on the beam: x/l, 1 at the tip; body 1"}
        axes = sweep_map(swept).axes[0]
    assert axes.get_ylabel() == "Length of piece 2 $l_2$ (m)"
    assert axes.get_xlabel() == r"Place of body 1 $\xi_1$"


def test_one_swept_input_makes_no_map(paper_results):
    with open_result(paper_results / "fig2.nc") as ds, pytest.raises(NothingToDraw):
        sweep_map(ds)


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


def test_frequencies_that_no_input_changes_are_no_map(grid_result):
    with open_result(grid_result) as ds:
        alike = ds.assign(angular_frequency=ds["angular_frequency"].isel(case=0) + 0.0 * ds["case"]).drop_vars("growth_rate")
        with pytest.raises(NothingToDraw, match="no frequency that differs from case to case"):
            sweep_map(alike.assign(angular_frequency=alike["angular_frequency"].transpose("case", "mode")))


def test_cells_at_the_edge_are_as_large_as_the_others(grid_result):
    with open_result(grid_result) as ds:
        axes = sweep_map(ds).axes[0]
        decades = ds.assign_coords(rotation_angular_velocity=("case", 10.0 ** (ds["rotation_angular_velocity"].values / 30.0)))
        in_decades = sweep_map(decades.drop_vars("critical_angular_velocity", errors="ignore")).axes[0]
    assert axes.get_xlim() == pytest.approx((-5.0, 155.0))  # speeds 0, 10 … 150
    assert in_decades.get_xscale() == "log" and in_decades.get_xlim() == pytest.approx((10.0 ** (-1 / 6), 10.0 ** (31 / 6)))
