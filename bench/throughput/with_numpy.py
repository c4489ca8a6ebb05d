"""A case in numpy, every step over all modes at once: roots by Newton's method from asymptotic starts, shapes in exponentials
that do not overflow (`peers/beam.py`), integrals by Gauss's rule with nodes that are made once, histories by one matrix product,
or by products of short tables of sines (the addition theorem)."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from peers.beam import roots, shapes
from peers.sums import sum_of_sines

from .jobs import DENSITY, DIAMETER, LENGTH, MODULUS, POINTS, Job

NODES = 96
RADIUS_OF_GYRATION = DIAMETER / 4
H = np.sqrt(MODULUS / DENSITY) * RADIUS_OF_GYRATION

Case = dict[str, Any]


@cache
def gauss() -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    return 0.5 * (nodes + 1.0), 0.5 * weights


@cache
def free_beam(modes: int) -> tuple[np.ndarray, np.ndarray]:
    """Shapes before the capture at the nodes and at the tip, which all cases share."""
    alpha = roots(modes, 0.0)
    return shapes(alpha, gauss()[0]).T, shapes(alpha, 1.0)


def case(job: Job, speed: float, gamma: float, by_products: bool = False) -> Case:
    """Everything that the job asks for."""
    alpha = roots(job.modes, gamma)
    p = alpha / LENGTH
    natural = H * p**2
    squared = natural**2 - speed**2
    beta = np.sqrt(squared)
    places, weights = gauss()
    at_nodes, at_tip = shapes(alpha, places).T, shapes(alpha, 1.0)
    mass = at_nodes**2 @ weights + gamma * at_tip**2
    free_nodes, free_tip = free_beam(job.modes)
    jump = free_tip / (1.0 / gamma + free_tip @ free_tip)  # per approach velocity; ∫φ² = 1
    velocity = (at_nodes @ (weights * (jump @ free_nodes)) + gamma * at_tip * (jump @ free_tip)) / mass
    result = {"angular_frequency": beta, "phase_velocity": beta / p, "group_velocity": 2.0 * H * natural * p / beta}
    if job.samples:
        step = job.duration / job.samples
        weights = shapes(alpha, np.array(POINTS)) * (velocity / beta)
        if by_products:
            result["displacement"] = sum_of_sines(weights, beta, job.samples, step)
        else:
            result["displacement"] = weights @ np.sin(np.outer(beta, np.arange(job.samples) * step))
    if job.spectrum:
        window = np.hanning(job.samples + 1)[:-1]
        result["amplitude"] = np.abs(np.fft.rfft(result["displacement"] * window)) * (2.0 / window.sum())
        result["amplitude"][:, [0, -1]] /= 2.0  # these two have no mirror image beside them
    return result


def loop(job: Job, grid: list[tuple[float, float]], by_products: bool = False) -> list[Case]:
    """All cases, one after another."""
    return [case(job, speed, gamma, by_products) for speed, gamma in grid]


def save(cases: list[Case], path: Path) -> None:
    """All cases in a file, as the program leaves them: each value an array over the cases."""
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("case", len(cases))
        for name, value in cases[0].items():
            dimensions = [f"{name}_{axis}" for axis in range(value.ndim)]
            for dimension, length in zip(dimensions, value.shape):
                file.createDimension(dimension, length)
            file.createVariable(name, "f8", ("case", *dimensions))[:] = np.array([case[name] for case in cases])
