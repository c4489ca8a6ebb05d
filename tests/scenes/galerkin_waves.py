"""Whether a frequency's interval holds a mode of a beam with stiffening, shear or a body that turns, by power series."""

import sys

import mpmath
import numpy as np
from conftest import PROJECT

sys.path.append(str(PROJECT / "tests/reference"))
from effects_beam import Case, series_determinant  # noqa: E402

SIMULATED = 1e-12  # relative error that the program's own modes may have: the record is theirs
PARTS = (1, 0, -0.5, 0.5)  # of the error, where signs are compared with that at -1: an interval may hold two modes


def case_of(scene):
    """The beam without dimensions."""
    mpf = mpmath.mpf
    length, diameter, density, modulus = (mpf(scene["beam"][name]) for name in ("length", "diameter", "density", "youngs_modulus"))
    time = length**2 / (diameter / 4 * mpmath.sqrt(modulus / density))
    omega = mpf(scene.get("rotation", {}).get("angular_velocity", 0.0)) * time
    hub = scene.get("stiffening", {}).get("hub_radius")
    parts = {"omega": omega, "hub": hub if hub is None else mpf(hub) / length, "gamma": mpf(scene["impact"]["mass_ratio"])}
    if "shear" in scene:
        nu = mpf(scene["shear"]["poisson_ratio"])
        slender = (diameter / 4 / length) ** 2
        cowper = 6 * (1 + nu) / (7 + 6 * nu)
        parts |= {"rotary": slender, "compliance": slender * 2 * (1 + nu) / cowper}
    mass = density * mpmath.pi * diameter**2 / 4 * length
    parts["inertia"] = mpf(scene["capture"].get("rotary_inertia", 0.0)) / (mass * length**2)
    return Case(**parts), time


def holds_a_mode(scene, result, frequency, error):
    """The determinant of the end conditions changes its sign within the interval; a damped mode is the program's own."""
    if "damping" in scene:
        return bool((np.abs(result["angular_frequency"] - frequency) <= error + SIMULATED * frequency).any())
    case, time = case_of(scene)
    waves = float(mpmath.sqrt(mpmath.mpf(frequency) * time)) + float(case.omega)
    with mpmath.workdps(60 + int(1.2 * waves)):

        def is_positive(part):
            beta = (mpmath.mpf(frequency) + part * (error + SIMULATED * frequency)) * time
            return series_determinant(case, 130 + int(5 * waves), beta * abs(beta)) > 0

        first = is_positive(-1)
        return any(is_positive(part) != first for part in PARTS)
