"""Words that have no room, axes that stand beside each other as far as there is width, and numbers as many as have room."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from beamwave_postproc.parts.crowding import MM, is_crowded, sufficient_size
from beamwave_postproc.parts.sheet import columns_for, new_figure, of_size
from beamwave_postproc.style import label_decades


def beside(width: float, words: str = "", count: int = 2) -> Figure:
    """So many axes side by side, each with a title."""
    fig = new_figure(width, 2.0)
    for axes in fig.subplots(1, count, squeeze=False).ravel():
        axes.set_title(words)
    return fig


@pytest.mark.parametrize(("words", "crowded"), [("short", False), ("a title as long as three inches are wide " * 2, True)])
def test_titles_that_meet_are_crowded(words, crowded):
    assert is_crowded(beside(6.0, words)) is crowded


def test_numbers_that_meet_are_crowded():
    fig = beside(3.0, count=1)
    fig.axes[0].set_xticks(np.linspace(0.0, 1.0, 5))
    assert not is_crowded(fig)
    fig.axes[0].set_xticks(np.linspace(0.0, 1.0, 25))
    assert is_crowded(fig)


def test_axes_without_any_room_are_crowded():
    assert is_crowded(beside(1.0, count=6))


def test_a_size_is_found_at_which_the_words_have_room_and_the_figure_keeps_its_own():
    fig = beside(4.0, "a title that is longer than two inches")
    wide, high = sufficient_size(fig, 0.5)
    assert tuple(fig.get_size_inches()) == (4.0, 2.0) and wide > 4.0 and high == 55.0 / MM  # no height helps
    assert sufficient_size(beside(wide, "short"), 0.5) == (wide, 2.0)


def test_of_sizes_that_suffice_the_least_height_at_the_width_that_is_given_is_named():
    def stacked(height: float) -> Figure:
        """Eight axes below each other in a column, of this height in mm."""
        fig = new_figure(90.0 / MM, height / MM)
        for axes in fig.subplots(8, 1):
            axes.set(xlabel="abscissa", title="title")
        return fig

    wide, high = (round(MM * length) for length in sufficient_size(stacked(120.0), 0.0))
    assert wide == 90 and high > 120
    assert not is_crowded(stacked(high)) and (is_crowded(stacked(high - 5.0)) or high <= 8 * 0.9 * MM + 5.0)


@pytest.mark.parametrize(("width", "columns"), [(None, 2), (6.7, 2), (3.3, 1), (1.6, 1)])
def test_axes_stand_below_each_other_where_the_width_that_is_given_is_too_small(width, columns):
    with of_size(width and (width, 4.0)):
        assert columns_for(5) == columns and columns_for(1) == 1


@pytest.mark.parametrize(("inches", "within"), [(6.0, [1, 2, 5, 10, 20, 50, 100]), (2.4, [1, 10, 100])])
def test_numbers_between_decades_are_left_out_where_they_have_no_room(inches, within):
    fig = beside(inches, count=1)
    (axes,) = fig.axes
    axes.set(xscale="log", xlim=(1.0, 100.0))
    label_decades(axes.xaxis, 1.0, 100.0)
    fig.draw_without_rendering()
    ticks = axes.xaxis.get_majorticklocs()
    assert list(ticks[(ticks >= 1.0) & (ticks <= 100.0)]) == pytest.approx(within)
