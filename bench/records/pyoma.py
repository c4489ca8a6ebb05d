"""pyOMA-2: stochastic subspace identification, with the uncertainty that its documents call experimental."""

from __future__ import annotations

import logging
import time
import warnings
from dataclasses import replace

import numpy as np

from .cells import Cell, Draw, lines_of
from .tool import Lines, Tool, only_even

QUANTILE = 1.96
BLOCK_ROWS, BLOCK_ROWS_OF_MANY = 100, 10  # of one sensor and of many: what can be waited for
BLOCKS = 10  # of the record, from which the uncertainty is taken
LIMITS = {"xi_max": 1.0, "mpc_lim": None, "mpd_lim": None, "CoV_max": None}  # nothing of the order asked for is thrown away


def estimate(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
    """One record after the other."""
    logging.disable(logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        start = time.process_time()
        found = [lines(draw.values, 2 * lines_of(cell)) for draw in draws]
        return found, time.process_time() - start


def lines(values: np.ndarray, order: int) -> Lines:
    """Lines of the model of that order."""
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup

    one = values.shape[1] == 1  # the uncertainty of 64 sensors takes minutes a record
    rows = BLOCK_ROWS if one else BLOCK_ROWS_OF_MANY
    setup = SingleSetup(values, fs=1.0)
    setup.add_algorithms(SSI(name="ssi", method="cov", br=rows, ordmax=order, calc_unc=one, nb=BLOCKS, hc=LIMITS))
    setup.run_all()
    answer = setup["ssi"].result
    poles = answer.Lambds[:, -1]
    upper = np.isfinite(poles) & (poles.imag > 0)
    found = Lines(poles[upper].imag / (2 * np.pi), -poles[upper].real)
    if not one:
        return found
    errors = [QUANTILE * np.asarray(all_of[:, -1])[upper] for all_of in (answer.Fn_poles_std, answer.Xi_poles_std)]
    return replace(found, frequency_errors=errors[0], decay_errors=np.abs(poles[upper]) * errors[1])


TOOL = Tool("pyOMA-2 (SSI)", "the number of lines", estimate, only_even, ("pyoma2",), slow=True)
