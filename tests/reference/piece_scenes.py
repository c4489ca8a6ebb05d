"""Random scenes of beams by pieces, with bodies, springs, an elastic root, shear, rotation, and a blow anywhere: as groups of a
namelist, and as the numbers of binary64 that stand in it."""

import math
import random

SCENES = 20
SEED = 1717
SAMPLES, POINTS = 16, (0.35, 0.8, 1.0)


def spread(draw, low, high):
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def chance(draw, odds):
    return draw.random() < odds


def scene(number):
    """Groups of scene `number` from 0, as (name, values) in their order: a beam of about a metre, and about a swing of mode 1."""
    draw = random.Random(SEED + number)
    pieces = draw.choice((1, 2, 3))
    lengths = [draw.uniform(0.2, 0.6) for _ in range(pieces)]
    beam = {"length": lengths, "density": [spread(draw, 1000, 9000) for _ in range(pieces)],
            "youngs_modulus": [spread(draw, 1e10, 3e11) for _ in range(pieces)]}
    if chance(draw, 0.5):
        beam["diameter"] = [spread(draw, 0.02, 0.08) for _ in range(pieces)]
    else:
        beam["width"] = [spread(draw, 0.02, 0.08) for _ in range(pieces)]
        beam["height"] = [spread(draw, 0.02, 0.08) for _ in range(pieces)]
    groups = [("beam", beam)]
    if chance(draw, 0.5):
        support = {"stiffness": spread(draw, 1e4, 1e8)} if chance(draw, 0.6) else {}
        if chance(draw, 0.6) or not support:
            support["rotational_stiffness"] = spread(draw, 1e3, 1e6)
        groups.append(("support", support))
    for _ in range(draw.choice((0, 1, 2))):
        body = {"position": draw.choice((1.0, draw.uniform(0.1, 1.0))), "mass_ratio": spread(draw, 0.01, 1)}
        if chance(draw, 0.5):
            body["rotary_inertia"] = spread(draw, 1e-4, 1e-1)
        if chance(draw, 0.4):
            body["stiffness"] = spread(draw, 1e3, 1e7)
        if chance(draw, 0.3):
            body["rotational_stiffness"] = spread(draw, 1e2, 1e5)
        groups.append(("body", body))
    if chance(draw, 0.6):
        groups.append(("rotation", {"angular_velocity": draw.uniform(5, 60), "plane": draw.choice(("in", "out"))}))
    if chance(draw, 0.5):
        groups.append(("shear", {"poisson_ratio": 0.3}))
    if chance(draw, 0.4):
        groups.append(("damping", {"ratio": spread(draw, 1e-3, 0.1)}))
    groups.append(("impact", {"mass_ratio": spread(draw, 0.05, 2), "position": draw.choice((1.0, draw.uniform(0.2, 1.0))),
                              "approach_velocity": 2.0, "restitution": draw.choice((0.0, 0.5))}))
    groups.append(("capture", {"rotary_inertia": spread(draw, 1e-4, 1e-1)} if chance(draw, 0.4) else {}))
    groups.append(("modes", {"before": draw.randint(3, 6), "after": draw.randint(3, 6)}))
    duration = spread(draw, 0.01, 0.3)
    if chance(draw, 0.4):
        groups.append(("release", {"time": duration * draw.uniform(0.2, 0.8)}))
    groups.append(("response", {"duration": duration, "samples": SAMPLES, "points": list(POINTS)}))
    return groups
