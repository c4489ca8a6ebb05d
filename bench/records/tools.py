"""The tools of the comparison: what each is asked, and what it answers."""

from __future__ import annotations

import importlib.util
import logging
import resource
import shutil
import subprocess
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from common.measuring import run_scene
from scipy.linalg import eigh, svd

from .cells import SPACED, Cell, Draw, lines_of

FILES = 500  # of a scene
HALF_BAND = 0.03  # periods per step, either side of a line that harminv looks for
OPTIONS = ("-f", "4", "-d", "1", "-Q", "1")  # as many functions as bins, strong damping allowed: the least error in a trial
QUANTILE = 1.96
BLOCK_ROWS, BLOCK_ROWS_OF_MANY = 100, 10  # of one sensor and of many: what can be waited for
BLOCKS = 10  # of the record, from which the uncertainty is taken
LIMITS = {"xi_max": 1.0, "mpc_lim": None, "mpd_lim": None, "CoV_max": None}  # nothing of the order asked for is thrown away


@dataclass(frozen=True)
class Lines:
    """Lines that a tool reports of one record, in periods and e-folds per step; half widths of 95 % intervals if it has any."""

    frequencies: np.ndarray
    decays: np.ndarray
    frequency_errors: np.ndarray | None = None
    decay_errors: np.ndarray | None = None


@dataclass(frozen=True)
class Tool:
    """A tool of the comparison."""

    name: str
    told: str  # what it is told beyond the record
    estimate: Callable[[Cell, list[Draw]], tuple[list[Lines], float]]  # CPU seconds of all
    refuses: Callable[[Cell], str] = lambda cell: ""  # why it cannot do such records
    needs: tuple[str, ...] = ()  # Python packages
    command: str = ""  # a command
    slow: bool = False  # tries the few draws of a cell

    def missing(self) -> str:
        """What is not installed."""
        if self.command and not shutil.which(self.command):
            return f"the command {self.command}"
        return ", ".join(name for name in self.needs if importlib.util.find_spec(name) is None)


def only_even(cell: Cell) -> str:
    """Why not, of a tool that knows no times."""
    return "takes even times alone" if cell.uneven else ""


def one_even_sensor(cell: Cell) -> str:
    """Why not, of a tool that takes one history."""
    return only_even(cell) or ("takes one sensor" if cell.sensors > 1 else "")


def of_each(lines_in: Callable[[Cell, Draw], Lines]) -> Callable[[Cell, list[Draw]], tuple[list[Lines], float]]:
    """What estimates one record after the other in this process, with its CPU seconds."""

    def estimate(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
        start = time.process_time()
        found = [lines_in(cell, draw) for draw in draws]
        return found, time.process_time() - start

    return estimate


def by_beamwave(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
    """The program as a user calls it: every draw a case; the seconds are those of whole processes with all their files."""
    found: list[Lines] = []
    seconds = 0.0
    for first in range(0, len(draws), FILES):
        with tempfile.TemporaryDirectory() as name:
            directory = Path(name)
            some = draws[first : first + FILES]
            for number, draw in enumerate(some):
                write_record(directory / f"{number}.csv", draw.times, draw.values)
            files = ",\n  ".join(f"'{number}.csv'" for number in range(len(some)))
            scene = f"&record\n  file = {files}\n/\n&spectrum /\n"
            seconds += run_scene(directory, scene, accepted=(0, 4)).seconds
            found += read(directory / "scene.nc")
    return found, seconds


def write_record(path: Path, times: np.ndarray, values: np.ndarray) -> None:
    """A record as CSV."""
    head = ",".join(["t", *(f"s{sensor}" for sensor in range(values.shape[1]))])
    np.savetxt(path, np.column_stack([times, values]), "%.17g", ",", header=head, comments="")


def read(result: Path) -> list[Lines]:
    """Lines of each case; a step is a second."""
    from netCDF4 import Dataset

    names = [f"measured_{what}{part}" for part in ("", "_error") for what in ("angular_frequency", "decay_rate")]
    with Dataset(result) as data:
        rows = [np.atleast_2d(np.ma.filled(data[name][:].astype(float), np.nan)) for name in names]
        counts = np.atleast_1d(np.ma.filled(data["peak_count"][:], 0))
    scale = (2 * np.pi, 1, 2 * np.pi, 1)
    return [Lines(*(row[case, :count] / unit for row, unit in zip(rows, scale))) for case, count in enumerate(counts)]


@of_each
def by_esprit(cell: Cell, draw: Draw) -> Lines:
    """Plain ESPRIT: the signal's subspace of a Hankel matrix of all sensors, and the shift within it by total least squares.

    Two thirds of the record are the matrix's columns, as is best for one line.
    """
    order, samples = 2 * lines_of(cell), len(draw.values)
    rows = samples // 3
    blocks = [np.lib.stride_tricks.sliding_window_view(column, samples - rows + 1) for column in draw.values.T]
    gram = sum(block @ block.T for block in blocks)
    _, space = eigh(gram, subset_by_index=(rows - order, rows - 1))
    _, _, right = svd(np.hstack([space[:-1], space[1:]]), full_matrices=False)
    upper, lower = right.T[:order, order:], right.T[order:, order:]
    poles = np.linalg.eigvals(-upper @ np.linalg.inv(lower))
    poles = poles[poles.imag > 0]
    return Lines(np.angle(poles) / (2 * np.pi), -np.log(np.abs(poles)))


@of_each
def by_hlsvd(cell: Cell, draw: Draw) -> Lines:
    """HLSVDPROPY: the state space of a Hankel matrix of one complex history; of conjugate lines the one with positive frequency."""
    from hlsvdpropy import hlsvdpro

    answer = hlsvdpro(draw.values[:, 0].astype(complex), 2 * lines_of(cell), m=cell.samples // 2)
    frequencies, decays = np.asarray(answer[2]), -np.asarray(answer[3])
    upper = frequencies > 0
    return Lines(frequencies[upper], decays[upper])


def by_harminv(cell: Cell, draws: list[Draw]) -> tuple[list[Lines], float]:
    """harminv, filter diagonalisation: one call for each record, with a band around each place where lines are."""
    places = SPACED if not cell.near and len(cell.decays) == len(SPACED) else SPACED[1:2]
    command = ["harminv", *OPTIONS, *(f"{place - HALF_BAND:g}-{place + HALF_BAND:g}" for place in places)]
    start = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = []
    for draw in draws:
        text = "\n".join(map(repr, draw.values[:, 0].tolist()))
        said = subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout
        rows = [[float(number) for number in line.split(",")[:2]] for line in said.splitlines()[1:]]
        found.append(Lines(*np.array(rows).reshape(-1, 2).T))  # frequency, decay constant of the amplitude
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    return found, end.ru_utime + end.ru_stime - start.ru_utime - start.ru_stime


@of_each
def by_pyoma(cell: Cell, draw: Draw) -> Lines:
    """pyOMA-2: stochastic subspace identification, with the uncertainty that its documents call experimental."""
    logging.disable(logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return subspace_lines(draw.values, 2 * lines_of(cell))


def subspace_lines(values: np.ndarray, order: int) -> Lines:
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


TOOLS = (
    Tool("beamwave", "nothing", by_beamwave, needs=("netCDF4",)),
    Tool("plain ESPRIT", "the number of lines", by_esprit, only_even, ("scipy",)),
    Tool("hlsvdpropy", "the number of lines", by_hlsvd, one_even_sensor, ("hlsvdpropy",), slow=True),
    Tool("harminv", "a band around each line", by_harminv, one_even_sensor, command="harminv"),
    Tool("pyOMA-2 (SSI)", "the number of lines", by_pyoma, only_even, ("pyoma2",), slow=True),
)
