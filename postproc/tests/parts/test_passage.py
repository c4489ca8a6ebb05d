"""Ways of waves along the beam and the times that they take."""

import numpy as np
import pytest
import synthetic
import xarray as xr

from beamwave_postproc import open_result
from beamwave_postproc.parts.passage import arrivals, blow_at, first_part, way_times, ways_to
from beamwave_postproc.parts.relation import relation_of


def test_ways_go_straight_and_by_images_of_the_blow_behind_root_and_tip():
    assert ways_to(1.0, 0.5)[:3] == [0.5, 1.5, 2.5]
    assert ways_to(1.0, 1.0)[:2] == [2.0, 4.0]
    assert ways_to(0.7, 0.2)[:4] == pytest.approx([0.5, 0.9, 1.1, 1.5])  # straight, by the root, by the tip, by both


def test_waves_arrive_at_the_group_velocity(full_result):
    with open_result(full_result) as ds:
        frequency, (straight, reflected), smooth = way_times(ds, 0.5, 2)
        velocity = relation_of(ds).value("group_velocity", 2 * np.pi * frequency)
        modes = ds["angular_frequency"].values / (2 * np.pi), ds["group_velocity"].values
    assert smooth
    # The frequency goes through Hz and back: a rounding of it and one of the way's time.
    np.testing.assert_allclose(straight, 0.5 / velocity, rtol=1e-14)
    np.testing.assert_allclose(reflected, 1.5 / velocity, rtol=1e-14)
    inside = (modes[0] > frequency[0]) & (modes[0] < frequency[-1])
    # Between 400 frequencies, even in their logarithm over five decades.
    np.testing.assert_allclose(np.interp(modes[0][inside], frequency, velocity), modes[1][inside], rtol=1e-3)


def test_modes_that_obey_no_relation_give_the_times_of_their_own(full_result):
    with open_result(full_result) as ds:
        other = ds.assign(angular_frequency=0.9 * ds["angular_frequency"])
        frequency, (straight,), smooth = way_times(other, 0.5, 1)
    assert not smooth
    np.testing.assert_array_equal(frequency, other["angular_frequency"].values / (2 * np.pi))
    np.testing.assert_array_equal(straight, 0.5 / other["group_velocity"].values)


def test_the_blow_is_at_the_tip_unless_told():
    assert blow_at(xr.Dataset()) == 1.0 and blow_at(xr.Dataset({"impact_position": 0.7})) == 0.7


def test_a_record_shows_arrivals_only_if_its_samples_resolve_them(tmp_path):
    settings = synthetic.scene(modes={"before": 40, "after": 40}, response={"duration": 0.05, "samples": 4096})
    with open_result(synthetic.write(tmp_path / "fast.nc", settings)) as ds:
        assert first_part(ds) == pytest.approx(1.5 / float(ds["group_velocity"][1]))
        assert 0.0 < arrivals(ds) < 0.01
        assert arrivals(ds.isel(time=slice(None, None, 16))) is None
        assert arrivals(ds.drop_vars("group_velocity")) is None
        assert first_part(ds.isel(time=slice(60))) is None
