"""A mass that comes back to the paper's beam, followed from contact to contact in a hundred digits.

Beam modes and mass are separate oscillators between contacts, with the exact sums of sines that belong to them. Zeros of the
gap are found by dense sampling, in binary64 where the gap is wide and in full precision near its start and where it nearly
closes, and then by Newton's method. Contacts that accumulate are followed until nothing is left of them in any digit; those
that the program does not list are those whose separation times the time that they all take together is below 1e-12 of the
approach velocity times the record. A contact that lasts is the flow of beam and mass under v_tip = y, by the eigenvectors of
the symmetric problem that eliminates the mass. With damping those modes are taken as uncoupled, by the model that the program
documents, from the first rebound on that is not listed.

Velocities are over the approach velocity, times in seconds, masses over the beam's.
"""

from dataclasses import dataclass

import numpy as np
from mpmath import cosh, exp, matrix, mp, mpf, sinh, sqrt

from beam import PaperBeam, Shape

PER_PERIOD = 24  # samples of the shortest period
BLOCK = 2048  # samples looked at together
UNSEEN = mpf("1e-12")  # of the record: rebounds that are not listed
WIDE = 1e-8  # of what the parts of a gap amount to: binary64 sees its sign
POINTS = (0.5, 1.0)


@dataclass(frozen=True)
class Scene:
    """Binary64 inputs, taken exactly."""

    modes: int
    mass_ratio: float
    restitution: float
    duration: float
    omega: float = 0.0  # in the plane of the motion
    damping_ratio: float = 0.0
    max_contacts: int = 100


@dataclass
class Contact:
    number: int
    start: mpf
    end: mpf
    energy_before: mpf
    energy_after: mpf
    impulse: mpf


class Flow:
    """Parts u'' + c u' + s u = 0 from a state, and sums of them."""

    def __init__(self, squares, damping, place, rate):
        self.squares, self.damping, self.place, self.rate = squares, damping, list(place), list(rate)
        self.turning = [s - c * c / 4 for s, c in zip(squares, damping)]
        self.roots = [sqrt(abs(t)) for t in self.turning]

    def at(self, time):
        """Displacements and velocities."""
        places, rates = [], []
        for s, c, turning, root, u, v in zip(self.squares, self.damping, self.turning, self.roots, self.place, self.rate):
            if turning > 0:
                co, si = mp.cos_sin(root * time)
                si = si / root
            elif turning < 0:
                co, si = cosh(root * time), sinh(root * time) / root
            else:
                co, si = mpf(1), time
            w = v + c * u / 2
            place, rate = u * co + w * si, w * co - turning * u * si
            if c:
                decay = exp(-c * time / 2)
                place, rate = decay * place, decay * rate - c * decay * place / 2
            places.append(place)
            rates.append(rate)
        return places, rates

    def accelerations(self, places, rates):
        return [-c * v - s * u for s, c, u, v in zip(self.squares, self.damping, places, rates)]


class Signal:
    """A weighted sum of displacements and velocities of a flow."""

    def __init__(self, flow, by_place, by_rate=None):
        self.flow, self.by_place = flow, by_place
        self.by_rate = by_rate or [mpf(0)] * len(by_place)

    def value_slope_size(self, time):
        """The sum, its rate, and what its parts amount to."""
        places, rates = self.flow.at(time)
        bends = self.flow.accelerations(places, rates)
        parts = [a * u + b * v for a, b, u, v in zip(self.by_place, self.by_rate, places, rates)]
        slope = sum(a * v + b * w for a, b, v, w in zip(self.by_place, self.by_rate, rates, bends))
        return sum(parts), slope, sum(abs(part) for part in parts)

    def value(self, time):
        return self.value_slope_size(time)[0]

    def start_values(self):
        """For binary64: squares, damping, displacement and velocity of every part of the sum."""
        flow = self.flow
        bends = flow.accelerations(flow.place, flow.rate)
        place = [a * u + b * v for a, b, u, v in zip(self.by_place, self.by_rate, flow.place, flow.rate)]
        rate = [a * v + b * w for a, b, v, w in zip(self.by_place, self.by_rate, flow.rate, bends)]
        return [np.array([float(x) for x in values]) for values in (flow.turning, flow.damping, place, rate)]

    def samples(self, times):
        """Sums and sizes of their parts in binary64."""
        turning, damping, place, rate = self.start_values()
        root = np.sqrt(np.abs(turning))[:, None]
        phase = root * times
        with np.errstate(over="ignore", invalid="ignore"):
            co = np.where(turning[:, None] > 0, np.cos(phase), np.cosh(phase))
            si = np.where(turning[:, None] > 0, np.sin(phase), np.sinh(phase)) / np.where(root > 0, root, 1)
        si = np.where(root > 0, si, times)
        parts = (place[:, None] * co + (rate + damping * place / 2)[:, None] * si) * np.exp(-damping[:, None] / 2 * times)
        return parts.sum(axis=0), np.abs(parts).sum(axis=0)

    def polish(self, low, high):
        """The zero between two times, positive before and negative after."""
        time = (low + high) / 2
        for _ in range(400):
            value, slope, size = self.value_slope_size(time)
            low, high = (time, high) if value > 0 else (low, time)
            step = -value / slope if slope < 0 else mpf(0)
            closer = time + step
            if slope >= 0 or not low <= closer <= high:
                step, closer = None, (low + high) / 2
            if step is not None and abs(step) < (time + size / -slope) * mpf(10) ** (4 - mp.dps):
                return closer
            if high - low < time * mpf(10) ** (6 - mp.dps):
                return closer
            time = closer
        raise ArithmeticError("no zero found")

    def lowest(self, low, high):
        """The least value between two times, by golden section and parabolas: the time."""
        for _ in range(60 + 3 * mp.dps):
            a, b = low + (high - low) * mpf("0.382"), low + (high - low) * mpf("0.618")
            fa, fb = self.value(a), self.value(b)
            if min(fa, fb) < 0:
                return a if fa < fb else b
            low, high = (low, b) if fa < fb else (a, high)
            if high - low < high * mpf(10) ** (-mp.dps // 2):
                break
        return (low + high) / 2

    def first_fall(self, end, step, first):
        """The first time at which the sum falls to zero, after `first`, by which it has risen above zero; None: never."""
        low = first
        value = self.value(low)
        assert value > 0
        sizes = self.samples(np.array([0.0, float(step), float(end)]))[1]
        while low < step or value < WIDE * sizes.max():
            high = min(low * mpf(5) / 4, low + step, end)
            after = self.value(high)
            if after <= 0:
                return self.polish(low, high)
            if high >= end:
                return None
            low, value = high, after
            if low > 40 * step:
                break
        while low < end:
            times = low + step * (np.arange(BLOCK + 2) - 1)  # mpf in an array
            inside = np.array([float(t) for t in times])
            values, sizes = self.samples(inside)
            unsure = np.abs(values) < WIDE * sizes
            for i in range(1, BLOCK + 1):
                if times[i + 1] <= low:
                    continue
                if unsure[i] or (i + 1 <= BLOCK and unsure[i + 1]):
                    values[i], values[i + 1] = float(self.value(times[i])), float(self.value(times[i + 1]))
                if times[i] > end:
                    return None
                if values[i] > 0 and values[i + 1] <= 0:
                    time = self.polish(max(times[i], low), times[i + 1])
                    return time if time <= end else None
                if i >= 1 and values[i] <= values[i - 1] and values[i] <= values[i + 1] and times[i - 1] >= low:
                    bend = values[i - 1] + values[i + 1] - 2 * values[i]
                    if values[i] < bend:  # the parabola through the three may dip below zero
                        lowest = self.lowest(times[i - 1], times[i + 1])
                        if self.value(lowest) < 0:
                            time = self.polish(times[i - 1], lowest)
                            return time if time <= end else None
            low = times[BLOCK + 1]
        return None


@dataclass(frozen=True)
class Mode:
    """A mode of the beam alone: β² + ω² (rad²/s²), tip value, modal mass, values at POINTS."""

    square: mpf
    tip: mpf
    inertia: mpf
    at_points: list


def paper_modes(count):
    """In closed form."""
    beam = PaperBeam()
    shapes = [Shape(k, 0.0) for k in range(1, count + 1)]
    return [Mode(beam.beta_squared(shape.alpha, 0.0), shape.tip, mpf(1), [shape.value(mpf(xi)) for xi in POINTS])
            for shape in shapes]  # fmt: skip


class Chain:
    """The motion of one scene, contact by contact; `modes` are those of the paper's beam unless others are given."""

    def __init__(self, scene, modes=None):
        modes = modes or paper_modes(scene.modes)
        self.scene, self.n = scene, scene.modes
        elastic = [mode.square for mode in modes]
        self.omega2 = mpf(scene.omega) ** 2
        self.gamma, self.e, self.duration = mpf(scene.mass_ratio), mpf(scene.restitution), mpf(scene.duration)
        self.squares = [value - self.omega2 for value in elastic]
        self.damping = [2 * mpf(scene.damping_ratio) * sqrt(value) for value in elastic]
        self.tip, self.inertia = [mode.tip for mode in modes], [mode.inertia for mode in modes]
        self.mobility = 1 / self.gamma + sum(t**2 / m for t, m in zip(self.tip, self.inertia))
        self.fastest = sqrt(elastic[-1])
        self.step = 2 * mp.pi / self.fastest / PER_PERIOD
        self.q, self.v = [mpf(0)] * self.n, [mpf(0)] * self.n
        self.y, self.w, self.time = mpf(0), mpf(1), mpf(0)
        self.courses = []  # start, flow, shapes of its coordinates at POINTS
        self.at_points = [mode.at_points for mode in modes]
        self.strike()

    def energy(self):
        beam = sum(m * (v**2 + s * q**2) for q, v, s, m in zip(self.q, self.v, self.squares, self.inertia))
        return beam / 2 + self.gamma / 2 * (self.w**2 - self.omega2 * self.y**2)

    def free(self):
        return Flow([*self.squares, -self.omega2], [*self.damping, mpf(0)], [*self.q, self.y], [*self.v, self.w])

    def gap(self):
        return Signal(self.free(), [*self.tip, mpf(-1)])

    def tip_rate(self):
        return sum(t * v for t, v in zip(self.tip, self.v))

    def strike(self):
        """A blow with restitution; its impulse."""
        impulse = (1 + self.e) * (self.w - self.tip_rate()) / self.mobility
        self.v = [v + t * impulse / m for t, v, m in zip(self.tip, self.v, self.inertia)]
        self.w -= impulse / self.gamma
        return impulse

    def derivatives(self):
        """Of the gap, from the first to the third."""
        flow = self.free()
        weights = [*self.tip, mpf(-1)]
        second = flow.accelerations(flow.place, flow.rate)
        third = flow.accelerations(flow.rate, second)
        return [sum(w * x for w, x in zip(weights, values)) for values in (flow.rate, second, third)]

    def sticks(self):
        """Whether further rebounds would stay unseen."""
        separation, bend, jerk = self.derivatives()
        if self.e == 0:
            return bend < 0 or (bend == 0 and jerk < 0)
        if bend >= 0 or self.e == 1:
            return False
        rest = 2 * separation / -bend / (1 - self.e)
        return separation * rest <= UNSEEN * self.duration and abs(jerk) * rest <= -bend / 2

    def take(self, places, rates, time):
        self.q, self.v = places[:-1], rates[:-1]
        self.y, self.w = places[-1], rates[-1]
        self.time += time

    def keep_course(self, flow=None, at_points=None):
        self.courses.append((self.time, flow or self.free(), at_points or [*self.at_points, [mpf(0)] * len(POINTS)]))

    def fly(self, opening):
        """To the next contact; False where there is none in the record."""
        gap = self.gap()
        first = self.step / 50
        separation, bend, _ = self.derivatives()
        if opening == 1 and bend < 0:
            first = min(first, separation / -bend / 2)
        while gap.value(first) <= 0:
            first /= 4
            assert first > mpf(10) ** -50
        end = self.duration - self.time
        time = gap.first_fall(end, self.step, first) if first < end else None
        if time is None:
            return False
        self.take(*gap.flow.at(time), time)
        return True

    def come_to_rest(self):
        """The rebounds that are left out: until nothing of them is left."""
        impulse = mpf(0)
        while self.e > 0:
            separation, bend, _ = self.derivatives()
            rest = 2 * separation / -bend / (1 - self.e)
            if separation * (self.fastest * rest) ** 2 < mpf(10) ** (-mp.dps * 2 // 3):
                break
            gap = self.gap()
            self.keep_course()
            time = gap.polish(separation / -bend, 4 * separation / -bend)
            self.take(*gap.flow.at(time), time)
            impulse += self.strike()
        return impulse

    def hold(self):
        """Move with the mass at the tip until it is no longer pressed; whether that is before the record ends, and the impulse."""
        tip = matrix(self.tip)
        inertia = mp.diag(self.inertia)
        mass = inertia + self.gamma * tip * tip.T
        before = self.w
        stiff = inertia * mp.diag([s + self.omega2 for s in self.squares])
        inverse = mp.cholesky(mass) ** -1
        values, vectors = mp.eigsy(inverse * stiff * inverse.T)
        modes = inverse.T * vectors  # mass-orthonormal
        onto = modes.T
        # projection with the weight of both, as a blow without rebound leaves it
        z = onto * (inertia * matrix(self.q) + self.gamma * self.y * tip)
        rate = onto * (inertia * matrix(self.v) + self.gamma * self.w * tip)
        damping = [sum(c * m * modes[i, k] ** 2 for i, (c, m) in enumerate(zip(self.damping, self.inertia)))
                   for k in range(self.n)]  # fmt: skip
        flow = Flow([value - self.omega2 for value in values], damping, list(z), list(rate))
        at_tip = [sum(tip[i] * modes[i, k] for i in range(self.n)) for k in range(self.n)]
        # what presses: the acceleration with which the gap would close without it
        by_place = [sum(tip[i] * self.squares[i] * modes[i, k] for i in range(self.n)) + self.omega2 * at_tip[k]
                    for k in range(self.n)]  # fmt: skip
        by_rate = [sum(tip[i] * self.damping[i] * modes[i, k] for i in range(self.n)) for k in range(self.n)]
        force = Signal(flow, by_place, by_rate)
        first = self.step / 50
        while force.value(first) <= 0:
            first /= 4
            assert first > mpf(10) ** -50
        end = self.duration - self.time
        self.keep_course(flow, [[sum(modes[i, k] * self.at_points[i][p] for i in range(self.n)) for p in range(len(POINTS))]
                                for k in range(self.n)])  # fmt: skip
        time = force.first_fall(end, self.step, first)
        ended = time is not None
        time = time if ended else end
        places, rates = flow.at(time)
        q, v = modes * matrix(places), modes * matrix(rates)
        y, w = (tip.T * q)[0], (tip.T * v)[0]
        swept = self.swept(flow, at_tip, places, rates, time)
        self.take([*q, y], [*v, w], time)
        return ended, self.gamma * (before - w + self.omega2 * swept)

    @staticmethod
    def swept(flow, at_tip, places, rates, time):
        """The integral of the tip's displacement, by z = −(z'' + c z')/s."""
        total = mpf(0)
        for s, c, t, z, v, z0, v0 in zip(flow.squares, flow.damping, at_tip, places, rates, flow.place, flow.rate):
            total += t * -((v - v0) + c * (z - z0)) / s
        return total

    def contacts(self):
        """Every contact after the impact."""
        held, opening = self.sticks() if self.e == 0 else False, 1 if self.e > 0 else 2
        start, before, impulse = self.time, self.energy(), mpf(0)
        number = 0
        if not held:
            self.keep_course()
        while True:
            if not held:
                if not self.fly(opening) or number == self.scene.max_contacts:
                    return
                start, before = self.time, self.energy()
                impulse = self.strike()
                held = self.sticks()
            number += 1
            ended, opening = True, 1 if self.e > 0 else 2
            if held:
                if not self.scene.damping_ratio:
                    impulse += self.come_to_rest()
                ended, more = self.hold()
                impulse, opening, held = impulse + more, 3, False
            if ended:
                self.keep_course()
            yield Contact(number, start, self.time, before, self.energy(), impulse)
            if not ended:
                return

    def displacements(self, times):
        """At POINTS, after the contacts have been followed."""
        rows = []
        for time in times:
            start, flow, at_points = next(course for course in reversed(self.courses) if course[0] <= time)
            places, _ = flow.at(time - start)
            rows.append([sum(u * shape[p] for u, shape in zip(places, at_points)) for p in range(len(POINTS))])
        return rows

    def velocities(self, times):
        """The same of the velocity."""
        rows = []
        for time in times:
            start, flow, at_points = next(course for course in reversed(self.courses) if course[0] <= time)
            _, rates = flow.at(time - start)
            rows.append([sum(u * shape[p] for u, shape in zip(rates, at_points)) for p in range(len(POINTS))])
        return rows
