"""The modal model in the files of other programs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from scipy.io import savemat

from ..result import NothingToDraw
from .model import ModalModel
from .state_space import state_space

METRE_NEWTON = 1  # units of data set 164
TRANSVERSE = 8  # a displacement, among the kinds of data of data set 55


def arrays(model: ModalModel) -> dict[str, Any]:
    """Everything by its name, for `mat` and `npz`."""
    space = state_space(model)
    hub = {
        "hub_turn": model.hub_turn,
        "hub_radius": model.hub_radius,
        "residual_hub_turn": model.hub_residual,
        "residual_hub_turn_of_base": model.base_hub_residual,
    }
    return {
        "position": model.position,
        "distance": model.distance,
        "angular_frequency": model.angular_frequency,
        "frequency": model.angular_frequency / (2.0 * np.pi),
        "damping_ratio": model.damping_ratio,
        "modal_mass": model.mass,
        "modal_damping": model.damping,
        "modal_stiffness": model.stiffness,
        "participation": model.participation,
        "turn_participation": model.turn_participation,
        "effective_mass": model.effective_mass,
        "residual_mass": model.residual_mass,
        "moving_mass": model.moving_mass,
        "shape": model.shape,
        "slope": model.slope,
        "moment": model.moment,
        "shear": model.shear,
        "residual_flexibility": model.residual["displacement"],
        "residual_moment": model.residual["bending_moment"],
        "residual_shear": model.residual["shear_force"],
        "residual_of_base": model.base_residual["displacement"],
        "residual_moment_of_base": model.base_residual["bending_moment"],
        "residual_shear_of_base": model.base_residual["shear_force"],
        **({} if model.hub_turn is None else hub),
        "A": space.a,
        "B": space.b,
        "C": space.c,
        "D": space.d,
        "inputs": space.inputs,
        "outputs": space.outputs,
        "initial_state": space.initial_state,
    }


def write_npz(model: ModalModel, path: Path, title: str) -> None:
    """NumPy's own format; texts are arrays of texts."""
    with path.open("wb") as file:
        np.savez(file, title=title, **arrays(model))


def write_mat(model: ModalModel, path: Path, title: str) -> None:
    """MATLAB 5, columns for lists and cells for names."""
    values = arrays(model)
    for name in ("inputs", "outputs"):
        values[name] = np.array(values[name], dtype=object)
    savemat(path, {"title": title, **values}, oned_as="column")


def write_unv(model: ModalModel, path: Path, title: str) -> None:
    """A universal file: header 151, units 164, nodes 15 along x, and a data set 55 for each mode.

    Shapes are displacements along y and turnings about z, with six digits; where a hub turns, those of the motion in the
    frame. Rigid modes have frequency and damping ratio 0.
    Raises `NothingToDraw` for modes that grow or are overdamped, which are no normal modes, and without the package pyuff.
    """
    unfit = np.flatnonzero((model.stiffness < 0.0) | (model.damping > 0.0) & (model.damping**2 >= 4.0 * model.stiffness * model.mass)) + 1
    if unfit.size:
        names = ", ".join(map(str, unfit[:5])) + (", …" if unfit.size > 5 else "")
        one, grow = ("modes", "grow or are") if unfit.size > 1 else ("mode", "grows or is")
        raise NothingToDraw(f"{one} {names} {grow} overdamped, which a universal file has no numbers for; accepted: mat, npz")
    try:
        import pyuff
    except ImportError as missing:
        why = "writing universal files takes the Python package pyuff: pip install './postproc[records]'"
        raise NothingToDraw(why) from missing
    name = "".join(letter if letter.isascii() and letter.isprintable() else "?" for letter in title)[:80] or "NONE"
    sets = [*_heads(pyuff, model, name), *(_mode(pyuff, model, name, k) for k in range(model.mass.size))]
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")


def _heads(pyuff: ModuleType, model: ModalModel, name: str) -> Iterator[dict[str, Any]]:
    """Header, units and nodes; versions and dates of the header, which are not given, pyuff fills as it writes."""
    words = {"description": "modes of a beam", "db_app": "beamwave", "program": "beamwave"}
    yield pyuff.prepare_151(model_name=name, **words)
    units = {"units_code": METRE_NEWTON, "units_description": "SI units", "temp_mode": 1, "temp_offset": 0.0}
    yield pyuff.prepare_164(length=1.0, force=1.0, temp=1.0, **units, return_full_dict=True)
    zeros, none = [0.0] * model.position.size, [0] * model.position.size
    axes = {"x": model.distance.tolist(), "y": zeros, "z": zeros, "def_cs": none, "disp_cs": none, "color": none}
    yield pyuff.prepare_15(node_nums=_nodes(model), **axes, return_full_dict=True)


def _mode(pyuff: ModuleType, model: ModalModel, name: str, k: int) -> dict[str, Any]:
    """One mode."""
    zeros = np.zeros(model.position.size)
    motion = {"r1": zeros, "r2": model.motion[k], "r3": zeros, "r4": zeros, "r5": zeros, "r6": model.turning[k]}
    numbers = {
        "freq": float(model.angular_frequency[k] / (2.0 * np.pi)),
        "modal_m": float(model.mass[k]),
        "modal_damp_vis": float(np.nan_to_num(model.damping_ratio[k])),  # there is none of a rigid mode
        "modal_damp_his": 0.0,
    }
    kind = {"model_type": 1, "analysis_type": 2, "data_ch": 3, "spec_data_type": TRANSVERSE, "data_type": 2}
    words = {"id1": name, "id2": f"mode {k + 1}", "id3": "NONE", "id4": "NONE", "id5": "NONE"}
    place = {"n_data_per_node": 6, "load_case": 1, "mode_n": k + 1, "node_nums": _nodes(model)}
    return pyuff.prepare_55(**words, **kind, **place, **motion, **numbers, return_full_dict=True)


def _nodes(model: ModalModel) -> list[int]:
    return list(range(1, model.position.size + 1))


WRITERS = {"mat": write_mat, "npz": write_npz, "unv": write_unv}
