"""The layout of figures: where matplotlib puts the axes, found in fewer steps."""

import numpy as np
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from beamwave_postproc.parts.layout import Layout


def drawn(layout):
    """A figure with long numbers, a logarithmic axis and a colour bar, after it was drawn with this layout."""
    fig = Figure(figsize=(6.0, 4.0), layout=layout)
    FigureCanvasAgg(fig)
    axes = fig.subplots(2, 2, sharex="col")
    axes[0, 0].plot([0.0, 123456.0], [1e-7, 2e-7])
    axes[1, 0].loglog([1.0, 1e5], [1e-3, 1e4])
    axes[0, 1].set(xlabel="time", ylabel="words in\ntwo lines", title="title")
    fig.colorbar(axes[1, 1].pcolormesh(np.arange(12.0).reshape(3, 4)), ax=axes[1, 1], label="numbers")
    fig.canvas.draw()
    return fig


def test_axes_lie_where_matplotlib_puts_them_and_ticks_are_looked_for_less_often(monkeypatch):
    asked = []
    find = Axis._update_ticks
    monkeypatch.setattr(Axis, "_update_ticks", lambda axis: asked.append(axis) or find(axis))
    theirs = drawn("constrained")
    often = len(asked)
    ours = drawn(Layout())
    for one, other in zip(ours.axes, theirs.axes):
        assert one.get_position().bounds == other.get_position().bounds
    assert np.array_equal(ours.canvas.buffer_rgba(), theirs.canvas.buffer_rgba())
    assert len(asked) - often < 0.6 * often  # once for each place; the drawing that follows asks as it did
    assert not any("_update_ticks" in vars(axes.xaxis) for axes in ours.axes)
