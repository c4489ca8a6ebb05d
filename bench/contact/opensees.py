"""OpenSees: the mass is a node of its own, and a zeroLength element of the material ENT, elastic without tension, is the stop."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from peers.hermite_newmark import at_samples
from peers.opensees import build_beam
from peers.peer import Peer, timed

from .problem import Problem

MASS, STOP = 100_000, 200_000  # tags


@timed
def solve(problem: Problem, elements: int, steps: int) -> np.ndarray:
    """Histories of a mesh of `elements` in `steps` steps."""
    import openseespy.opensees as ops

    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    build_beam(ops, problem, elements)
    ops.node(MASS, problem.length, 0.0)
    ops.fix(MASS, 1, 0, 1)
    ops.mass(MASS, 0.0, problem.mass, 0.0)
    ops.uniaxialMaterial("ENT", STOP, problem.stiffness)
    ops.element("zeroLength", STOP, MASS, elements, "-mat", STOP, "-dir", 2)
    ops.setNodeVel(MASS, 2, 1.0, "-commit")
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "displacement.bin"
        nodes = [int(xi * elements) for xi in problem.points]
        ops.recorder("Node", "-binary", str(path), "-node", *nodes, "-dof", 2, "disp")
        march(ops, problem, steps)
        row = np.dtype([("displacement", float, len(problem.points)), ("end", "u1")])
        record = np.fromfile(path, dtype=row)["displacement"].T
    start = np.zeros((len(problem.points), 1))  # the recorder begins after the first step
    return at_samples(np.hstack([start, record])[:, :steps], problem)


def march(ops: object, problem: Problem, steps: int) -> None:
    """All steps by Newton's iteration, which takes two where the stop opens or closes."""
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandSPD")
    ops.test("NormUnbalance", 1e-7, 20)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    if ops.analyze(steps, problem.duration / steps) != 0:
        raise RuntimeError("OpenSees did not finish")
    ops.wipe()  # closes the record


SETTINGS = ((4, 500), (8, 2000), (16, 8000), (32, 32_000))

PEER = Peer(
    "OpenSees, Newmark",
    "elasticBeamColumn with consistent mass, a stop without tension, average acceleration",
    solve,
    settings=tuple({"elements": elements, "steps": steps} for elements, steps in SETTINGS),
    small=({"elements": 4, "steps": 1000}, {"elements": 8, "steps": 4000}),
    packages=("openseespy", "scipy"),
)
