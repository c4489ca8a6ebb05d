"""Random beams by pieces, struck anywhere, compared with far more modes: are tolerances kept, and errors within estimates?

That the modes themselves are right is shown elsewhere; this asks how many there must be. `python -m errors` in bench/ draws many beams
and prints a table.
"""

from __future__ import annotations

import subprocess
from itertools import product

import numpy as np
from tails import RECORDS, draw_record, log_between, shown
from workplace import group_text

KINDS = ["body inertia", "shear", "soft root", "inboard", "pieces", "pieces with bodies", "parts apart"]
LOCAL = ["heavy near the end", "stiff near the end", "short and soft", "sprung"]  # a short part has modes of its own, far above others
KINDS += LOCAL
FINER = 300  # times, of the tolerance that a run is compared with
PATIENCE = 60  # seconds for a run; one that takes longer is left out
ROUNDING = 2e-13  # of the comparison, over the peak


def pieces(rng, count):
    return {"length": [float(v) for v in rng.uniform(0.2, 0.6, count)], "density": [log_between(rng, 1000, 9000) for _ in range(count)],
            "youngs_modulus": [log_between(rng, 2e10, 3e11) for _ in range(count)],
            "diameter": [log_between(rng, 0.005, 0.05) for _ in range(count)]}


def unit_time(beam):
    """l²/h in seconds, of the root's stiffness and the mean mass."""
    length, mass = sum(beam["length"]), 0.0
    for l, rho, d in zip(beam["length"], beam["density"], beam["diameter"]):
        mass += rho * np.pi / 4 * d**2 * l
    return np.sqrt(mass * length**3 / (beam["youngs_modulus"][0] * np.pi / 64 * beam["diameter"][0] ** 4))


def draw_local(rng, kind, record, most):
    """A scene with a mode that hardly leaves a short part of the beam, of any number."""
    beam = pieces(rng, 1)
    short, groups = log_between(rng, 3e-3, 0.15), []
    if kind == "heavy near the end":
        groups = [("body", {"position": 1 - short, "mass_ratio": log_between(rng, 0.3, 30),
                            "rotary_inertia": float(rng.choice([0.0, log_between(rng, 1e-5, 0.1)]))})]
    if kind == "stiff near the end":
        groups = [("body", {"position": 1 - short, "mass": 0.0, "stiffness": log_between(rng, 1e5, 1e11),
                            "rotational_stiffness": float(rng.choice([0.0, log_between(rng, 1e3, 1e8)]))})]
    if kind == "sprung":
        groups = [("body", {"position": 1 - short, "mass_ratio": log_between(rng, 0.01, 10), "stiffness": log_between(rng, 1e4, 1e12)})]
    if kind == "short and soft":
        inner = 1 - short if rng.random() < 0.5 else float(rng.uniform(0.3, 0.8))
        parts = [inner, short] if inner == 1 - short else [inner, short, 1 - inner - short]
        beam = {name: values * len(parts) for name, values in beam.items()}
        beam["length"] = [length * part for length, part in zip(beam["length"], parts)]
        beam["diameter"][1] *= log_between(rng, 0.05, 0.5)
    duration, samples, points = draw_record(rng, record, most)
    if rng.random() < 0.5:
        points[0] = float(1 - short * rng.uniform(0, 2))
    position = 1.0 if rng.random() < 0.7 else float(1 - short * rng.uniform(0, 1))
    response = {"duration": float(min(duration, 1e3) * unit_time(beam)), "samples": samples, "points": points, "velocity": True}
    return [("beam", beam), *groups, ("impact", {"mass_ratio": log_between(rng, 0.01, 10), "position": position}), ("capture", {}),
            ("response", response)]


def draw(rng, kind, record, most):
    """Groups of a scene without its `&modes`."""
    if kind in LOCAL:
        return draw_local(rng, kind, record, most)
    count = int(rng.integers(2, 4)) if kind.startswith("pieces") else int(rng.integers(1, 3)) if kind == "parts apart" else 1
    beam = pieces(rng, count)
    groups = [("beam", beam)]
    if kind == "soft root":
        groups.append(("support", {"stiffness": log_between(rng, 1e3, 1e9), "rotational_stiffness": log_between(rng, 1e2, 1e7)}))
    if kind == "pieces with bodies":
        for _ in range(int(rng.integers(1, 3))):
            groups.append(("body", {"position": float(rng.uniform(0.1, 1)), "mass_ratio": log_between(rng, 0.01, 3),
                                    "rotary_inertia": float(rng.choice([0.0, log_between(rng, 1e-5, 1e-2)]))}))
    if kind == "parts apart":  # by a body that turns with difficulty; hardly anything gets behind it
        body = {"position": float(rng.uniform(0.3, 0.8)), "mass_ratio": log_between(rng, 0.3, 5), "rotary_inertia": log_between(rng, 1e-3, 0.1)}
        groups.append(("body", body))
    if kind == "shear":
        groups.append(("shear", {}))
    duration, samples, points = draw_record(rng, record, most)
    duration = min(duration, 1e3)
    if kind == "shear":  # what has hardly moved takes millions of modes
        duration = max(duration, 3e-3)
    position = float(rng.uniform(0.05, 1)) if kind == "inboard" or rng.random() < 0.3 and kind.startswith("pieces") else 1.0
    if kind == "inboard":  # places whose spans have waves in common, and what is seen where the mass is
        if rng.random() < 0.5:
            position = float(rng.choice([0.5, 0.25, 0.75, 1 / 3, 2 / 3, 0.8]))
        if rng.random() < 0.5:
            points[0] = position
    if kind == "parts apart":
        points[0] = body["position"] * float(rng.uniform(0.2, 0.9))
    groups.append(("impact", {"mass_ratio": log_between(rng, 0.01, 10), "position": position}))
    groups.append(("capture", {"rotary_inertia": log_between(rng, 1e-6, 1e-2)} if kind == "body inertia" else {}))
    response = {"duration": float(duration * unit_time(beam)), "samples": samples, "points": points, "velocity": True}
    return [*groups, ("response", response)]


def compare(here, groups, modes, finer):
    """Estimates over errors of displacement and of velocity, and the largest error over what is allowed; None if refused."""
    found = []
    for name, values in (("a", modes), ("b", {"tolerance": finer})):
        here.write(f"{name}.nml", "".join(group_text(*group) for group in [*groups, ("modes", values)]))
        (here.directory / f"output/{name}.nc").unlink(missing_ok=True)
        try:
            ended = here.beamwave("run", f"{name}.nml", "--quiet", timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            return None
        if ended.returncode:
            return None
        found.append(here.result(name))
    result, truth = found
    ratios, missed = [], 0.0
    for name in ("displacement", "velocity"):
        peak = np.abs(truth[name]).max()
        error = np.maximum(np.abs(result[name] - truth[name]).max(axis=1) - ROUNDING * peak, 0)
        own = truth["displacement_error"] if name == "displacement" else 0.0  # of what it is held against
        error = np.maximum(error - own, 0)
        ratios.append(shown(result, name, error, np.abs(truth[name]).max(axis=1)))
        if name == "displacement" and "tolerance" in modes:
            missed = (error / (modes["tolerance"] * peak)).max()
    return int(result["mode_count"]), missed, *ratios


def runs(draws, kinds, records, most, seed):
    """Kind, record and number of random beams, their groups, each with a tolerance and with counts, and the finer tolerance."""
    for number, kind, record in product(range(draws), kinds, records):
        rng = np.random.default_rng([seed, KINDS.index(kind), RECORDS.index(record), number])
        groups = draw(rng, kind, record, most)
        tolerance = log_between(rng, 1e-6 if kind == "shear" else 1e-7, 1e-2)
        counts = {"before": int(log_between(rng, 2, 100)), "after": int(log_between(rng, 2, 100))}
        yield kind, record, number, groups, {"tolerance": tolerance}, max(tolerance / FINER, 1e-7 if kind == "shear" else 1e-9)
        yield kind, record, number, groups, counts, 1e-6
