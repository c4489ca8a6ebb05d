"""What is written stays inside the figure and apart: long legends, many points."""

import numpy as np
import pytest
import synthetic

from beamwave_postproc import dispersion, displacement, measured, open_result, spectrum, velocity_jump
from beamwave_postproc.curves import curves_of, heading
from beamwave_postproc.legend import as_read, broken

SEVEN = {
    "beam_length": [1.0, 2.0],
    "beam_diameter": [0.037, 0.05],
    "beam_density": [7870.0, 2700.0],
    "beam_youngs_modulus": [2e11, 7e10],
    "rotation_angular_velocity": [0.0, 1.0],
    "impact_approach_velocity": [1.0, -1.0],
    "impact_restitution": [0.0, 0.1234],
}
PICTURES = (dispersion, velocity_jump, displacement, spectrum, measured)


@pytest.fixture(scope="module")
def seven(tmp_path_factory):
    """Eight cases that differ in seven inputs."""
    settings = synthetic.scene(
        modes={"before": 3, "after": 3}, response={"duration": 0.1, "samples": 64}, spectrum={"max_peaks": 3}
    )
    path = synthetic.write(tmp_path_factory.mktemp("seven") / "seven.nc", settings, SEVEN)
    with open_result(path) as ds:
        return ds.isel(case=[0, 3, 21, 42, 64, 85, 106, 127]).load()


@pytest.fixture(scope="module")
def many_points(tmp_path_factory):
    settings = synthetic.scene(response={"duration": 0.1, "samples": 64, "points": np.linspace(0.0, 1.0, 100)})
    with open_result(synthetic.write(tmp_path_factory.mktemp("points") / "points.nc", settings)) as ds:
        return ds.load()


@pytest.mark.parametrize("picture", PICTURES)
def test_a_legend_of_seven_inputs_is_inside_the_figure_and_off_the_axes(seven, picture):
    fig = picture(seven)
    fig.draw_without_rendering()
    (legend,) = fig.legends
    box = legend.get_window_extent()
    assert fig.bbox.x0 <= box.x0 and box.x1 <= fig.bbox.x1 and box.y1 <= fig.bbox.y1
    assert all(axes.get_window_extent().y1 <= box.y0 for axes in fig.axes)
    assert min(axes.get_window_extent().height for axes in fig.axes) > 1.5 * fig.dpi


def test_longer_lines_than_the_figure_are_broken(seven):
    long = seven.assign_coords({f"beam_of_a_long_name_{i}": ("case", np.arange(8.0)) for i in range(4)})
    fig = dispersion(long)
    box = fig.legends[0].get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= fig.bbox.x1
    assert "\n" in fig.legends[0].get_texts()[0].get_text()


def test_text_is_broken_after_commas_only():
    text = r"$\omega$ = 0 rad s$^{-1}$, $\gamma$ = 0.2; 8 of 9 cases"
    assert broken(text, 20) == "$\\omega$ = 0 rad s$^{-1}$,\n$\\gamma$ = 0.2;\n8 of 9 cases"
    assert broken(text, 100) == text
    assert as_read(r"$\omega$ = 0 rad s$^{-1}$") == "x = 0 rad s-1"


def test_a_swept_input_that_the_cases_shown_share_is_in_the_title(seven):
    alike = seven.isel(case=[0, 1])
    labels = [curve.label for curve in curves_of(alike)]
    assert all("$l$" not in label for label in labels) and labels[0] != labels[1]
    assert "$l$ = 1 m" in heading(alike)


def test_cases_that_do_not_differ_still_have_names(seven):
    assert all("$l$ = 1 m" in curve.label for curve in curves_of(seven.isel(case=[0, 0])))


@pytest.mark.parametrize("points", [2, 3, 4, 6, 100])
def test_labels_of_neighbouring_panels_do_not_meet(many_points, points):
    shown = many_points.isel(point=np.linspace(0, 99, points).astype(int))
    fig = displacement(shown)
    fig.draw_without_rendering()
    boxes = [axes.yaxis.label.get_window_extent() for axes in fig.axes]
    assert len(boxes) == min(points, 6)
    assert all(upper.y0 > lower.y1 for upper, lower in zip(boxes, boxes[1:]))
    assert ("6 of 100 points" in fig.axes[0].get_title()) == (points == 100)


def test_every_curve_has_a_marker_at_the_tip(paper_results):
    with open_result(paper_results / "fig3.nc") as ds:
        for size in (201, 20, 5, 2):
            xi = np.linspace(0, 200, size).astype(int)
            lines = velocity_jump(ds.isel(profile=xi)).axes[0].lines
            assert all(line.get_markevery()[-1] == size - 1 for line in lines)
            assert all(not line.get_clip_on() for line in lines)
