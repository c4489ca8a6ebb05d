"""Forces at points and the motion of the base in, histories out: ẋ = A x + B u, y = C x + D u."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .model import ModalModel

QUANTITIES = ("displacement", "velocity", "acceleration", "bending_moment", "shear_force")
BASE = "base_acceleration"


@dataclass(frozen=True)
class StateSpace:
    """Matrices, the names of what goes in and comes out, and the state at t = 0. States are q, then q̇, of all modes."""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    inputs: list[str]
    outputs: list[str]
    initial_state: np.ndarray


def state_space(model: ModalModel) -> StateSpace:
    """The modal model as a state space.

    Inputs are a force at each point, `force_1` at the first, in N, positive as displacement is, and `base_acceleration`
    in m/s². Outputs are `displacement_1` and likewise each of QUANTITIES at each point, relative to the base. What
    modes that are not in the file add stands in D: to displacement, bending moment and shear force. To a velocity they
    add R Ḟ and to an acceleration R F̈, which no state space has: these outputs are those of the modes. On a hub that is
    free displacements are those from its line, and the last output is its turn, `hub_angle`.
    """
    count, points = model.shape.shape
    per_mass = 1.0 / model.mass[:, np.newaxis]
    drive = np.hstack([model.motion, -model.participation[:, np.newaxis]]) * per_mass  # (modes, inputs)
    unity, nothing = np.eye(count), np.zeros((count, count))
    a = np.block([[nothing, unity], [-np.diag(model.stiffness / model.mass), -np.diag(model.damping / model.mass)]])
    b = np.vstack([np.zeros_like(drive), drive])
    of_place = np.zeros((points, count))
    acceleration = model.shape.T @ a[count:]
    c = [
        np.hstack([model.shape.T, of_place]),
        np.hstack([of_place, model.shape.T]),
        acceleration,
        np.hstack([model.moment.T, of_place]),
        np.hstack([model.shear.T, of_place]),
    ]
    none = np.zeros((points, points + 1))
    d = [
        _residuals(model, "displacement"),
        none,
        model.shape.T @ drive,
        _residuals(model, "bending_moment"),
        _residuals(model, "shear_force"),
    ]
    numbers = range(1, points + 1)
    outputs = [f"{quantity}_{number}" for quantity in QUANTITIES for number in numbers]
    if model.hub_turn is not None:
        c.append(np.hstack([model.hub_turn, np.zeros(count)]))
        d.append(np.append(model.hub_residual, model.base_hub_residual))
        outputs.append("hub_angle")
    return StateSpace(
        a=a,
        b=b,
        c=np.vstack(c),
        d=np.vstack(d),
        inputs=[*(f"force_{number}" for number in numbers), BASE],
        outputs=outputs,
        initial_state=np.concatenate([model.initial_displacement, model.initial_velocity]),
    )


def _residuals(model: ModalModel, quantity: str) -> np.ndarray:
    """What all other modes add at once, (points, inputs)."""
    return np.hstack([model.residual[quantity], model.base_residual[quantity][:, np.newaxis]])
