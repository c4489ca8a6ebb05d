"""Random scenes whose numbers are far outside anything that can be built, up to 1e±300 times what they might be."""

import random

from workplace import namelist

LOGICALS = ["velocity", "bending_moment"]


def some(draw, chance=0.5):
    return draw.random() < chance


def near(draw, value):
    """A number like this one, which stands where it may be scaled."""
    return value * draw.uniform(0.5, 2.0)


def possible_scene(draw):
    """A scene that somebody might write, as a dict of groups; of a repeated group a list of dicts."""
    pieces = draw.choice([1, 1, 2, 3])
    section = draw.choice([{"diameter": 0.037}, {"width": 0.02, "height": 0.03}, {"area": 1e-3, "second_moment": 1e-7}])
    scene = {"beam": {"length": [near(draw, 1.0 / pieces) for _ in range(pieces)]}}
    for name, value in {"density": 7870.0, "youngs_modulus": 2e11, **section}.items():
        scene["beam"][name] = [near(draw, value) for _ in range(pieces if some(draw) else 1)]
    if some(draw):
        names = draw.choice([["stiffness"], ["rotational_stiffness"], ["stiffness", "rotational_stiffness"]])
        scene["support"] = {name: near(draw, 2e5) for name in names}
    bodies = [{"position": draw.uniform(0.05, 1.0), "mass": near(draw, 1.0)} for _ in range(draw.choice([0, 0, 1, 2]))]
    for body in bodies:
        for name, value in {"rotary_inertia": 1e-3, "stiffness": 1e5, "rotational_stiffness": 1e3}.items():
            if some(draw, 0.3):
                body[name] = near(draw, value)
    if bodies:
        scene["body"] = bodies
    if some(draw):
        scene["rotation"] = {"angular_velocity": near(draw, 50.0), "plane": draw.choice(["in", "out"])}
        if some(draw):
            scene["stiffening"] = {"hub_radius": near(draw, 0.1)}
    if some(draw, 0.3):
        scene["shear"] = {"shear_coefficient": 0.85}
    if some(draw, 0.3):
        ratio = {"ratio": near(draw, 0.01)}
        scene["damping"] = ratio if some(draw) else {"mass_proportional": near(draw, 3.0), "stiffness_proportional": 1e-6}
    add_impact(draw, scene)
    return scene


def add_impact(draw, scene):
    """What strikes the beam, and what is to be seen of it."""
    captured, counted = some(draw, 0.7), some(draw, 0.7)
    scene["impact"] = {"mass": near(draw, 1.0), "approach_velocity": near(draw, 1.0), "profile_points": 11}
    if some(draw, 0.3):
        scene["impact"]["position"] = draw.uniform(0.05, 1.0)
    if some(draw, 0.3):
        scene["impact"]["restitution"] = draw.uniform(0.0, 1.0)
    if captured:
        scene["capture"] = {"rotary_inertia": near(draw, 1e-3)} if some(draw, 0.3) else {}
    if counted or not captured:
        scene["modes"] = {"before": draw.choice([3, 12])}
    if some(draw, 0.1):
        return
    scene["response"] = {"duration": near(draw, 0.1), "samples": 64} | {name: True for name in LOGICALS if some(draw)}
    if captured and some(draw, 0.3):
        scene["release"] = {"time": near(draw, 0.03)}
    if not captured and some(draw):
        scene["recontact"] = {}
    if some(draw, 0.3):
        scene["spectrum"] = {}


BOUNDED = {"position", "restitution", "samples", "profile_points", "before", "shear_coefficient"}
UNITS = {  # powers of metre, kilogram and second
    "length": (1, 0, 0), "density": (-3, 1, 0), "youngs_modulus": (-1, 1, -2), "diameter": (1, 0, 0), "width": (1, 0, 0),
    "height": (1, 0, 0), "area": (2, 0, 0), "second_moment": (4, 0, 0), "stiffness": (0, 1, -2),
    "rotational_stiffness": (2, 1, -2), "mass": (0, 1, 0), "rotary_inertia": (2, 1, 0), "angular_velocity": (0, 0, -1),
    "hub_radius": (1, 0, 0), "ratio": (0, 0, 0), "mass_proportional": (0, 0, -1), "stiffness_proportional": (0, 0, 1),
    "approach_velocity": (1, 0, -1), "duration": (0, 0, 1), "time": (0, 0, 1),
}  # fmt: skip


def numbers_of(scene):
    """Where numbers stand that have no bounds: (group's dict, name, place in the list or None)."""
    for group in scene.values():
        for values in group if isinstance(group, list) else [group]:
            for name, value in values.items():
                if name in BOUNDED or isinstance(value, (bool, str)):
                    continue
                yield from ((values, name, i) for i in (range(len(value)) if isinstance(value, list) else [None]))


def scale(place, factor):
    values, name, i = place
    if i is None:
        values[name] = bounded(values[name] * factor)
    else:
        values[name][i] = bounded(values[name][i] * factor)


def bounded(value):
    return min(max(value, 1e-300), 1e300)


def extreme_scene(draw):
    """A possible scene in other units of length, mass and time, or with one to three numbers that are far from any other."""
    scene = possible_scene(draw)
    places = list(numbers_of(scene))
    width = draw.choice([10, 30, 100, 300])
    if some(draw, 0.4):
        powers = [draw.uniform(-width, width) / 3 for _ in range(3)]
        for place in places:
            exponent = sum(a * b for a, b in zip(powers, UNITS[place[1]]))
            scale(place, 10.0 ** min(max(exponent, -300), 300))
    if some(draw, 0.8):
        for place in draw.sample(places, draw.choice([1, 1, 2, 3])):
            scale(place, 10.0 ** draw.uniform(-width, width))
    return scene


def extreme_text(seed):
    """The scene of a seed as a namelist."""
    scene = extreme_scene(random.Random(seed))
    bodies = scene.pop("body", [])
    return namelist(scene) + "".join(namelist({"body": body}) for body in bodies)
