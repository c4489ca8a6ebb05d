"""What stands above the axes is inside the figure and off the axes: long titles, long legends, many points."""

import numpy as np
import pytest
import synthetic
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from beamwave_postproc import dispersion, displacement, measured, open_result, spectrum, velocity_jump
from beamwave_postproc.film.frames import DPI as FILM_DPI
from beamwave_postproc.parts.head import MARGIN, Head, grow_by_head
from beamwave_postproc.parts.text import broken

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
LONG = "A title of many words, to say all that there is to say about a beam that is struck, and is then struck again"


@pytest.fixture(scope="module")
def seven(tmp_path_factory):
    """Eight cases that differ in seven inputs."""
    settings = synthetic.scene(
        modes={"before": 3, "after": 3}, response={"duration": 0.1, "samples": 64}, spectrum={"max_peaks": 3}
    )
    path = synthetic.write(tmp_path_factory.mktemp("seven") / "seven.nc", settings, SEVEN, title=LONG)
    with open_result(path) as ds:
        return ds.isel(case=[0, 3, 21, 42, 64, 85, 106, 127]).load()


@pytest.fixture(scope="module")
def many_points(tmp_path_factory):
    settings = synthetic.scene(response={"duration": 0.1, "samples": 64, "points": np.linspace(0.01, 1.0, 100)})
    with open_result(synthetic.write(tmp_path_factory.mktemp("points") / "points.nc", settings)) as ds:
        return ds.load()


@pytest.mark.parametrize("picture", PICTURES)
def test_title_inputs_and_a_legend_of_seven_inputs_are_inside_the_figure_and_off_the_axes(seven, picture):
    fig = picture(seven)
    fig.draw_without_rendering()
    boxes = [artist.get_window_extent() for artist in (*fig.texts, *fig.legends)]
    for box in boxes:
        assert fig.bbox.x0 <= box.x0 and box.x1 <= fig.bbox.x1 and fig.bbox.y0 <= box.y0 and box.y1 <= fig.bbox.y1
        assert all(axes.get_tightbbox().y1 <= box.y0 for axes in fig.axes)
    assert all(upper.y0 >= lower.y1 for upper, lower in zip(boxes, boxes[1:]))
    assert min(axes.get_window_extent().height for axes in fig.axes) > 1.3 * fig.dpi


def test_longer_lines_than_the_figure_are_broken(seven):
    long = seven.assign_coords({f"beam_of_a_long_name_{i}": ("case", np.arange(8.0)) for i in range(4)})
    fig = dispersion(long)
    box = fig.legends[0].get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= fig.bbox.x1
    assert "\n" in fig.legends[0].get_texts()[0].get_text()
    assert fig.texts[0].get_text().replace("\n", " ") == LONG and "\n" in fig.texts[0].get_text()


def test_lines_break_at_blanks_outside_formulas_and_fit(many_points):
    fig = dispersion(many_points)
    text = r"$\omega = 0$ rad/s, $\gamma = 0.2$; $a\ b$ and words and more words"
    for width in (1.0, 2.0, 3.0):
        lines = broken(text, width, fontsize=9).split("\n")
        assert " ".join(lines) == text and all(line.count("$") % 2 == 0 for line in lines)
    assert broken(text, 100.0, fontsize=9) == text


def test_the_axes_keep_their_height_whatever_the_head_holds(full_result):
    with open_result(full_result) as ds:
        heights = []
        for title in ("short", LONG):
            fig = dispersion(ds.assign_attrs(title=title))
            fig.draw_without_rendering()
            heights.append(fig.axes[0].get_window_extent().height)
            assert fig.texts[0].get_window_extent().x0 == pytest.approx(MARGIN * fig.dpi, abs=2.0)
    # The same inches of figure are left for the axes; a pixel may fall to either side.
    assert heights[0] == pytest.approx(heights[1], abs=2.0)


@pytest.mark.parametrize("points", [2, 3, 4, 6, 100])
def test_labels_of_neighbouring_panels_do_not_meet(many_points, points):
    shown = many_points.isel(point=np.linspace(0, 99, points).astype(int))
    fig = displacement(shown)
    fig.draw_without_rendering()
    boxes = [axes.yaxis.label.get_window_extent() for axes in fig.axes]
    assert len(boxes) == min(points, 6)
    assert all(upper.y0 > lower.y1 for upper, lower in zip(boxes, boxes[1:]))
    assert any("6 of 100 points" in text.get_text() for text in fig.texts) == (points == 100)


def test_lines_of_a_film_are_inside_it_though_its_dots_are_coarse():
    for count in range(60, 160):
        fig = Figure(figsize=(8.6, 3.0), dpi=FILM_DPI)
        FigureCanvasAgg(fig)
        grow_by_head(fig, Head("", [f"{'ω = 50 rad/s; ' * 20}"[:count]]))
        assert fig.texts[0].get_window_extent().x1 < fig.bbox.x1
