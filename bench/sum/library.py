"""beamwave's layers as a library: the whole job, the modes alone, the sum alone. Without dimensions, as in rival.py."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

GAMMA, DURATION = 0.2, 46.63  # about a second of the paper's beam

double = ctypes.c_double


def address(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


class Beamwave:
    """bench_sum.f90 of a build."""

    def __init__(self, build: Path) -> None:
        found = sorted(build.glob("bench/sum/libbench_sum.*"))
        if not found:
            raise SystemExit(f"no libbench_sum in {build}: cmake --build {build} --target bench_sum")
        self.library = ctypes.CDLL(str(found[0].resolve()))

    def job(self, n: int, samples: int) -> np.ndarray:
        """Roots, shapes at midpoint and tip, and their sum, as a run with a tolerance makes it."""
        result = np.empty((2, samples))
        self.library.bench_whole_job(n, samples, double(GAMMA), double(DURATION), address(result))
        return result

    def terms(self, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The modes: frequencies in two parts, modal velocities, shapes at both points."""
        beta, rate, shapes = np.empty((n, 2)), np.empty(n), np.empty((2, n))
        self.library.bench_terms(n, double(GAMMA), double(DURATION), address(beta), address(rate), address(shapes))
        return beta, rate, shapes

    def choice(self, n: int, samples: int, points: int) -> tuple[bool, int, int]:
        """Whether the cost model chooses the transform, and the kernel's width and half the grid that it would take."""
        chosen = [ctypes.c_int() for _ in range(3)]
        self.library.bench_choice(n, samples, points, *map(ctypes.byref, chosen))
        return bool(chosen[0].value), chosen[1].value, chosen[2].value

    def by_transform(self, samples: int, terms: tuple, width: int, half: int) -> np.ndarray:
        """With a given kernel and grid, for as many points as there are shapes."""
        beta, rate, shapes = terms
        result = np.empty((len(shapes), samples))
        places = [address(array) for array in (beta, rate, shapes)]
        self.library.bench_by_transform(len(rate), samples, len(shapes), *places, double(DURATION), width, half, address(result))
        return result

    def by_products(self, samples: int, terms: tuple) -> np.ndarray:
        beta, rate, shapes = terms
        result = np.empty((len(shapes), samples))
        places = [address(array) for array in (beta, rate, shapes)]
        self.library.bench_by_products(len(rate), samples, len(shapes), *places, double(DURATION), address(result))
        return result

    def sum(self, samples: int, terms: tuple) -> np.ndarray:
        """Modes that are known, by the transform."""
        return self.by_transform(samples, terms, *self.choice(len(terms[1]), samples, len(terms[2]))[1:])
