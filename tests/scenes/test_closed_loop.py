"""Random beams are struck, and identified from their noisy histories: the true numbers are inside the intervals as often as these
say. `closed_loop.py` draws more beams, by hand."""

import closed_loop
import numpy as np

BEAMS = closed_loop.ROUND_OF_KINDS


def test_true_numbers_are_inside_their_intervals(here):
    beams = closed_loop.identify(here, BEAMS, seed=19)
    inside = np.concatenate([closed_loop.is_inside(beam) for beam in beams])
    # unknowns of a beam err together, two or three of them: the deviation of the share is that of so many fewer
    assert abs(inside.mean() - 0.95) < 3.3 * np.sqrt(0.05 * 0.95 * 2.5 / inside.size)
    assert np.mean([beam["result"]["misfit_probability"] > 1e-3 for beam in beams]) > 0.9
