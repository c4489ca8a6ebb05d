"""Events on a time axis: lines, spans, and words that stand above the axes."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from beamwave_postproc import displacement, open_result
from beamwave_postproc.parts.events import lanes_note, mark_events

IMPACT, CAPTURE, CONTACT = 1.0, 2.0, 4.0


def with_events(ds, *events):
    """The result with these events: (time, end, kind)."""
    columns = dict(zip(("event_time", "event_end", "event_kind"), np.array(events, dtype=float).T))
    columns = {name: ("event", column, ds["event_kind"].attrs) for name, column in columns.items()}
    return ds.drop_vars(["event", *columns, "event_impulse"]).assign(columns)


def marks(axes):
    """Times of the lines, and begin and end of the spans, in the axes' unit."""
    lines = [a.get_xdata()[0] for a in axes.lines if isinstance(a, Line2D) and list(a.get_ydata()) == [0.0, 1.0]]
    spans = [(a.get_x(), a.get_x() + a.get_width()) for a in axes.patches if isinstance(a, Rectangle)]
    return lines, spans


def test_each_kind_of_event_is_named_once(full_result):
    with open_result(full_result) as ds:
        assert [text.get_text() for text in displacement(ds).axes[0].texts] == ["impact, capture"]
        axes = displacement(with_events(ds, (0, 0, IMPACT), (0.25, 0.25, CONTACT), (0.5, 0.5, CONTACT))).axes[0]
    assert marks(axes) == ([0.0, 0.25, 0.5], [])
    assert [text.get_text() for text in axes.texts] == ["impact", "2 contacts"]


def test_a_contact_that_lasts_is_a_span_also_to_the_end_of_the_record(full_result):
    with open_result(full_result) as ds:
        axes = displacement(with_events(ds, (0, 0, IMPACT), (0.25, 0.5, CONTACT), (0.75, np.nan, CONTACT))).axes[0]
    assert marks(axes)[1] == [(0.25, 0.5), (0.75, pytest.approx(1.0))]
    assert [text.get_text() for text in axes.texts] == ["impact", "2 contacts (lasting)"]


def test_many_contacts_in_little_time_are_one_name_with_their_number(full_result):
    many = [(0.01 + 1e-5 * i, 0.01 + 1e-5 * i, CONTACT) for i in range(30)] + [(0.011, 0.02, CONTACT)]
    with open_result(full_result) as ds:
        axes = displacement(with_events(ds, (0, 0, IMPACT), *many)).axes[0]
    assert [text.get_text() for text in axes.texts] == ["impact", "31 contacts (1 lasting)"]
    assert len(marks(axes)[0]) == 32


def test_words_stand_above_the_axes_and_apart(full_result):
    with open_result(full_result) as ds:
        fig = displacement(with_events(ds, (0, 0, IMPACT), (0.01, 0.01, CAPTURE), (0.02, 0.3, CONTACT)))
    fig.draw_without_rendering()
    axes = fig.axes[0]
    boxes = [word.get_window_extent() for word in axes.texts]
    assert len(boxes) == 3 and all(box.y0 >= axes.get_window_extent().y1 for box in boxes)
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])


def test_an_event_that_the_picture_does_not_reach_is_not_marked(full_result):
    with open_result(full_result) as ds:
        part = with_events(ds, (0, 0, IMPACT), (0.5, 0.5, CONTACT)).sel(time=slice(0.0, 0.1))
        assert marks(displacement(part).axes[0])[0] == [0.0]


def test_a_result_without_events_has_a_history_without_marks(full_result):
    with open_result(full_result) as ds:
        axes = displacement(ds.drop_vars(["event_time", "event_kind"])).axes[0]
    assert marks(axes) == ([], []) and not axes.texts


def test_contacts_that_differ_between_cases_have_the_colours_of_their_cases():
    kinds = {"flag_values": [1, 4], "flag_meanings": "impact contact"}

    def case(begin, end):
        times = {"event_time": ("event", [0.0, begin]), "event_end": ("event", [0.0, end])}
        return xr.Dataset({**times, "event_kind": ("event", [1.0, 4.0], kinds)})

    cases = [case(0.1, 0.3), case(0.2, 0.4), case(0.5, 0.5)]
    top, below = Figure().subplots(2)
    for axes in (top, below):
        mark_events(axes, cases, 1.0, words=axes is top, colours=("red", "green", "blue"))
    assert marks(top) == ([0.0], []) and marks(below) == ([0.0], [])  # the impact, which all share
    bars = [line for line in top.lines if list(line.get_ydata()) == [1.0, 1.0]]
    assert [list(bar.get_xdata()) for bar in bars] == [[0.1, 0.3], [0.2, 0.4], [0.5, 0.5]]
    assert [to_rgb(bar.get_color()) for bar in bars] == [to_rgb(colour) for colour in ("red", "green", "blue")]
    heights = [bar.get_window_extent().y0 for bar in bars]
    assert heights[0] > heights[1] > heights[2] > top.get_window_extent().y1  # the order of the legend
    assert len(below.lines) == 1
    assert lanes_note(cases) == "contacts of each case above the axes" and not lanes_note(cases[:1])
