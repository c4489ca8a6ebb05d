"""A round beam on a hub that is free to turn, by an own method of Ritz.

Unknowns are the hub's turn and the coefficients of Legendre polynomials in v'' on each part of the beam, integrated twice from the root: the
stiffness without tension is then nearly diagonal, and low modes keep all digits. A rigid turn costs nothing (theory of bw_static_shape), so that
it is taken out of the mass before the others are found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre
from scipy.linalg import eigh

PER_LENGTH = 7870 * np.pi / 4 * 0.037**2  # of the paper's beam, kg/m, whose length is 1 m
STIFFNESS = 2e11 * np.pi / 64 * 0.037**4


@dataclass
class HubBeam:
    inertia: float
    radius: float
    omega: float = 0.0  # in plane, with tension
    bodies: tuple[tuple[float, float], ...] = ()  # place, mass
    cuts: tuple[float, ...] = ()
    degree: int = 24  # of v'' on each part

    def __post_init__(self) -> None:
        self.ends = [0.0, *self.cuts, 1.0]
        node, weight = np.polynomial.legendre.leggauss(2 * self.degree + 10)
        parts = list(zip(self.ends[:-1], self.ends[1:], strict=True))
        x = np.concatenate([a + (b - a) * (node + 1) / 2 for a, b in parts])
        w = np.concatenate([weight / 2 * (b - a) for a, b in parts])
        arm, value, slope, bend = self.radius + x, self.basis(x), self.basis(x, 1), self.basis(x, 2)
        pull = PER_LENGTH * ((1 - x) * self.radius + (1 - x**2) / 2)
        self.mass = np.zeros((len(value) + 1, len(value) + 1))
        rows = np.vstack([arm, value])
        self.mass += PER_LENGTH * (rows * w) @ rows.T
        for place, body in self.bodies:
            row = np.append(self.radius + place, self.basis([place])[:, 0])
            self.mass += body * np.outer(row, row)
            pull += body * (self.radius + place) * (x < place)
        self.mass[0, 0] += self.inertia
        self.stiffness = STIFFNESS * (bend * w) @ bend.T + self.omega**2 * ((slope * w * pull) @ slope.T - self.mass[1:, 1:])

    def basis(self, x: np.ndarray | list[float], order: int = 0) -> np.ndarray:
        """Functions or their derivatives at places, (functions, places); derivatives at a cut are those of the inner side."""
        x, rows = np.asarray(x, dtype=float), []
        for a, b in zip(self.ends[:-1], self.ends[1:], strict=True):
            inside, past = (x > a) & (x <= b) | (x == a) & (a == 0), x > b
            for j in range(self.degree + 1):
                bend = Legendre.basis(j, [a, b]) * np.sqrt((2 * j + 1) / (b - a))
                slope = bend.integ(lbnd=a)
                deflection = slope.integ(lbnd=a)
                beyond = (deflection(b) + slope(b) * (x - b), slope(b) + 0 * x, 0 * x)[order]
                rows.append(np.where(inside, (deflection, slope, bend)[order](x), np.where(past, beyond, 0.0)))
        return np.array(rows)

    def modes(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Squares of the frequencies, the first of which is 0, and modes of mass 1, (unknowns, modes)."""
        turning, coupling = self.mass[0, 0], self.mass[0, 1:]
        soft, vector = eigh(self.mass[1:, 1:] - np.outer(coupling, coupling) / turning, self.stiffness)
        square, vector = 1 / soft[: -count : -1], vector[:, : -count : -1]
        vector = vector * np.sqrt(square)
        turns = np.append(1 / np.sqrt(turning), -coupling @ vector / turning)
        return np.append(0.0, square), np.vstack([turns, np.hstack([np.zeros((len(vector), 1)), vector])])

    def motion(self, place: float) -> np.ndarray:
        """Of a place in the frame, by each unknown."""
        return np.append(self.radius + place, self.basis([place])[:, 0])

    def from_line(self, place: float, order: int = 0) -> np.ndarray:
        """Deflection of a place from the hub's line, or its derivatives."""
        return np.append(0.0, self.basis([place], order)[:, 0])


def section(beam: HubBeam, place: float) -> np.ndarray:
    """Mass times motion of what lies beyond a place, by each unknown."""
    total = 0.0
    ends = [place, *(cut for cut in beam.ends if cut > place)]
    for a, b in zip(ends[:-1], ends[1:], strict=True):
        node, weight = np.polynomial.legendre.leggauss(60)
        x = a + (b - a) * (node + 1) / 2
        total = total + PER_LENGTH * np.vstack([beam.radius + x, beam.basis(x)]) @ (weight / 2 * (b - a))
    for at, mass in beam.bodies:
        if at >= place:
            total = total + mass * beam.motion(at)
    return total + np.zeros(len(beam.mass))


def half_sine(square: float, time: np.ndarray, amplitude: float, length: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Displacement, velocity and acceleration of u'' + square u = f."""
    w, beta = np.pi / length, np.sqrt(square)
    during = time <= length
    load = np.where(during, amplitude * np.sin(w * time), 0.0)

    def forced(t):
        if beta == 0:
            return amplitude * (t / w - np.sin(w * t) / w**2), amplitude * (1 - np.cos(w * t)) / w
        far = amplitude / (square - w**2)
        return far * (np.sin(w * t) - w / beta * np.sin(beta * t)), far * w * (np.cos(w * t) - np.cos(beta * t))

    (u, v), (end, rate), after = forced(time), forced(length), np.maximum(time - length, 0)
    ring = np.sin(beta * after) / beta if beta else after
    u = np.where(during, u, end * np.cos(beta * after) + rate * ring)
    v = np.where(during, v, rate * np.cos(beta * after) - square * end * ring)
    return u, v, load - square * u
