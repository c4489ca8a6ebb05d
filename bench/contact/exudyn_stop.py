"""Exudyn: matrices of Hermite elements as its linear object, and its connector with limit stops between tip and mass.

Its own beams follow large motions, which differ from the linear theory by 1e-5 here. Its generalised alpha without numerical
damping is Newmark's method with average acceleration.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from peers import hermite
from peers.comparison import Peer, timed

from .reference import Problem

OPEN = 1e3  # m: where the other side of the stop lies


def system_of(problem: Problem, elements: int) -> Any:
    """Beam, mass and stop; the sensors of the points."""
    import exudyn as exu
    from exudyn import itemInterface as item

    whole = exu.SystemContainer()
    system = whole.AddSystem()
    stiffness, mass = hermite.matrices(problem, elements)
    heavy = problem.density * problem.area * problem.length
    count = len(mass)
    start = {"referenceCoordinates": [0.0] * count, "initialCoordinates": [0.0] * count, "initialCoordinates_t": [0.0] * count}
    beam = system.AddNode(item.NodeGenericODE2(numberOfODE2Coordinates=count, **start))
    system.AddObject(item.ObjectGenericODE2(nodeNumbers=[beam], massMatrix=heavy * mass, stiffnessMatrix=heavy * stiffness))
    body = system.AddNode(item.Node1D(referenceCoordinates=[0.0], initialCoordinates=[0.0], initialVelocities=[1.0]))
    system.AddObject(item.Mass1D(nodeNumber=body, physicsMass=problem.mass))
    ends = [system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=place)) for node, place in ((beam, count - 2), (body, 0))]
    touching = system.AddNode(item.NodeGenericData(numberOfDataCoordinates=3, initialCoordinates=[0.0, 0.0, 0.0]))
    system.AddObject(item.ObjectConnectorCoordinateSpringDamperExt(
        markerNumbers=ends, nodeNumber=touching, useLimitStops=True, limitStopsUpper=0.0, limitStopsLower=-OPEN, limitStopsStiffness=problem.stiffness))  # fmt: skip
    sensor = system.AddSensor(item.SensorNode(nodeNumber=beam, storeInternal=True, outputVariableType=exu.OutputVariableType.Coordinates))
    system.Assemble()
    return exu, whole, system, sensor


@timed
def newmark(problem: Problem, elements: int, steps: int) -> np.ndarray:
    """Histories of a mesh of `elements` in `steps` steps."""
    exu, _whole, system, sensor = system_of(problem, elements)
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = problem.duration
    settings.timeIntegration.numberOfSteps = steps
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.generalizedAlpha.spectralRadius = 1.0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = problem.duration / steps
    settings.parallel.numberOfThreads = 1
    system.SolveDynamic(settings)
    record = system.GetSensorStoredData(sensor)[:steps, 1:][:, hermite.rows_of_points(problem, elements)]
    return hermite.at_samples(record.T, problem)


PEER = Peer(
    "Exudyn, Newmark",
    "Hermite elements, a connector with a limit stop, generalised alpha without damping",
    newmark,
    {"elements": (4, 8, 16, 32, 64), "steps": (500, 2000, 8000, 32_000, 128_000)},
    {"elements": (4, 8), "steps": (1000, 4000)},
    ("exudyn", "scipy"),
)
