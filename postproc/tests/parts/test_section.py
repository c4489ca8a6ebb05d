"""Strain and stress of the outermost fibre, from the bending moment."""

import numpy as np
import pytest
import synthetic
import xarray as xr

from beamwave_postproc import NothingToDraw, bending_moment, open_result, strain, stress
from beamwave_postproc.parts.relation import bending_constant
from beamwave_postproc.parts.section import beam_mass, sections_at, sections_of

DIAMETER, MODULUS = 0.037, 2e11


@pytest.fixture(scope="module")
def moments(tmp_path_factory):
    settings = synthetic.scene(
        modes={"before": 10, "after": 10}, response={"duration": 0.1, "samples": 200, "bending_moment": True}
    )
    path = tmp_path_factory.mktemp("moments") / "moments.nc"
    with open_result(synthetic.write(path, settings, {"rotation_angular_velocity": [0.0, 50.0]})) as ds:
        return ds.load()


def test_stress_is_the_moment_over_the_section_modulus_and_strain_that_over_the_elastic_one(moments):
    expected = 32.0 / (np.pi * DIAMETER**3) * moments["bending_moment"]
    found = stress(moments)
    # Two ways to the same few products.
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    np.testing.assert_allclose(strain(moments), expected / MODULUS, rtol=1e-14)
    assert found.dims == moments["bending_moment"].dims and found.attrs["units"] == "Pa"
    assert strain(moments).attrs["units"] == "1"
    np.testing.assert_array_equal(stress(moments.isel(case=1)), found.isel(case=1))


def test_their_errors_are_those_of_the_moment(moments):
    with_error = moments.assign(bending_moment_error=(("case", "point"), np.array([[1.0, 2.0], [3.0, 4.0]])))
    found = stress(with_error, error=True)
    np.testing.assert_allclose(found, 32.0 / (np.pi * DIAMETER**3) * with_error["bending_moment_error"], rtol=1e-14)
    assert found.name == "stress_error"
    with pytest.raises(NothingToDraw, match="bending_moment_error"):
        stress(moments, error=True)


def test_a_section_by_area_and_second_moment_needs_the_distance_of_the_fibre(moments):
    area, second_moment = np.pi / 4 * DIAMETER**2, np.pi / 64 * DIAMETER**4
    other = moments.drop_vars("beam_diameter").assign(beam_area=area, beam_second_moment=second_moment)
    with pytest.raises(NothingToDraw, match="reach"):
        stress(other)
    np.testing.assert_allclose(stress(other, reach=DIAMETER / 2), stress(moments), rtol=1e-14)


def test_where_two_pieces_meet_the_larger_counts(moments):
    one = moments.isel(case=0)
    pieces = one.drop_vars("beam_diameter").assign(
        beam_length=("piece", [0.5, 0.5]), beam_width=("piece", [0.02, 0.02]), beam_height=("piece", [0.02, 0.01])
    )
    assert [section.reach for section in sections_of(pieces)] == [0.01, 0.005]
    assert len(sections_at(pieces, 0.5)) == 2 and len(sections_at(pieces, 0.7)) == 1
    thin = 6.0 / (0.02 * 0.01**2) * one["bending_moment"]
    np.testing.assert_allclose(stress(pieces), thin, rtol=1e-14)  # at 0.5, the joint, and at 1


def test_sections_between_stations_are_linear_in_their_sides(moments):
    one = moments.isel(case=0)
    cone = one.assign(beam_diameter=("station", [0.04, 0.02]))
    assert [section.reach for xi in (0.0, 0.5, 1.0) for section in sections_at(cone, xi)] == [0.02, 0.015, 0.01]
    density, length = float(one["beam_density"]), float(one["beam_length"])
    assert beam_mass(cone) == pytest.approx(density * length * np.pi / 12 * (0.04**2 + 0.04 * 0.02 + 0.02**2), rel=1e-14)
    assert bending_constant(cone) is None and bending_constant(one) is not None
    middle = one["point_position"].values == 0.5
    np.testing.assert_allclose(stress(cone)[middle], 32 / (np.pi * 0.03**3) * one["bending_moment"][middle], rtol=1e-14)


def test_mass_per_length_and_bending_stiffness_tell_strain_and_no_stress(moments):
    area, second_moment = np.pi / 4 * DIAMETER**2, np.pi / 64 * DIAMETER**4
    lumped = moments.drop_vars(["beam_diameter", "beam_density", "beam_youngs_modulus"]).assign(
        beam_mass_per_length=7870 * area, beam_bending_stiffness=MODULUS * second_moment, beam_extreme_fibre=DIAMETER / 2
    )
    np.testing.assert_allclose(strain(lumped), strain(moments), rtol=1e-13)
    with pytest.raises(NothingToDraw, match="stress"):
        stress(lumped)


def test_the_picture_of_the_moment_has_the_stress_at_its_right(moments):
    fig = bending_moment(moments, 0.5)
    (axes,) = fig.axes
    (right,) = axes.child_axes
    fig.draw_without_rendering()
    largest = axes.get_ylim()[1]
    assert "kN m" not in axes.get_ylabel() or largest > 0.4
    unit = {"MPa": 1e6, "kPa": 1e3, "GPa": 1e9}[right.get_ylabel().split("(")[1].rstrip(")")]
    scale = {"(kN m)": 1e3, "(N m)": 1.0}["(" + axes.get_ylabel().split("(")[1]]
    assert right.get_ylim()[1] * unit == pytest.approx(32.0 / (np.pi * DIAMETER**3) * largest * scale)


def test_no_moments_no_stress(full_result):
    with open_result(full_result) as ds, pytest.raises(NothingToDraw, match="bending_moment"):
        strain(ds)


def test_a_single_number_stands_for_all_pieces():
    ds = xr.Dataset(
        {
            "beam_length": ("piece", [1.0, 3.0]),
            "beam_diameter": 0.01,
            "beam_youngs_modulus": 1.0,
            "beam_density": ("piece", [1.0, 2.0]),
        }
    )
    assert [(section.length, section.density) for section in sections_of(ds)] == [(1.0, 1.0), (3.0, 2.0)]
    assert sections_at(ds, 0.25)[0].length == 1.0 and len(sections_at(ds, 0.25)) == 2
