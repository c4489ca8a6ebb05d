"""Long histories: a band that loses no extreme, only where a line would be a blob."""

import numpy as np
from matplotlib.figure import Figure

from beamwave_postproc.parts.envelope import draw_envelope, is_dense

TIME = np.arange(65536) / 65536.0


def test_only_what_a_line_would_fill_is_dense():
    assert is_dense(np.sin(2 * np.pi * 9000.0 * TIME))
    assert not is_dense(np.sin(2 * np.pi * 20.0 * TIME))
    assert not is_dense(np.sin(2 * np.pi * 20.0 * TIME) + 1e-3 * np.sin(2 * np.pi * 9000.0 * TIME))
    assert not is_dense(np.sin(2 * np.pi * 200.0 * np.arange(1000) / 1000.0))
    assert not is_dense(np.zeros(65536))


def test_the_band_holds_every_extreme_and_the_line_the_slow_motion():
    slow = np.sin(2 * np.pi * 2.0 * TIME)
    history = slow + 0.5 * np.sin(2 * np.pi * 9000.0 * TIME)
    history[40000] = 7.0
    axes = Figure().subplots()
    words = draw_envelope(axes, TIME, history, colour="k")
    (band,), (line,) = axes.collections, axes.lines
    edges = band.get_paths()[0].vertices[:, 1]
    assert edges.max() == 7.0 and edges.min() == history.min()
    # The mean of 109 samples, nearly 15 periods of the fast motion, and of the slow one over a 600th of the record.
    np.testing.assert_allclose(line.get_ydata(), np.interp(line.get_xdata(), TIME, slow), atol=0.1)
    assert "600 intervals" in words
