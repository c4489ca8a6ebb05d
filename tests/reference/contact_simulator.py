"""A mass that comes back to the paper's beam, followed from contact to contact in a hundred digits.

Beam modes and mass are separate oscillators between contacts, with the exact sums of sines that belong to them
(`contact_flow.py`, which also finds the times at which the gap closes). Contacts that accumulate are followed until nothing is
left of them in any digit; those that the program does not list are those whose separation times the time that they all take
together is below 1e-12 of the approach velocity times the record. A contact that lasts is the flow of beam and mass under
v_tip = y, by the eigenvectors of the symmetric problem that eliminates the mass. With damping those modes are taken as
uncoupled, by the model that the program documents, from the first rebound on that is not listed.

Velocities are over the approach velocity, times in seconds, masses over the beam's.
"""

from dataclasses import dataclass

from mpmath import matrix, mp, mpf, sqrt

from beam import PaperBeam, Shape
from contact_flow import Flow, Signal

PER_PERIOD = 24  # samples of the shortest period
UNSEEN = mpf("1e-12")  # of the record: rebounds that are not listed
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
        return [self.at_all_points(time, 0) for time in times]

    def velocities(self, times):
        """The same of the velocity."""
        return [self.at_all_points(time, 1) for time in times]

    def at_all_points(self, time, order):
        """Displacements (order 0) or velocities (1) at POINTS, at one time."""
        start, flow, at_points = next(course for course in reversed(self.courses) if course[0] <= time)
        values = flow.at(time - start)[order]
        return [sum(u * shape[p] for u, shape in zip(values, at_points)) for p in range(len(POINTS))]
