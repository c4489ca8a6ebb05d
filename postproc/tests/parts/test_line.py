"""The beam's line between the points of a result."""

import numpy as np
import pytest
import xarray as xr
from scipy.interpolate import CubicSpline

from beamwave_postproc import NothingToDraw
from beamwave_postproc.parts.line import beam_line, moving_points, places_of_line, whole_line

ROUNDING = 1e-13  # of sums of some ten terms of order 1
XI = np.array([0.2, 0.3, 0.65, 1.0])


def result(points, effects="impact"):
    return xr.Dataset(coords={"point_position": ("point", points)}, attrs={"effects": effects})


def test_the_line_is_that_of_a_cantilever_under_a_tip_force():
    xi = np.linspace(0.0, 1.0, 41)
    drawn = beam_line(result(XI), XI, (3.0 * XI**2 - XI**3)[None, :])(xi)[:, 0]  # v = v' = 0 and v'' = 0 at the ends
    np.testing.assert_allclose(drawn, 3.0 * xi**2 - xi**3, atol=ROUNDING)


def elastic(points):
    return result(points, "support impact").assign(support_stiffness=1e6)


def test_a_hinged_root_rests_and_turns():
    hinged, places = result([0.0, 0.5, 1.0], "support impact"), np.array([0.0, 0.25, 1.0])
    assert moving_points(hinged).tolist() == [1, 2] and places_of_line(hinged, XI, 5)[0] == 0.0
    turned = beam_line(hinged, np.array([0.5, 1.0]), np.array([[1.0, 2.0]]))
    np.testing.assert_allclose(turned(places)[:, 0], 2.0 * places, atol=ROUNDING)


def test_a_clamped_root_is_a_point_of_the_line_and_an_elastic_one_only_if_the_result_holds_it():
    assert moving_points(result([0.0, 0.5, 1.0])).tolist() == [1, 2]
    free = elastic([0.0, 0.5, 1.0])
    assert moving_points(free).tolist() == [0, 1, 2]
    assert places_of_line(result(XI), XI, 5)[0] == 0.0 and places_of_line(free, XI, 5)[0] == 0.2
    straight = beam_line(free, np.array([0.0, 0.5, 1.0]), np.array([[1.0, 2.0, 3.0]]))
    assert straight(np.array([0.25]))[0, 0] == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("effects", "first", "last"),
    [("impact", (1, 0.0), (2, 0.0)), ("tip_support", (1, 0.0), "not-a-knot"), ("support", "not-a-knot", (2, 0.0))],
)
def test_the_line_is_the_spline_of_scipy(effects, first, last):
    places, xi = np.linspace(0.2, 1.0, 37), np.array([0.2, 0.35, 0.4, 0.8, 1.0])
    values = np.cos(np.outer([1.0, 5.0, 9.0], xi))
    x, y = (xi, values.T) if effects == "support" else (np.append(0.0, xi), np.vstack((np.zeros(3), values.T)))
    ends = [end if isinstance(end, str) else (end[0], np.zeros(3)) for end in (first, last)]
    drawn = beam_line(elastic(xi) if effects == "support" else result(xi, effects), xi, values)(places)
    np.testing.assert_allclose(drawn, CubicSpline(x, y, bc_type=tuple(ends))(places), atol=100.0 * ROUNDING)


def test_points_count_once_each_place_and_by_their_place():
    assert moving_points(result([1.0, 0.5, 0.5 + 1e-12, 0.0])).tolist() == [1, 0]
    with pytest.raises(NothingToDraw, match="the root, which is held"):
        moving_points(result([0.0]))


def test_a_form_needs_points_up_to_the_tip():
    many = np.linspace(0.1, 1.0, 10)
    for points in (XI, many * 0.9):
        ds = result(points).assign(displacement=(("point", "time"), np.zeros((points.size, 3))))
        with pytest.raises(NothingToDraw, match="points or more"):
            whole_line(ds, "displacement")
    ds = result(many[::-1]).assign(displacement=(("point", "time"), np.outer(many[::-1], [1.0, 2.0])))
    xi, history = whole_line(ds, "displacement")
    np.testing.assert_array_equal(history, np.outer([1.0, 2.0], xi))
