"""Motions of beams to which bodies and springs come and from which they leave, in 40 digits; run as `python make_timelines.py SEED ...`.

A uniform beam of length, mass per length and bending stiffness 1, clamped or on a hinge with a spring, is carried by Krylov's functions from
joint to joint; its frequencies are bracketed and bisected, its overlaps integrated by Gauss's rule, and each change projects the
first modes before it on the first modes after it. Nothing of the program is used. Each seed is a scene; what is printed are scenes and
histories of all seeds as JSON, which is `timelines.json`."""

import json
import random
import sys

from mpmath import cos, cosh, exp, findroot, matrix, mp, mpf, sin, sinh
from mpmath.calculus.quadrature import GaussLegendre

DIGITS = 40
mp.dps = DIGITS
MODES, SAMPLES, POINTS = 6, 16, (0.3, 1.0)


def span(p, length):
    """From (v, v', v'', v''') at the start of a stretch without bodies to those at its end."""
    u = p * length
    a, b = (cosh(u) + cos(u)) / 2, (sinh(u) + sin(u)) / 2
    c, d = (cosh(u) - cos(u)) / 2, (sinh(u) - sin(u)) / 2
    return matrix(
        [
            [a, b / p, c / p**2, d / p**3],
            [p * d, a, b / p, c / p**2],
            [p**2 * c, p * d, a, b / p],
            [p**3 * b, p**2 * c, p * d, a],
        ]
    )


class Mode:
    def __init__(self, p, pieces):
        self.p = p
        self.pieces = pieces  # (from, to, state at its start); None of a rigid turn
        self.values = {}

    def at(self, x):
        """Deflection and slope."""
        if x not in self.values:
            if self.pieces is None:
                self.values[x] = (x, mpf(1))
            else:
                mp.dps = DIGITS + int(self.p / 2) + 30
                start, state = next((a, z) for a, b, z in self.pieces if x <= b)
                there = span(self.p, x - start) * state
                mp.dps = DIGITS
                self.values[x] = (+there[0], +there[1])
        return self.values[x]


class Configuration:
    """The first modes of the beam with some bodies."""

    def __init__(self, bodies, root, places, count):
        self.bodies = [body for body in bodies if body["position"] > 0]
        self.root = root
        for body in bodies:
            if body["position"] == 0:
                self.root += body["rotational_stiffness"]
        self.places = places
        held = self.root != 0 or any(b["stiffness"] or b["rotational_stiffness"] for b in self.bodies)
        self.modes = [] if held else [Mode(mpf(0), None)]
        x, step = mpf("0.003"), mpf("0.02")
        low = self.determinant(x)
        while len(self.modes) < count:
            high = self.determinant(x + step)
            if low * high < 0:
                self.add(x, x + step)
            x, low = x + step, high

    def march(self, p, state):
        pieces, z, x = [], matrix(state), mpf(0)
        for place in self.places:
            pieces.append((x, place, z.copy()))
            z = span(p, place - x) * z
            for body in self.bodies:
                if body["position"] == place:
                    z[2] += (body["rotational_stiffness"] - body["rotary_inertia"] * p**4) * z[1]
                    z[3] -= (body["stiffness"] - body["mass"] * p**4) * z[0]
            x = place
        return pieces, z

    def starts(self):
        return ([0, 0, 1, 0] if self.root is CLAMPED else [0, 1, self.root, 0]), [0, 0, 0, 1]

    def determinant(self, p):
        a, b = (self.march(p, start)[1] for start in self.starts())
        return (a[2] * b[3] - a[3] * b[2]) / exp(2 * p)

    def add(self, low, high):
        mp.dps = DIGITS + int(high) + 50
        p = findroot(self.determinant, (low, high), solver="anderson", tol=mpf(10) ** -75, maxsteps=300, verify=False)
        (one, a), (other, b) = (self.march(p, start) for start in self.starts())
        part = -a[2] / b[2] if abs(b[2]) > abs(b[3]) else -a[3] / b[3]
        pieces = [(u[0], u[1], u[2] + part * w[2]) for u, w in zip(one, other)]
        mp.dps = DIGITS
        self.modes.append(Mode(+p, pieces))


CLAMPED = mpf("inf")


class Motion:
    def __init__(self, scene, count):
        self.scene = scene
        self.bodies = [{name: as_number(value) for name, value in body.items()} for body in scene["body"]]
        root = CLAMPED if scene["root"] is None else mpf(scene["root"])
        times = {body[name] for body in self.bodies for name in ("from", "until") if body[name] is not None}
        self.times = sorted(times)
        there = [body["from"] is None for body in self.bodies]
        self.presence = [there]
        for time in self.times:
            there = [
                (is_there or body["from"] == time) and body["until"] != time for body, is_there in zip(self.bodies, there)
            ]
            self.presence.append(there)
        places = sorted({body["position"] for body in self.bodies if body["position"] > 0} | {mpf(1)})
        found = {}
        for there in map(tuple, self.presence):
            if there not in found:
                carried = [body for body, is_there in zip(self.bodies, there) if is_there]
                found[there] = Configuration(carried, root, places, count)
        self.configurations = [found[tuple(there)] for there in self.presence]
        self.rule = gauss_rule(places, max(mode.p for item in found.values() for mode in item.modes))
        for item in found.values():
            for mode in item.modes:
                mode.mass = self.product(mode, mode, item.bodies)
        self.unstressed = [(mpf(0), mpf(0)) for _ in self.bodies]
        self.segments, self.events = [], []
        self.follow()

    def product(self, one, other, bodies):
        """∫ v w dx + Σ m v w + J v' w'."""
        total = sum(weight * one.at(x)[0] * other.at(x)[0] for x, weight in self.rule)
        for body in bodies:
            (v, slope), (w, turn) = one.at(body["position"]), other.at(body["position"])
            total += body["mass"] * v * w + body["rotary_inertia"] * slope * turn
        return total

    def equilibrium(self, item, there):
        """f/(M β²): of springs that pull towards where they came."""
        rest = []
        for mode in item.modes:
            force = mpf(0)
            for body, is_there, (v, slope) in zip(self.bodies, there, self.unstressed):
                if is_there:
                    shape = mode.at(body["position"])
                    force += body["stiffness"] * v * shape[0] + body["rotational_stiffness"] * slope * shape[1]
            rest.append(force / (mode.mass * mode.p**4) if force else mpf(0))
        return rest

    def follow(self):
        item, first = self.configurations[0], self.scene.get("initial", {})
        q, rate = [mpf(0)] * len(item.modes), [mpf(0)] * len(item.modes)
        for k, mode in enumerate(item.modes):
            if "force" in first:
                q[k] = mpf(first["force"]) * mode.at(mpf(first["position"]))[0] / (mode.mass * mode.p**4)
            if "angular_velocity" in first:
                rate[k] = mpf(first["angular_velocity"]) * self.product(mode, Mode(mpf(0), None), item.bodies) / mode.mass
        level = mpf(0)
        self.segments.append((mpf(0), item, q, rate, []))
        for i, time in enumerate(self.times):
            level = self.change(i, time, level)

    def change(self, i, time, level):
        was, there = self.presence[i], self.presence[i + 1]
        item, later = self.configurations[i], self.configurations[i + 1]
        q, rate = flow(self.segments[-1], time)
        whole = [*self.segments[-1][4], (item, q, was)]  # the displacement: a shape, and the motion about it
        moved = [total(whole, body["position"]) for body in self.bodies]
        moving = [at(item, rate, body["position"]) for body in self.bodies]
        kinetic = sum(mode.mass * v**2 / 2 for mode, v in zip(item.modes, rate))
        potential = level + sum(mode.mass * mode.p**4 * a**2 / 2 for mode, a in zip(item.modes, q))
        before, kept, leaving = kinetic + potential, potential, mpf(0)
        for body, old, new, (v, slope), (rate_v, turn), (v0, slope0) in zip(
            self.bodies, was, there, moved, moving, self.unstressed
        ):
            motion = (body["mass"] * rate_v**2 + body["rotary_inertia"] * turn**2) / 2
            if new and not old:
                before += motion if body["velocity"] is None else body["mass"] * body["velocity"] ** 2 / 2
            if old and not new:
                strain = (body["stiffness"] * (v - v0) ** 2 + body["rotational_stiffness"] * (slope - slope0) ** 2) / 2
                kept -= strain
                leaving += motion + strain
        new_q, new_rate = [], []
        for mode in later.modes:
            a = sum(self.seen(mode, there, *term) for term in whole)
            b = self.seen(mode, there, item, rate, was)
            for body, old, new, (rate_v, turn) in zip(self.bodies, was, there, moving):
                if new and not old and body["velocity"] is not None:
                    shape = mode.at(body["position"])
                    b += body["mass"] * (body["velocity"] - rate_v) * shape[0] - body["rotary_inertia"] * turn * shape[1]
            new_q.append(a / mode.mass)
            new_rate.append(b / mode.mass)
        self.unstressed = [
            where if new and not old else known for old, new, where, known in zip(was, there, moved, self.unstressed)
        ]
        rest, shape = self.equilibrium(later, there), []
        if any(rest):
            new_q = [a - r for a, r in zip(new_q, rest)]
            shape = [*whole, (later, [-a for a in new_q], there)]
        strain = sum(mode.mass * mode.p**4 * a**2 / 2 for mode, a in zip(later.modes, new_q))
        level = kept - strain if any(rest) else mpf(0)
        after = sum(mode.mass * v**2 / 2 for mode, v in zip(later.modes, new_rate)) + strain + level + leaving
        self.events.append((before, after))
        self.segments.append((time, later, new_q, new_rate, shape))
        return level

    def seen(self, mode, there, item, state, was):
        """What a mode sees of a motion in modes of another configuration, with all bodies that are there now."""
        carried = [body for body, is_there in zip(self.bodies, there) if is_there and body["position"] > 0]
        return sum(self.product(mode, other, carried) * a for other, a in zip(item.modes, state))

    def history(self, times, points):
        """Displacements and velocities, (points, times) each."""
        rows = [[], []]
        for time in times:
            segment = [item for item in self.segments if item[0] <= time][-1]
            for row, state, shape in zip(rows, flow(segment, time), (segment[4], [])):
                row.append([float(total([*shape, (segment[1], state, None)], mpf(point))[0]) for point in points])
        return [list(map(list, zip(*row))) for row in rows]


def as_number(value):
    return value if value is None else mpf(value)


def at(item, state, x):
    """Deflection and slope of a state."""
    shapes = [mode.at(x) for mode in item.modes]
    return tuple(sum(a * shape[i] for a, shape in zip(state, shapes)) for i in range(2))


def total(terms, x):
    """The same of motions in modes of several configurations."""
    parts = [at(item, state, x) for item, state, _ in terms]
    return tuple(sum(part[i] for part in parts) for i in range(2))


def flow(segment, time):
    start, item, q, rate, _ = segment
    t, moved, moving = time - start, [], []
    for mode, a, v in zip(item.modes, q, rate):
        beta = mode.p**2
        if beta == 0:
            moved.append(a + v * t)
            moving.append(v)
        else:
            moved.append(a * cos(beta * t) + v * sin(beta * t) / beta)
            moving.append(v * cos(beta * t) - a * beta * sin(beta * t))
    return moved, moving


def gauss_rule(places, wave_number):
    nodes = GaussLegendre(mp).calc_nodes(4, mp.prec + 20)
    rule, start = [], mpf(0)
    for end in places:
        parts = int(wave_number * (end - start) / 4) + 1
        for j in range(parts):
            low, width = start + (end - start) * j / parts, (end - start) / parts
            rule += [(low + width * (x + 1) / 2, weight * width / 2) for x, weight in nodes]
        start = end
    return rule


def scene_of(seed):
    """A random scene in the beam's own units."""
    draw = random.Random(seed)
    duration = draw.choice([0.5, 2.0, 5.0])
    root = draw.choice([None, 0.0, 3.0, 50.0])
    bodies = []
    for _ in range(draw.randint(1, 3)):
        body = {
            "position": draw.choice([0.25, 0.5, 0.75, 1.0, 0.625]),
            "mass": draw.choice([0.0, 0.1, 0.5, 3.0]),
            "rotary_inertia": draw.choice([0.0, 0.0, 0.01]),
            "stiffness": draw.choice([0.0, 0.0, 10.0, 1000.0]),
            "rotational_stiffness": draw.choice([0.0, 0.0, 2.0]),
            "from": draw.choice([None, 0.0, round(draw.uniform(0.05, 0.6) * duration, 6)]),
            "until": draw.choice([None, round(draw.uniform(0.65, 0.95) * duration, 6)]),
            "velocity": None,
        }
        if root is not None and draw.random() < 0.3:
            body |= {"position": 0.0, "mass": 0.0, "rotary_inertia": 0.0, "stiffness": 0.0}
            body["rotational_stiffness"] = draw.choice([1.0, 100.0])
        if body["from"] is not None and body["mass"] > 0 and draw.random() < 0.6:
            body["velocity"] = draw.choice([1.0, -0.7])
        bodies.append(body)
    scene = {"duration": duration, "root": root, "body": bodies, "initial": {}}
    moves = any(body["velocity"] is not None for body in bodies)
    if root is not None and (draw.random() < 0.5 or not moves):
        scene["initial"]["angular_velocity"] = draw.choice([1.0, -0.4])
        moves = True
    held = root != 0 or any(b["from"] is None and (b["stiffness"] or b["rotational_stiffness"]) for b in bodies)
    if held and (draw.random() < 0.4 or not moves):
        scene["initial"] |= {"force": draw.choice([1.0, 0.3]), "position": draw.choice([0.5, 1.0])}
    return scene


def reference(seed, count=MODES):
    scene = scene_of(seed)
    motion = Motion(scene, count)
    displacement, velocity = motion.history([mpf(scene["duration"]) * j / SAMPLES for j in range(SAMPLES)], POINTS)
    energies = [[float(before), float(after)] for before, after in motion.events]
    return {
        "seed": seed,
        "modes": count,
        "points": POINTS,
        "scene": scene,
        "displacement": displacement,
        "velocity": velocity,
        "energies": energies,
    }


if __name__ == "__main__":
    print(json.dumps([reference(int(seed)) for seed in sys.argv[1:]], indent=None))
