"""Modes followed through a sweep: a crossing does not swap them, with shapes or without."""

import numpy as np
import xarray as xr

from beamwave_postproc.parts.follow import eigenvalues, followed

SPEED = np.linspace(0.0, 10.0, 21)


def crossing(rate=0.0):
    """Two modes whose β² cross at ω² = 50, sorted by frequency as in a file; which is which, by case and mode."""
    squares = np.stack([100.0 - 0.9 * SPEED**2, 20.0 + 0.7 * SPEED**2], axis=1)
    order = np.argsort(squares, axis=1)
    beta = np.sqrt(np.take_along_axis(squares, order, axis=1))
    return xr.Dataset({"angular_frequency": (("case", "mode"), beta)}), order


def test_eigenvalues_go_on_straight_through_a_crossing():
    ds, identity = crossing()
    branches = followed(ds, SPEED**2)
    assert (identity != identity[0]).any()
    np.testing.assert_array_equal(np.take_along_axis(identity, branches, axis=1), np.tile(identity[0], (21, 1)))


def test_shapes_decide_where_the_file_has_them():
    ds, identity = crossing()
    forms = np.array([[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, -1.0, 2.0]])
    signs = np.where(np.arange(21) % 2, -1.0, 1.0)[:, None, None]  # a shape may turn its sign from case to case
    ds = ds.assign(mode_shape=(("case", "mode", "profile"), signs * forms[identity]))
    shaken = np.random.default_rng(5).permutation(21)  # without an order in which eigenvalues could go on
    branches = followed(ds.isel(case=shaken), SPEED[shaken] ** 2)
    np.testing.assert_array_equal(
        np.take_along_axis(identity[shaken], branches, axis=1), np.tile(identity[shaken[0]], (21, 1))
    )


def test_a_mode_that_grows_has_a_negative_eigenvalue_and_a_damped_one_that_of_the_undamped():
    beta, rate = np.array([[np.nan, 3.0, np.nan]]), np.array([[2.0, -4.0, np.nan]])
    ds = xr.Dataset({"angular_frequency": (("case", "mode"), beta), "growth_rate": (("case", "mode"), rate)})
    np.testing.assert_array_equal(eigenvalues(ds), [[-4.0, 25.0, np.nan]])


def test_a_branch_that_is_missing_for_a_while_is_found_again():
    ds, _ = crossing()
    holed = ds.where((ds["mode"] != 0) | (ds["case"] != 5)) if "case" in ds.coords else ds
    values = holed["angular_frequency"].values.copy()
    values[5, 1] = np.nan
    branches = followed(xr.Dataset({"angular_frequency": (("case", "mode"), values)}), SPEED**2)
    assert branches[4].tolist() == branches[6].tolist() == [0, 1]
