"""A clamped beam that a mass strikes for some time while bodies come and leave, by an integration of its own.

Each configuration has modes of its own, from the frequency equation of two pieces with a mass and springs between them or at the tip.
Contacts and flights between two changes are those of `contact_reference`; a change is a projection by quadrature. In a contact the modes
that are not summed give way by R F, which a body that comes meets as a deflection, too. Units: those in which rho A = EI = length = 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import contact_reference as one
import numpy as np
from scipy.optimize import brentq

POINTS = 400  # of Gauss's rule in a piece


@dataclass(frozen=True)
class Body:
    """At one place for all of them."""

    position: float
    mass: float
    stiffness: float = 0.0
    turning_stiffness: float = 0.0
    velocity: float | None = None


def basis(a: float, low: float, high: float, x: np.ndarray, order: int) -> np.ndarray:
    """Four solutions of v'''' = a^4 v in a piece, none above 1, and their derivatives over a^order, (4, places)."""
    s, turn = a * (x - low), order * np.pi / 2
    return np.array([np.cos(s + turn), np.sin(s + turn), (-1) ** order * np.exp(-s), np.exp(a * (x - high))])


class Modes:
    """Of a beam with one body, or without."""

    def __init__(self, count: int, place: float, body: Body | None) -> None:
        self.place, self.body, self.count = place, body, count
        self.pieces = [(0.0, place), (place, 1.0)] if place < 1 else [(0.0, 1.0)]
        spacing = 0.02
        grid = np.arange(0.3, (count + 2) * np.pi, spacing)
        signs = [np.linalg.slogdet(self.matrix(a))[0] for a in grid]
        found = [brentq(lambda a: self.determinant(a, a0), a0, a0 + spacing, xtol=1e-15, rtol=1e-15)
                 for a0, s, t in zip(grid[:-1], signs[:-1], signs[1:]) if s != t]  # fmt: skip
        self.alpha = np.array(found[:count])
        vectors = []
        for a in self.alpha:
            _, __, v = np.linalg.svd(self.matrix(a))
            vectors.append(v[-1])
        self.vectors = np.array(vectors)
        self.nodes, self.weights = np.polynomial.legendre.leggauss(POINTS)
        self.x = np.concatenate([low + (high - low) * (self.nodes + 1) / 2 for low, high in self.pieces])
        self.dx = np.concatenate([(high - low) * self.weights / 2 for low, high in self.pieces])
        self.shape = self.at(self.x)
        here = self.at(np.array([place]))[:, 0]
        self.mass = self.shape**2 @ self.dx + (body.mass if body else 0.0) * here**2
        self.square = self.alpha**4

    def determinant(self, a: float, near: float) -> float:
        sign, size = np.linalg.slogdet(self.matrix(a))
        return sign * np.exp(size - np.linalg.slogdet(self.matrix(near))[1])

    def matrix(self, a: float) -> np.ndarray:
        """Conditions at the root, at the joint and at the tip."""
        n = 4 * len(self.pieces)
        matrix = np.zeros((n, n))

        def at(piece: int, x: float, order: int) -> np.ndarray:
            row = np.zeros(n)
            row[4 * piece : 4 * piece + 4] = basis(a, *self.pieces[piece], np.array([x]), order)[:, 0]
            return row

        body = self.body or Body(self.place, 0.0)
        last = len(self.pieces) - 1
        shear = lambda piece: (
            at(piece, self.place, 3) + (body.mass * a - body.stiffness / a**3) * at(piece, self.place, 0)
        )
        bend = lambda piece: at(piece, self.place, 2) + body.turning_stiffness / a * at(piece, self.place, 1)
        rows = [at(0, 0.0, 0), at(0, 0.0, 1)]
        if last == 1:
            rows += [at(0, self.place, k) - at(1, self.place, k) for k in (0, 1)]
            rows += [bend(0) - at(1, self.place, 2), shear(0) - at(1, self.place, 3), at(1, 1.0, 2), at(1, 1.0, 3)]
        else:
            rows += [bend(0), shear(0)]
        for i, row in enumerate(rows):
            matrix[i] = row
        return matrix

    def at(self, x: np.ndarray, order: int = 0) -> np.ndarray:
        """Shapes or their derivatives, (modes, places)."""
        values = np.zeros((self.count, len(x)))
        for piece, (low, high) in enumerate(self.pieces):
            inside = (x >= low) & (x <= high) if piece == 0 else (x > low)
            for k, a in enumerate(self.alpha):
                values[k, inside] = (
                    a**order * self.vectors[k, 4 * piece : 4 * piece + 4] @ basis(a, low, high, x[inside], order)
                )
        return values

    def residual(self, x0: float | None, x: np.ndarray, order: int = 0) -> np.ndarray:
        """What modes that are not summed give way by under a force of 1 at x0, or under 1 on every unit of mass."""

        def green(x: np.ndarray, x0: float, order: int = 0) -> np.ndarray:
            less = np.minimum(x, x0)
            if order == 1:
                return np.where(x < x0, x * (2 * x0 - x) / 2, x0**2 / 2)
            return less**2 * (3 * np.maximum(x, x0) - less) / 6

        def green_of_moment(x: np.ndarray, x0: float, order: int = 0) -> np.ndarray:
            if order == 1:
                return np.minimum(x, x0)
            return np.where(x < x0, x**2 / 2, x0 * (x - x0 / 2))

        body = self.body

        def free(x: np.ndarray, order: int = 0) -> np.ndarray:
            if x0 is not None:
                return green(x, x0, order)
            own = (3 * x - 3 * x**2 + x**3) / 6 if order == 1 else x**2 * (6 - 4 * x + x**2) / 24
            return own + body.mass * green(x, body.position, order) if body else own

        whole = free(x, order)
        if body and (body.stiffness or body.turning_stiffness):
            b, here = body.position, np.array([body.position])
            gives = np.array(
                [
                    [green(here, b)[0], green_of_moment(here, b)[0]],
                    [green(here, b, 1)[0], green_of_moment(here, b, 1)[0]],
                ]
            )
            stiff = np.diag([body.stiffness, body.turning_stiffness])
            there = np.array([free(here)[0], free(here, 1)[0]])
            pull = stiff @ np.linalg.solve(np.eye(2) + gives @ stiff, there)
            whole = whole - pull[0] * green(x, b, order) - pull[1] * green_of_moment(x, b, order)
        return whole - (self.driven(x0) / self.square) @ self.at(x, order)

    def driven(self, x0: float | None) -> np.ndarray:
        """Acceleration of each mode under a force of 1 there, or under 1 on every unit of mass."""
        if x0 is not None:
            return self.at(np.array([x0]))[:, 0] / self.mass
        own = self.shape @ self.dx
        if self.body:
            own = own + self.body.mass * self.at(np.array([self.place]))[:, 0]
        return own / self.mass


class Beside(one.Bodies):
    """Modes, an oscillator that holds the shape in which the beam rests, and the mass."""

    def __init__(self, blow: one.Blow, modes: Modes, rest: float, rest_seen: np.ndarray) -> None:
        points, n = np.array(blow.points), modes.count
        here = modes.at(np.array([blow.position]))[:, 0]
        self.blow, self.n = blow, n + 1
        self.square = np.concatenate([modes.square, [0.0, 0.0]])
        self.damping = np.zeros(n + 2)
        self.weight = np.concatenate([-here, [-rest, 1.0]])
        self.drive = np.concatenate([here / modes.mass, [0.0, -1 / blow.mass]])
        self.residual = modes.residual(blow.position, np.array([blow.position]))[0]
        self.seen = np.column_stack([modes.at(points).T, rest_seen])
        self.curved = 0 * self.seen
        self.seen_residual = modes.residual(blow.position, points)
        self.curved_residual = 0 * self.seen_residual
        self.root = np.sqrt(-self.square.astype(complex))
        loads = blow.loads
        self.driven = np.zeros((n + 2, len(loads)))
        self.seen_loads = self.curved_loads = np.zeros((len(points), len(loads)))
        self.opens = np.zeros(len(loads))
        for i, load in enumerate(loads):
            self.driven[:n, i] = modes.driven(load.position)
            self.driven[-1, i] = 1.0 if load.position is None else 0.0
            self.seen_loads[:, i] = modes.residual(load.position, points)
            self.opens[i] = modes.residual(load.position, np.array([blow.position]))[0]
        self.knots = np.unique([t for load in loads for piece in load.pieces for t in (piece.begin, piece.end)] + [np.inf])
        self.first = np.zeros(n + 2)


@dataclass
class Change:
    time: float
    body: Body | None  # that is there from then on
    comes: bool


def follow(blow: one.Blow, place: float, changes: list[Change], count: int, captures: bool = False) -> one.Motion:
    """Everything up to the end of the record; `changes` begin with a first configuration at time 0."""
    motion = one.Motion()
    sets: dict[Body | None, Modes] = {}
    points = np.array(blow.points)
    where, x0 = np.array([place]), np.array([blow.position])
    t, pressed, caught, held, held_seen = 0.0, True, False, 0.0, 0 * points
    terms: list[tuple[Modes, np.ndarray]] = []  # of the shape
    state = None
    for i, change in enumerate(changes):
        modes = sets.setdefault(change.body, Modes(count, place, change.body))
        if state is None:
            u, v, mass = np.zeros(count), np.zeros(count), [0.0, blow.speed]
        else:
            before, (u, v, mass), force, force_rate = state
            acting = [(blow.position, force, force_rate)]
            if blow.loads:
                values = bodies.loads(bodies.pieces(t * (1 - 1e-13)), t)
                acting += zip((load.position for load in blow.loads), *values)
            beyond = np.array(
                [[sum(before.residual(at, where, k)[0] * f[i] for at, *f in acting) for i in (0, 1)] for k in (0, 1)]
            )
            old = changes[i - 1].body
            gain = (change.body.mass if change.body else 0.0) - (old.mass if old else 0.0)
            whole = terms + [(before, u)]

            def see(parts: list[tuple[Modes, np.ndarray]]) -> np.ndarray:
                sums = np.zeros(count)
                for given, q in parts:
                    sums += modes.shape @ (modes.dx * (q @ given.at(modes.x)))
                    sums += (
                        modes.at(where)[:, 0] * (change.body.mass if change.body else 0.0) * (q @ given.at(where)[:, 0])
                    )
                return sums

            shape = modes.at(where)[:, 0]
            q = see(whole) + shape * max(0.0, gain) * beyond[0, 0]
            if any(f for _, f, _ in acting):  # what modes that were not summed give way by: three times as many of them
                wide = Modes(4 * count, place, before.body)
                gives = sum(f * wide.driven(at) for at, f, _ in acting) / wide.square
                gives[:count] = 0.0
                q += modes.shape @ (modes.dx * (gives @ wide.at(modes.x)))
            rate = see([(before, v)]) + shape * max(0.0, gain) * beyond[0, 1]
            speed = v @ before.at(where)[:, 0] + beyond[0, 1]
            if change.comes and change.body.velocity is not None:
                rate += shape * change.body.mass * (change.body.velocity - speed)
            q, rate = q / modes.mass, rate / modes.mass
            terms = []
            if change.comes and (change.body.stiffness or change.body.turning_stiffness):
                meets = sum(p @ given.at(where)[:, 0] for given, p in whole) + beyond[0, 0]
                turned = sum(p @ given.at(where, 1)[:, 0] for given, p in whole) + beyond[1, 0]
                pull = (
                    change.body.stiffness * meets * shape
                    + change.body.turning_stiffness * turned * modes.at(where, 1)[:, 0]
                )
                q = q - pull / (modes.mass * modes.square)
                terms = whole + [(modes, -q)]
            u, v = q, rate
        held = sum(p @ given.at(x0)[:, 0] for given, p in terms)
        held_seen = sum((given.at(points).T @ p for given, p in terms), 0 * points)
        until = changes[i + 1].time if i + 1 < len(changes) else blow.duration
        stage = replace(blow, duration=until, times=blow.times[blow.times < until])
        bodies = Beside(stage, modes, held, held_seen)
        one_u, one_v = np.concatenate([u, [1.0, mass[0]]]), np.concatenate([v, [0.0, mass[1]]])
        force = force_rate = 0.0
        parted = True
        if caught:
            while t < until:
                until_knot = min(until, bodies.next_knot(t))
                seen = len(motion.displacement)
                inside = stage.times[seen:][stage.times[seen:] <= until_knot] - t
                moved, rates = bodies.move(one_u, one_v, t, np.append(inside, until_knot - t))
                for column in range(inside.size):
                    one.see(bodies, motion, t, t + inside[column], moved[:, column], rates[:, column], 0.0, 0.0)
                t, one_u, one_v = until_knot, moved[:, -1], rates[:, -1]
            state = (modes, (one_u[:count], one_v[:count], [0.0, 0.0]), 0.0, 0.0)
            continue
        if captures:
            motion.start.append(t)
            t, one_u, one_v, force = catch(bodies, motion, t, one_u, one_v)
            caught = True
            changes.insert(i + 1, Change(t, Body(blow.position, blow.mass, velocity=one_v[-1]), True))
            state = (modes, (one_u[:count], one_v[:count], [one_u[-1], one_v[-1]]), force, 0.0)
            continue
        while t < until:
            if pressed:
                if not goes_on(motion):
                    motion.start.append(t)
                t, one_u, one_v = one.press(bodies, motion, t, one_u, one_v)
                contact = one.Contact(bodies)
                contact.act(t * (1 - 1e-13))
                whole_state = np.concatenate([one_u, one_v, [0.0]])
                pressed = t >= until
                if len(motion.end) > len(motion.start):  # one that went on
                    motion.impulse[-2:] = [sum(motion.impulse[-2:])]
                    motion.largest[-2:] = [max(motion.largest[-2:])]
                    motion.end[-2:] = motion.end[-1:]
                if pressed:
                    force, force_rate = contact.force(t, whole_state), contact.force_rate(t, whole_state)
                    motion.open = True
                    break
                motion.open = False
                parted = True
            left = min(until, bodies.next_knot(t)) - t
            ahead = one.next_contact(bodies, one_u, one_v, t, left, parted)
            stop = t + (left if ahead is None else ahead)
            seen = len(motion.displacement)
            inside = stage.times[seen:][stage.times[seen:] <= stop] - t
            moved, rates = bodies.move(one_u, one_v, t, np.append(inside, stop - t))
            for column in range(inside.size):
                one.see(bodies, motion, t, t + inside[column], moved[:, column], rates[:, column], 0.0, 0.0)
            t, one_u, one_v, pressed, parted = stop, moved[:, -1], rates[:, -1], ahead is not None, False
        t = until
        state = (modes, (one_u[:count], one_v[:count], [one_u[-1], one_v[-1]]), force, force_rate)
    return motion


def catch(bodies: Beside, motion: one.Motion, t: float, u: np.ndarray, v: np.ndarray) -> tuple:
    """To the largest indentation of a contact: when, the state and the force."""
    blow, m, contact = bodies.blow, bodies.n + 1, one.Contact(bodies)
    state = np.concatenate([u, v, [0.0]])
    while True:
        contact.act(t)
        seen = len(motion.displacement)
        bound = min(float(blow.times[seen]) if seen < len(blow.times) else blow.duration, bodies.next_knot(t))
        solver = contact.solver(t, state, bound, None) if t < bound else None
        while solver and solver.status == "running":
            solver.step()
            if contact.force(solver.t, solver.y) > 0 >= contact.force_rate(solver.t, solver.y):
                path = solver.dense_output()
                end = brentq(lambda x: contact.force_rate(x, path(x)), solver.t_old, solver.t, xtol=1e-20, rtol=1e-15)
                solver = contact.solver(t, state, end, None)
                while solver.status == "running":
                    solver.step()
                motion.end.append(end)
                motion.impulse.append(float(solver.y[2 * m]))
                motion.largest.append(contact.force(end, solver.y))
                return end, solver.y[:m], solver.y[m : 2 * m], contact.force(end, solver.y)
        if solver:
            t, state = solver.t, solver.y
        if seen < len(blow.times) and t >= blow.times[seen]:
            force, rate = contact.force(t, state), contact.force_rate(t, state)
            one.see(bodies, motion, t, t, state[:m], state[m : 2 * m], force, rate)


def goes_on(motion: one.Motion) -> bool:
    return getattr(motion, "open", False)
