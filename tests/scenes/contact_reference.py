"""The motion of a clamped beam and a mass that touches it for some time, by an integration of its own, also under loads.

The model is that of `&contact` with a count of modes n: v(x) = sum of n modes + R(x) F, with the residual flexibility R of all others, and
F = K d^p (1 + c d') for the indentation d = y - v(x0) > 0. In contact scipy's DOP853 (with damping, where F is stiff, Radau) integrates
modes and mass; between contacts every oscillator moves exactly, and the gap is sampled 40 times in a period of the highest mode. Loads are
constant, linear or harmonic in pieces; modes beyond n follow them at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from closed_form import roots, shapes
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq, minimize_scalar

BEYOND = 400  # modes, whose residual flexibility differs from that of a beam that does not rotate
FINE = 0.15  # of a radian of the highest mode between samples of the gap
CHUNK = 4096  # samples of it
MOST_STEPS = 100_000  # of an integration


class TooLongError(Exception):
    """The integration takes too many steps."""


@dataclass
class Piece:
    """a + b s + Re(c exp(i w s)), s the time since the begin; 0 from the end on."""

    begin: float
    end: float
    a: float
    b: float
    c: complex
    w: float


@dataclass
class Load:
    """A force, N, at a place; without one the frame's acceleration, as the force -a times the beam's mass."""

    position: float | None
    pieces: list[Piece]


@dataclass
class Blow:
    """A scene in SI units."""

    length: float
    mass_per_length: float
    bending_stiffness: float
    modes: int
    mass: float
    position: float
    speed: float  # > 0
    stiffness: float
    exponent: float
    contact_damping: float
    ratio: float  # modal damping
    omega: float
    in_plane: bool
    points: list[float]
    times: np.ndarray  # of the histories
    duration: float
    most_contacts: int
    pulled: tuple[float, float] | None = None  # a force and its place, whose static deflection is let go
    loads: list[Load] = field(default_factory=list)


@dataclass
class Motion:
    """Contacts and histories (points, times), which end where more contacts begin than were asked for."""

    start: list[float] = field(default_factory=list)
    end: list[float] = field(default_factory=list)
    impulse: list[float] = field(default_factory=list)
    largest: list[float] = field(default_factory=list)
    displacement: list[np.ndarray] = field(default_factory=list)
    velocity: list[np.ndarray] = field(default_factory=list)
    bending_moment: list[np.ndarray] = field(default_factory=list)
    steps: int = 0


class Bodies:
    """Modes and mass as oscillators u'' + c u' + b u = w F; the indentation is that of `weight` times u, less R F."""

    def __init__(self, blow: Blow) -> None:
        length, ei, rho = blow.length, blow.bending_stiffness, blow.mass_per_length
        alpha = roots(BEYOND, 0.0)
        elastic = ei / rho * (alpha / length) ** 4
        turning = blow.omega**2 if blow.in_plane else 0.0
        n = blow.modes
        here = shapes(alpha, [blow.position])[0]
        heavy = rho * length
        self.blow, self.n = blow, n
        self.square = np.append(elastic[:n] - turning, -turning)
        self.damping = np.append(2 * blow.ratio * np.sqrt(elastic[:n]), 0.0)
        self.weight = np.append(-here[:n], 1.0)
        self.drive = np.append(here[:n] / heavy, -1 / blow.mass)

        def residual(xi: float, order: int) -> float:
            there = shapes(alpha, [xi], order)[0]
            a, unit = blow.position, length**3 / ei
            if order == 0:
                low, high = min(a, xi), max(a, xi)
                rest = unit * low**2 * (3 * high - low) / 6
            else:
                rest = unit * max(0.0, a - xi)
            parts = there * here / heavy
            return rest - np.sum(parts[:n] / elastic[:n]) + np.sum((parts * turning / (elastic * (elastic - turning)))[n:])

        self.residual = residual(blow.position, 0)
        self.seen = shapes(alpha[:n], blow.points)
        self.curved = shapes(alpha[:n], blow.points, 2) * ei / length**2
        self.seen_residual = np.array([residual(xi, 0) for xi in blow.points])
        self.curved_residual = np.array([residual(xi, 2) for xi in blow.points]) * ei / length**2
        self.root = np.sqrt(self.damping.astype(complex) ** 2 / 4 - self.square)
        grows = (np.sin(alpha) - np.cos(alpha) - np.exp(-alpha)) / (0.5 - 0.5 * np.exp(-2 * alpha) + np.sin(alpha) * np.exp(-alpha))
        carried = -2 * (1 - grows * np.exp(-alpha)) / alpha  # the integral of each mode

        def beyond(load: Load, xi: float, order: int) -> float:
            """What modes that are not summed add to deflection or curvature under a load of 1."""
            there, a, unit = shapes(alpha, [xi], order)[0], load.position, length**3 / ei
            if a is None:
                rest = unit * (xi**2 * (6 - 4 * xi + xi**2) / 24 if order == 0 else (1 - xi) ** 2 / 2)
                parts = there * carried / heavy
            else:
                low, high = min(a, xi), max(a, xi)
                rest = unit * (low**2 * (3 * high - low) / 6 if order == 0 else max(0.0, a - xi))
                parts = there * shapes(alpha, [a])[0] / heavy
            return rest - np.sum(parts[:n] / elastic[:n]) + np.sum((parts * turning / (elastic * (elastic - turning)))[n:])

        loads = blow.loads
        self.driven = np.zeros((n + 1, len(loads)))
        for i, load in enumerate(loads):
            self.driven[:n, i] = (carried if load.position is None else shapes(alpha, [load.position])[0])[:n] / heavy
            self.driven[n, i] = 1 / heavy if load.position is None else 0.0
        self.opens = np.array([beyond(load, blow.position, 0) for load in loads])
        self.seen_loads = np.array([[beyond(load, xi, 0) for load in loads] for xi in blow.points])
        self.curved_loads = np.array([[beyond(load, xi, 2) * ei / length**2 for load in loads] for xi in blow.points])
        self.knots = np.unique([t for load in loads for piece in load.pieces for t in (piece.begin, piece.end)] + [np.inf])
        self.first = np.zeros(n + 1)
        if blow.pulled:
            self.first[:n] = blow.pulled[0] * shapes(alpha[:n], [blow.pulled[1]])[0] / (heavy * self.square[:n])
            self.first[n] = here[:n] @ self.first[:n]

    def next_knot(self, t: float) -> float:
        return float(self.knots[self.knots > t * (1 + 1e-14)][0])

    def pieces(self, t: float) -> list[Piece]:
        """Of each load, the one that acts from a time on."""
        t *= 1 + 1e-14
        return [next((p for p in load.pieces if p.begin <= t < p.end), Piece(0, 0, 0, 0, 0, 0)) for load in self.blow.loads]

    def loads(self, pieces: list[Piece], t: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """Loads and their rates, (loads,) or (loads, times)."""
        value = [p.a + p.b * (t - p.begin) + np.real(p.c * np.exp(1j * p.w * (t - p.begin))) for p in pieces]
        rate = [p.b + 0 * t + np.real(1j * p.w * p.c * np.exp(1j * p.w * (t - p.begin))) for p in pieces]
        return np.array(value), np.array(rate)

    def particular(self, pieces: list[Piece], t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """One motion under the loads, (oscillators, times), and its rate."""
        moved = np.zeros((self.n + 1, len(t)))
        rate = np.zeros_like(moved)
        square, c = self.square[:, None], self.damping[:, None]
        held = square != 0
        safe = np.where(held, square, 1.0)
        for piece, driven in zip(pieces, self.driven.T):
            s = t - piece.begin
            line = np.where(held, (piece.a + piece.b * s - c * piece.b / safe) / safe, piece.a * s**2 / 2 + piece.b * s**3 / 6)
            slope = np.where(held, piece.b / safe, piece.a * s + piece.b * s**2 / 2)
            if piece.c:
                tone = piece.c * np.exp(1j * piece.w * s) / (square - piece.w**2 + 1j * piece.w * c)
                line, slope = line + tone.real, slope + (1j * piece.w * tone).real
            moved += driven[:, None] * line
            rate += driven[:, None] * slope
        return moved, rate

    def move(self, u: np.ndarray, v: np.ndarray, t: float, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As `free`, under the loads, from a time on up to the next knot."""
        if not self.blow.loads:
            return self.free(u, v, after)
        pieces = self.pieces(t)
        start, start_rate = self.particular(pieces, np.array([t]))
        moved, rate = self.free(u - start[:, 0], v - start_rate[:, 0], after)
        with_loads, with_rate = self.particular(pieces, t + after)
        return moved + with_loads, rate + with_rate

    def free(self, u: np.ndarray, v: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements and velocities of all oscillators after times without a force, (oscillators, times)."""
        half, s = self.damping[:, None] / 2, self.root[:, None]
        small = np.abs(s) < 1e-300
        s = np.where(small, 1e-300, s)
        decay = np.exp(-half * times)
        c, d = np.cosh(s * times), np.sinh(s * times) / s
        d = np.where(small, times, d)
        first, second = u[:, None], v[:, None]
        moved = decay * (c * first + d * (second + half * first))
        rate = decay * (c * second - d * (half * second + self.square[:, None] * first))
        return moved.real, rate.real


class Contact:
    """An undamped contact, state (u, v, impulse)."""

    def __init__(self, bodies: Bodies) -> None:
        self.bodies, self.blow, self.m = bodies, bodies.blow, bodies.n + 1
        slowness = 1 / np.sqrt(np.max(np.abs(bodies.square)))
        amplitude = np.hypot(bodies.first * np.sqrt(np.abs(bodies.square)), np.append(np.zeros(bodies.n), self.blow.speed))
        speed = np.full(self.m, max(self.blow.speed, float(np.linalg.norm(bodies.weight * amplitude))))
        self.act(0.0)
        self.scale = np.concatenate([speed * slowness, speed, [self.blow.mass * self.blow.speed]])

    def act(self, t: float) -> None:
        """Loads are those from a time on, also where an integration looks beyond their end."""
        self.pieces = self.bodies.pieces(t)

    def closes(self, t: float) -> tuple[float, float]:
        """What loads add to the approach at once, and to its rate."""
        if not self.pieces:
            return 0.0, 0.0
        value, rate = self.bodies.loads(self.pieces, t)
        return -float(self.bodies.opens @ value), -float(self.bodies.opens @ rate)

    def begin(self, t: float, state: np.ndarray) -> tuple[float, np.ndarray]:
        return t, state

    def solver(self, t: float, state: np.ndarray, bound: float, step: float | None) -> DOP853 | Radau:
        first = None if step is None else min(step, bound - t)
        return DOP853(self.slope, t, state, bound, first_step=first, rtol=1e-13, atol=1e-16 * self.scale)

    def presses(self, t: float, state: np.ndarray) -> float:
        """Positive while the contact lasts."""
        return float(self.bodies.weight @ state[: self.m]) + self.closes(t)[0]

    def force(self, t: float, state: np.ndarray) -> float:
        """F = K (approach - R F)^p by Newton's method for the depth."""
        approach = self.presses(t, state)
        if approach <= 0:
            return 0.0
        p, flexible = self.blow.exponent, self.bodies.residual * self.blow.stiffness
        depth = min(approach, (approach / flexible) ** (1 / p))
        for _ in range(60):
            change = (depth + flexible * depth**p - approach) / (1 + flexible * p * depth ** (p - 1))
            depth -= change
            if abs(change) <= 4e-16 * depth:
                break
        return float(self.blow.stiffness * depth**p)

    def force_rate(self, t: float, state: np.ndarray) -> float:
        force = self.force(t, state)
        if force <= 0:
            return 0.0
        slope = self.blow.exponent * force / (self.presses(t, state) - self.bodies.residual * force)
        return float(slope * (self.bodies.weight @ state[self.m : 2 * self.m] + self.closes(t)[1]) / (1 + slope * self.bodies.residual))

    def slope(self, t: float, state: np.ndarray) -> np.ndarray:
        return self.slope_of(t, state, self.force(t, state))

    def slope_of(self, t: float, state: np.ndarray, force: float) -> np.ndarray:
        u, v = state[: self.m], state[self.m : 2 * self.m]
        rate = self.bodies.drive * force - self.bodies.damping * v - self.bodies.square * u
        if self.pieces:
            rate = rate + self.bodies.driven @ self.bodies.loads(self.pieces, t)[0]
        return np.concatenate([v, rate, [force]])

    def remaining(self, _: float, __: np.ndarray) -> float:
        """Time from the last state to the end."""
        return 0.0


class DampedContact(Contact):
    """A damped one, state (u, v, impulse, F): the law of the contact gives the rate of the depth d = approach - R F, and with it that of F."""


    def __init__(self, bodies: Bodies) -> None:
        super().__init__(bodies)
        self.scale = np.append(self.scale, self.blow.stiffness * self.deep(self.blow.speed) ** self.blow.exponent)

    def deep(self, speed: float) -> float:
        """The largest depth of an undamped contact with a wall."""
        b = self.blow
        return float(((b.exponent + 1) / 2 * b.mass * speed**2 / b.stiffness) ** (1 / (b.exponent + 1)))

    def begin(self, t: float, state: np.ndarray) -> tuple[float, np.ndarray]:
        """A little way in, with the force K (wt)^p (1 + c w) of a constant rate of approach w."""
        w = float(self.bodies.weight @ state[self.m : 2 * self.m]) + self.closes(t)[1]
        self.shallow = 1e-12 ** (1 / (self.blow.exponent + 1)) * self.deep(w)  # 1e-12 of the impulse is further out
        ahead = 2 * self.shallow / w
        moved, rates = self.bodies.move(state[: self.m], state[self.m : 2 * self.m], t, np.array([ahead]))
        force = self.blow.stiffness * (w * ahead) ** self.blow.exponent * (1 + self.blow.contact_damping * w)
        return t + ahead, np.concatenate([moved[:, 0], rates[:, 0], [0.0, force]])

    def solver(self, t: float, state: np.ndarray, bound: float, step: float | None) -> DOP853 | Radau:
        first = None if step is None else min(step, bound - t)
        return Radau(self.slope, t, state, bound, first_step=first, rtol=1e-10, atol=1e-13 * self.scale, jac=self.jacobian)

    def depth(self, t: float, state: np.ndarray) -> float:
        return float(self.bodies.weight @ state[: self.m] - self.bodies.residual * state[-1]) + self.closes(t)[0]

    def presses(self, t: float, state: np.ndarray) -> float:
        return self.depth(t, state) - self.shallow

    def force(self, t: float, state: np.ndarray) -> float:
        return float(state[-1])

    def force_rate(self, t: float, state: np.ndarray) -> float:
        return float(self.slope(t, state)[-1])

    def flexible(self, t: float, state: np.ndarray) -> float:
        """c R K d^p, which is kept above 0 in trial steps."""
        depth = max(self.depth(t, state), 0.1 * self.shallow)
        return self.blow.contact_damping * self.bodies.residual * self.blow.stiffness * depth**self.blow.exponent

    def slope(self, t: float, state: np.ndarray) -> np.ndarray:
        rate = self.bodies.weight @ state[self.m : 2 * self.m] + self.closes(t)[1] + 1 / self.blow.contact_damping
        return np.append(self.slope_of(t, state, state[-1]), rate / self.bodies.residual - state[-1] / self.flexible(t, state))

    def jacobian(self, t: float, state: np.ndarray) -> np.ndarray:
        m, by_depth = self.m, self.blow.exponent * state[-1] / self.flexible(t, state) / max(self.depth(t, state), 0.1 * self.shallow)
        matrix = np.zeros((2 * m + 2, 2 * m + 2))
        matrix[:m, m : 2 * m] = np.eye(m)
        matrix[m : 2 * m, :m] = -np.diag(self.bodies.square)
        matrix[m : 2 * m, m : 2 * m] = -np.diag(self.bodies.damping)
        matrix[m : 2 * m, -1] = self.bodies.drive
        matrix[2 * m, -1] = 1.0
        matrix[-1, :m] = by_depth * self.bodies.weight
        matrix[-1, m : 2 * m] = self.bodies.weight / self.bodies.residual
        matrix[-1, -1] = -1 / self.flexible(t, state) - by_depth * self.bodies.residual
        return matrix

    def remaining(self, t: float, state: np.ndarray) -> float:
        """Without the force, which is as good as gone."""
        weight, (closes, rate) = self.bodies.weight, self.closes(t)
        return float(max(0.0, -(weight @ state[: self.m] + closes) / (weight @ state[self.m : 2 * self.m] + rate)))


def follow(blow: Blow) -> Motion:
    """All contacts of the record and the histories."""
    bodies, motion = Bodies(blow), Motion()
    u, v = bodies.first.copy(), np.zeros(bodies.n + 1)
    v[-1] = blow.speed
    t = 0.0
    closes, rate = Contact(bodies).closes(0.0)
    touches = closes > 0 or (closes == 0 and bodies.weight @ v + rate > 0)
    while True:
        if touches:
            motion.start.append(t)
            t, u, v = press(bodies, motion, t, u, v)
        touches = True
        parted = True
        while True:  # to the next contact, from knot to knot of the loads
            if t >= blow.duration:
                return motion
            left = min(blow.duration, bodies.next_knot(t)) - t
            ahead = next_contact(bodies, u, v, t, left, parted)
            until = t + (left if ahead is None else ahead)
            seen = len(motion.displacement)
            inside = blow.times[seen:][blow.times[seen:] <= until] - t
            if inside.size:
                moved, rates = bodies.move(u, v, t, inside)
                for column in range(inside.size):
                    see(bodies, motion, t, t + inside[column], moved[:, column], rates[:, column], 0.0, 0.0)
            moved, rates = bodies.move(u, v, t, np.array([until - t]))
            t, u, v = until, moved[:, 0], rates[:, 0]
            parted = False
            if ahead is not None:
                break
        if len(motion.start) == blow.most_contacts:
            return motion


def see(bodies: Bodies, motion: Motion, since: float, t: float, u: np.ndarray, v: np.ndarray, force: float, force_rate: float) -> None:
    """Keep a sample; the loads are those that have acted since a time."""
    n = bodies.n
    load, rate = bodies.loads(bodies.pieces(since), t)
    if not bodies.blow.loads:
        load = rate = np.zeros(0)
    motion.displacement.append(bodies.seen @ u[:n] + bodies.seen_residual * force + bodies.seen_loads @ load)
    motion.velocity.append(bodies.seen @ v[:n] + bodies.seen_residual * force_rate + bodies.seen_loads @ rate)
    motion.bending_moment.append(bodies.curved @ u[:n] + bodies.curved_residual * force + bodies.curved_loads @ load)


def next_contact(bodies: Bodies, u: np.ndarray, v: np.ndarray, t: float, left: float, parted: bool) -> float | None:
    """When the approach is positive again, in time from now; the bodies have just parted, or are apart."""
    pieces = bodies.pieces(t)

    def approach(times: np.ndarray) -> np.ndarray:
        found = bodies.weight @ bodies.move(u, v, t, times)[0]
        return found - bodies.opens @ bodies.loads(pieces, t + times)[0] if pieces else found

    step = FINE / np.sqrt(np.max(np.abs(bodies.square)))
    from_there = 0.0
    if not parted and approach(np.array([0.0]))[0] > 0:
        return 0.0  # by a load that jumps
    while from_there < left:
        times = from_there + step * np.arange(CHUNK + 1)
        if from_there == 0:
            times = np.concatenate([step * 0.5 ** np.arange(20, 0, -1), times[1:]])
        times = np.append(times[times < left], min(left, times[-1]))
        values = approach(times)
        if from_there == 0:  # what is left of the contact by rounding
            first = int(np.argmax(values < 0))
            times, values = times[first:], values[first:]
        i = int(np.argmax(values > 0)) if (values > 0).any() else len(times)
        middle = values[1:-1]
        bend = 2 * middle - values[:-2] - values[2:]
        for j in np.flatnonzero((bend > 0) & (middle >= values[:-2]) & (middle >= values[2:]) & (middle > -0.5 * bend)) + 1:
            if j >= i:
                break
            top = minimize_scalar(lambda x: -approach(np.array([x]))[0], bounds=(times[j - 1], times[j + 1]), method="bounded", options={"xatol": 1e-16})
            if top.fun < 0:
                return float(brentq(lambda x: approach(np.array([x]))[0], times[j - 1], top.x, xtol=1e-20, rtol=1e-15))
        if i < len(times):
            before = times[i - 1] if i > 0 else 0.0
            return float(brentq(lambda x: approach(np.array([x]))[0], before, times[i], xtol=1e-20, rtol=1e-15)) if i > 0 else 0.0
        from_there = times[-1]
    return None


def press(bodies: Bodies, motion: Motion, t: float, u: np.ndarray, v: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """One contact, to its end or to the last sample."""
    blow, m = bodies.blow, bodies.n + 1
    contact = (DampedContact if blow.contact_damping > 0 else Contact)(bodies)
    contact.act(t)
    state = np.concatenate([u, v, [0.0]])
    t, state = contact.begin(t, state)
    while len(motion.displacement) < len(blow.times) and blow.times[len(motion.displacement)] < t:
        see(bodies, motion, 0.0, 0.0, np.nan * u, np.nan * v, 0.0, 0.0)  # in the beginning that is left out
    largest, step, ended = 0.0, None, False
    while not ended and t < blow.duration:
        seen = len(motion.displacement)
        bound = min(float(blow.times[seen]) if seen < len(blow.times) else blow.duration, bodies.next_knot(t))
        before = contact.closes(t)[0]
        contact.act(t)
        if len(state) > 2 * m + 1:  # the depth does not jump where loads do
            state[-1] += (contact.closes(t)[0] - before) / bodies.residual
        solver = contact.solver(t, state, bound, step) if t < bound else None
        while solver and solver.status == "running" and not ended:
            solver.step()
            motion.steps += 1
            if motion.steps > MOST_STEPS:
                raise TooLongError
            if solver.status == "failed":
                raise RuntimeError("the reference did not converge")
            step = solver.h_abs
            largest = max(largest, contact.force(solver.t, solver.y))
            if contact.force_rate(t, state) > 0 >= contact.force_rate(solver.t, solver.y):
                path, words = solver.dense_output(), {"bounds": (t, solver.t), "method": "bounded", "options": {"xatol": 1e-16}}
                largest = max(largest, -minimize_scalar(lambda x: -contact.force(x, path(x)), **words).fun)
            ended = contact.presses(t, state) > 0 >= contact.presses(solver.t, solver.y)
            if ended:
                path = solver.dense_output()
                end = float(brentq(lambda x: contact.presses(x, path(x)), t, solver.t, xtol=1e-20, rtol=1e-15))
                solver = contact.solver(t, state, end, step)
                while solver.status == "running":
                    solver.step()
            t, state = solver.t, solver.y
        if not ended and seen < len(blow.times) and t >= blow.times[seen]:
            see(bodies, motion, t, t, state[:m], state[m : 2 * m], contact.force(t, state), contact.force_rate(t, state))
    motion.end.append(t + contact.remaining(t, state) if ended else t)
    motion.impulse.append(float(state[2 * m]))
    motion.largest.append(largest)
    moved, rates = bodies.move(state[:m], state[m : 2 * m], t, np.array([motion.end[-1] - t]))
    return motion.end[-1], moved[:, 0], rates[:, 0]
