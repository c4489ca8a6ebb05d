"""OpenSees: elasticBeamColumn elements with consistent mass, stepped by its Newmark integrator.

Its elements do not know the rotating frame. In the plane of rotation the frame adds −ω²ρA v, a spring of negative
stiffness along the beam: one at each node, with the weights of Simpson's rule, which keep the order of the elements.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from . import hermite
from .beam import Problem
from .comparison import Peer, timed

SPRING, ANCHOR = 10_000, 100_000  # tags from here on: springs and the fixed ends of them


@timed
def solve(problem: Problem, elements: int, steps: int) -> np.ndarray:
    """Histories of a mesh of `elements` in `steps` steps."""
    import openseespy.opensees as ops

    build_beam(ops, problem, elements)
    if problem.angular_velocity:
        add_softening(ops, problem, elements)
    give_velocities(ops, problem, elements)
    ops.algorithm("Linear", "-factorOnce")
    return march(ops, problem, elements, steps)


def build_beam(ops: object, problem: Problem, elements: int) -> None:
    """A new model: nodes 0 … elements from the clamp to the tip, which carries the mass; no motion along the beam."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    linear_mass = problem.density * problem.area
    ops.geomTransf("Linear", 1)
    for node in range(elements + 1):
        ops.node(node, node * problem.length / elements, 0.0)
        ops.fix(node, 1, *((1, 1) if node == 0 else (0, 0)))
    for element in range(1, elements + 1):
        ops.element("elasticBeamColumn", element, element - 1, element, problem.area, problem.youngs_modulus,
                    problem.second_moment, 1, "-mass", linear_mass, "-cMass")  # fmt: skip
    ops.mass(elements, 0.0, problem.mass_ratio * linear_mass * problem.length, 0.0)


def add_softening(ops: object, problem: Problem, elements: int) -> None:
    """Springs of −ω² times the mass that each node stands for, the captured one among them."""
    weights = np.where(np.arange(elements + 1) % 2, 4.0, 2.0)
    weights[-1] = 1.0
    masses = weights * (problem.density * problem.area * problem.length / (3 * elements))
    masses[-1] += problem.mass_ratio * problem.density * problem.area * problem.length
    for node in range(1, elements + 1):
        ops.node(ANCHOR + node, node * problem.length / elements, 0.0)
        ops.fix(ANCHOR + node, 1, 1, 1)
        ops.uniaxialMaterial("Elastic", node, -(problem.angular_velocity**2) * float(masses[node]))
        ops.element("zeroLength", SPRING + node, ANCHOR + node, node, "-mat", node, "-dir", 2)


def give_velocities(ops: object, problem: Problem, elements: int) -> None:
    """The beam at rest and the mass at 1 m/s, as the elements can have it."""
    _, mass = hermite.matrices(problem, elements)
    velocity = np.linalg.solve(mass, hermite.starting_momentum(problem, elements))
    for node in range(1, elements + 1):
        for dof, value in zip((2, 3), velocity[2 * node - 2 : 2 * node]):
            ops.setNodeVel(node, dof, float(value), "-commit")


def march(ops: object, problem: Problem, elements: int, steps: int) -> np.ndarray:
    """The histories of all steps of Newmark's method, by the algorithm that was chosen."""
    nodes = [int(xi * elements) for xi in problem.points]
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandSPD")
    ops.integrator("Newmark", 0.5, 0.25)
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "displacement.bin"
        ops.recorder("Node", "-binary", str(path), "-node", *nodes, "-dof", 2, "disp")
        ops.analysis("Transient")
        if ops.analyze(steps, problem.duration / steps) != 0:
            raise RuntimeError("OpenSees did not finish")
        ops.wipe()  # closes the record
        row = np.dtype([("displacement", float, len(problem.points)), ("end", "u1")])
        record = np.fromfile(path, dtype=row)["displacement"].T
    start = np.zeros((len(problem.points), 1))  # the recorder begins after the first step
    return hermite.at_samples(np.hstack([start, record])[:, :steps], problem)


PEER = Peer(
    "OpenSees, Newmark",
    "elasticBeamColumn with consistent mass, springs of −ω² times mass, average acceleration, factored once",
    solve,
    {"elements": (4, 4, 8, 8, 16, 32), "steps": (1 << 12, 1 << 14, 1 << 14, 1 << 16, 1 << 16, 1 << 18)},
    {"elements": (4, 4), "steps": (256, 1024)},
    ("openseespy",),
)
