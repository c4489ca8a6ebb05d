"""Writes piece_responses.txt: histories of the scenes of piece_scenes.py, by modes with 50 digits and overlaps by quadrature."""

import sys
from multiprocessing import Pool

from mpmath import mp, mpf

from piece_scenes import POINTS, SAMPLES, SCENES, scene
from pieces_beam import Beam, Joint, Mode, Piece, root
from table import write_table

mp.dps = 55
NODES = 40


def each(values, i):
    return mpf(values[i] if isinstance(values, list) else values)


def section(beam, i):
    """Area and second moment of a piece."""
    if "diameter" in beam:
        d = each(beam["diameter"], i)
        return mp.pi / 4 * d**2, mp.pi / 64 * d**4
    w, h = each(beam["width"], i), each(beam["height"], i)
    return w * h, w * h**3 / 12


class Case:
    """A scene without dimensions: lengths in l, masses in m_i, times in l^2/h, EI of the root piece 1."""

    def __init__(self, groups):
        self.groups = dict(group for group in groups if group[0] != "body")
        beam = self.groups["beam"]
        count = len(beam["length"])
        lengths = [each(beam["length"], i) for i in range(count)]
        sections = [section(beam, i) for i in range(count)]
        self.l = sum(lengths)
        self.mass = sum(each(beam["density"], i) * sections[i][0] * lengths[i] for i in range(count))
        self.ei = each(beam["youngs_modulus"], 0) * sections[0][1]
        self.time = mp.sqrt(self.mass * self.l**3 / self.ei)
        spans = []
        for i in range(count):
            area, moment = sections[i]
            rho, e = each(beam["density"], i), each(beam["youngs_modulus"], i)
            piece = {"stiffness": e * moment / self.ei, "mass": rho * area * self.l / self.mass}
            if "shear" in self.groups:
                nu = mpf(self.groups["shear"]["poisson_ratio"])
                kappa = 6 * (1 + nu) / (7 + 6 * nu) if "diameter" in beam else 10 * (1 + nu) / (12 + 11 * nu)
                kappa = mpf(float(kappa))  # it is an input of binary64, where it is not given too
                piece["compliance"] = 2 * (1 + nu) / (kappa * e * area) * self.ei / self.l**2
                piece["rotary"] = rho * moment / (self.mass * self.l)
            spans.append((lengths[i] / self.l, piece))
        impact = self.groups["impact"]
        self.struck = mpf(impact["position"])
        self.gamma = mpf(impact["mass_ratio"])
        self.inertia = mpf(self.groups["capture"].get("rotary_inertia", 0.0)) / (self.mass * self.l**2)
        bodies = [values for name, values in groups if name == "body"]
        places = {self.struck: Joint()}
        for body in bodies:
            joint = places.setdefault(mpf(body["position"]), Joint())
            joint.mass += mpf(body["mass_ratio"])
            joint.inertia += mpf(body.get("rotary_inertia", 0)) / (self.mass * self.l**2)
            joint.stiffness += mpf(body.get("stiffness", 0)) * self.l**3 / self.ei
            joint.turning_stiffness += mpf(body.get("rotational_stiffness", 0)) * self.l / self.ei
        support = self.groups.get("support", {})
        springs = tuple(None if support is None or name not in support else mpf(support[name]) * scale for name, scale in
                        (("stiffness", self.l**3 / self.ei), ("rotational_stiffness", self.l / self.ei)))
        rotation = self.groups.get("rotation", {"angular_velocity": 0.0, "plane": "in"})
        omega = mpf(rotation["angular_velocity"]) * self.time
        self.free = Beam(*self.cut(spans, places), springs, omega, int(rotation["plane"] == "in"))
        places[self.struck] = Joint(**vars(places[self.struck]))
        places[self.struck].mass += self.gamma
        places[self.struck].inertia += self.inertia
        self.loaded = Beam(*self.cut(spans, places), springs, omega, int(rotation["plane"] == "in"))

    @staticmethod
    def cut(spans, places):
        """Pieces and joints with a joint at every place."""
        pieces, joints, start = [], [], mpf(0)
        for length, piece in spans:
            end = start + length
            inside = sorted(place for place in places if start < place < end - mpf(10) ** -15)
            for place in [*inside, end]:
                pieces.append(Piece(place - start, **piece))
                joint = [places[p] for p in places if abs(p - place) < mpf(10) ** -15]
                joints.append(joint[0] if joint else Joint())
                start = place
        return pieces, joints


def modes_of(beam, count):
    """The first modes with their masses, shapes scaled as they come."""
    spin = mpf(beam.omega) ** 2
    modes = []
    for k in range(1, count + 1):
        square = root(beam, k, mpf(10) ** -25 - spin, mpf(k) ** 4)
        mode = Mode(beam, square)
        mode.mass = mode.masses()[1]
        mode.spun = spun(mode)
        modes.append(mode)
    return modes


def gauss(n):
    """Nodes and weights on [0, 1]."""
    nodes = []
    for i in range(n):
        x = mp.cos(mp.pi * (i + mpf(3) / 4) / (n + mpf(1) / 2))
        for _ in range(12):
            p, q = mpf(1), x
            for k in range(2, n + 1):
                p, q = q, ((2 * k - 1) * x * q - (k - 1) * p) / k
            slope = n * (x * q - p) / (x * x - 1)
            x -= q / slope
        nodes.append(((1 + x) / 2, 1 / ((1 - x * x) * slope**2)))
    return nodes


RULE = gauss(NODES)


def states(mode):
    """(v, psi) at the nodes of every piece, and at its outer end."""
    if not hasattr(mode, "values"):
        mode.values = [[[mp.re(s) for s in mode.state(i, x)[:2]] for x, _ in RULE] for i in range(len(mode.beam.pieces))]
        mode.ends = [[mp.re(s) for s in mode.state(i, mpf(1))[:2]] for i in range(len(mode.beam.pieces))]
    return mode.values, mode.ends


def product(one, other, joints):
    """The integral of rho A v v' + rho I psi psi' with these bodies."""
    (a, a_ends), (b, b_ends) = states(one), states(other)
    total = mpf(0)
    for i, piece in enumerate(one.beam.pieces):
        for (_, w), (v, psi), (v2, psi2) in zip(RULE, a[i], b[i]):
            total += w * piece.length * (piece.mass * v * v2 + piece.rotary * psi * psi2)
        total += joints[i].mass * a_ends[i][0] * b_ends[i][0] + joints[i].inertia * a_ends[i][1] * b_ends[i][1]
    return total


def spun(mode):
    """The part of the modal mass on which the spin acts."""
    values, ends = states(mode)
    turning = sum(w * p.length * p.rotary * psi**2 for p, row in zip(mode.beam.pieces, values) for (_, w), (_, psi) in zip(RULE, row))
    if not mode.beam.in_plane:
        return turning
    return mode.mass - turning - sum(j.inertia * end[1] ** 2 for j, end in zip(mode.beam.joints, ends))


def damping_of(case, mode):
    if "damping" not in case.groups:
        return mpf(0)
    elastic = mode.square + mpf(mode.beam.omega) ** 2 * mode.spun / mode.mass
    return 2 * mpf(case.groups["damping"]["ratio"]) * mp.sqrt(elastic)


def flow(mode, c, q, rate, t):
    """State after a time."""
    root_of = mp.sqrt(mp.mpc(mode.square - c**2 / 4))
    s, co = mp.re(mp.sin(root_of * t) / root_of), mp.re(mp.cos(root_of * t))
    fade = mp.exp(-c * t / 2)
    return fade * (q * co + (rate + c / 2 * q) * s), fade * (rate * co - (c / 2 * rate + mode.square * q) * s)


def rows_of(number):
    groups = scene(number)
    case = Case(groups)
    counts, impact, response = case.groups["modes"], case.groups["impact"], case.groups["response"]
    free, loaded = modes_of(case.free, counts["before"]), modes_of(case.loaded, counts["after"])
    e = mpf(impact["restitution"])
    at = lambda mode: mode.at(case.struck)[0]
    mobility = sum(at(mode) ** 2 / mode.mass for mode in free)
    impulse = (1 + e) / (1 / case.gamma + mobility)
    jump = [at(mode) * impulse / mode.mass for mode in free]
    start = []
    for mode in loaded:
        seen = sum((product(mode, other, case.free.joints) + case.gamma * at(mode) * at(other)) * v for other, v in zip(free, jump))
        start.append((mpf(0), seen / mode.mass))
    speed = mpf(impact["approach_velocity"])
    release = mpf(case.groups["release"]["time"]) / case.time if "release" in case.groups else None
    if release is not None:
        held = [flow(mode, damping_of(case, mode), *state, release) for mode, state in zip(loaded, start)]
        left = []
        for mode in free:
            seen = [product(mode, other, case.free.joints) for other in loaded]
            left.append(tuple(sum(s * state[i] for s, state in zip(seen, held)) / mode.mass for i in (0, 1)))
    rows = []
    for j in range(1, SAMPLES):
        t = mpf(response["duration"]) * j / SAMPLES / case.time
        late = release is not None and t >= release
        modes, states_at_start, since = (free, left, t - release) if late else (loaded, start, t)
        for p, xi in enumerate(POINTS):
            value = sum(flow(mode, damping_of(case, mode), *state, since)[0] * mode.at(xi)[0]
                        for mode, state in zip(modes, states_at_start))
            rows.append((number, p, j, value * speed * case.time))
    print(number, "done", file=sys.stderr, flush=True)
    return rows


def main():
    with Pool(2) as pool:
        rows = [row for part in pool.imap(rows_of, range(SCENES)) for row in part]
    write_table("piece_responses.txt", """Displacement (m) of the scenes of piece_scenes.py at its points, numbered from 0, and at
samples 1 ... of the record, with as many modes as the scenes count.""", ("scene", "point", "sample", "displacement"), rows)


if __name__ == "__main__":
    main()
