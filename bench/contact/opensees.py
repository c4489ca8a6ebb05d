"""OpenSees: the mass is a node of its own, and a zeroLength element of the material ENT, elastic without tension, is the stop."""

from __future__ import annotations

import numpy as np
from peers.comparison import Peer, timed
from peers.opensees import build_beam, march

from .reference import Problem

MASS, STOP = 100_000, 200_000  # tags


@timed
def solve(problem: Problem, elements: int, steps: int) -> np.ndarray:
    """Histories of a mesh of `elements` in `steps` steps; Newton takes two iterations where the stop opens or closes."""
    import openseespy.opensees as ops

    build_beam(ops, problem, elements)
    ops.node(MASS, problem.length, 0.0)
    ops.fix(MASS, 1, 0, 1)
    ops.mass(MASS, 0.0, problem.mass, 0.0)
    ops.uniaxialMaterial("ENT", STOP, problem.stiffness)
    ops.element("zeroLength", STOP, MASS, elements, "-mat", STOP, "-dir", 2)
    ops.setNodeVel(MASS, 2, 1.0, "-commit")
    ops.test("NormUnbalance", 1e-7, 20)
    ops.algorithm("Newton")
    return march(ops, problem, elements, steps)


PEER = Peer(
    "OpenSees, Newmark",
    "elasticBeamColumn with consistent mass, a stop without tension, average acceleration",
    solve,
    {"elements": (4, 8, 16, 32), "steps": (500, 2000, 8000, 32_000)},
    {"elements": (4, 8), "steps": (1000, 4000)},
    ("openseespy", "scipy"),
)
