"""Writes contacts.txt: a mass that comes back to the paper's beam, with its contacts found by dense sampling at 30 digits.

Beam modes and mass are separate oscillators between contacts. A contact that lasts is the flow of beam and mass under
v_tip = y, by the eigenvectors of the symmetric problem that eliminates the mass. Rebounds are left out, as the program
documents, once their separation times the time that they all take together is below 1e-12 of V times the record.
"""

from mpmath import cos, diag, eigsy, findroot, matrix, mp, mpf, sin, sqrt, zeros

from beam import PaperBeam, Shape, use_digits
from table import write_table

GAMMA, OMEGA, DURATION = mpf(0.2), 50.0, mpf(0.02)
PER_PERIOD = 20  # samples of the shortest period


class Flow:
    """Uncoupled coordinates q'' + s q = 0 from a state; s may be negative for the mass alone."""

    def __init__(self, squares, place, rate):
        self.squares, self.place, self.rate = squares, place, rate

    def at(self, time):
        out = []
        for s, q, v in zip(self.squares, self.place, self.rate):
            b = sqrt(mp.mpc(s))
            out.append(((q * cos(b * time) + v * sin(b * time) / b).real, (v * cos(b * time) - q * b * sin(b * time)).real))
        return out


def first_zero(signal, end, step):
    """The first fall to zero after 0, where the signal is zero and about to rise."""
    low = step / 50
    while signal(low) <= 0:
        low /= 4
        assert low > mpf(10) ** -20
    while low < end:
        high = min(low + min(step, low / 4), end)  # flights of a chain of contacts grow ever shorter
        if signal(high) < 0:
            return findroot(signal, (low, high), solver="anderson", tol=mpf(10) ** -70, verify=False)
        low = high
    return None


class Chain:
    """n modes of the beam and the mass; times in s, velocities over V."""

    def __init__(self, count, restitution):
        beam = PaperBeam()
        shapes = [Shape(k, 0.0) for k in range(1, count + 1)]
        self.e, self.n = mpf(restitution), count
        self.tip = [shape.tip for shape in shapes]
        self.squares = [beam.beta_squared(shape.alpha, OMEGA) for shape in shapes]
        self.step = 2 * mp.pi / sqrt(self.squares[-1]) / PER_PERIOD
        self.mobility = 1 / GAMMA + sum(t**2 for t in self.tip)
        impulse = (1 + self.e) / self.mobility
        self.q, self.v = [mpf(0)] * count, [t * impulse for t in self.tip]
        self.y, self.w = mpf(0), 1 - impulse / GAMMA
        self.time = mpf(0)

    def energy(self):
        beam = sum(v**2 + s * q**2 for q, v, s in zip(self.q, self.v, self.squares))
        return beam / 2 + GAMMA / 2 * (self.w**2 - mpf(OMEGA) ** 2 * self.y**2)

    def free(self):
        return Flow([*self.squares, -mpf(OMEGA) ** 2], [*self.q, self.y], [*self.v, self.w])

    def fly(self):
        flow = self.free()

        def gap(time):
            state = flow.at(time)
            return sum(t * part[0] for t, part in zip(self.tip, state)) - state[-1][0]

        time = first_zero(gap, DURATION - self.time, self.step)
        if time is None:
            return False
        self.take(flow.at(time), time)
        return True

    def take(self, state, time):
        self.q, self.v = [p[0] for p in state[:-1]], [p[1] for p in state[:-1]]
        self.y, self.w = state[-1]
        self.time += time

    def tip_rate(self):
        return sum(t * v for t, v in zip(self.tip, self.v))

    def strike(self):
        impulse = (1 + self.e) * (self.w - self.tip_rate()) / self.mobility
        self.v = [v + t * impulse for t, v in zip(self.tip, self.v)]
        self.w -= impulse / GAMMA

    def pull(self):
        return mpf(OMEGA) ** 2 * self.y + sum(t * s * q for t, s, q in zip(self.tip, self.squares, self.q))

    def sticks(self):
        if self.e == 0:
            return self.pull() > 0 or (self.pull() == 0 and self.time == 0)
        separation = self.tip_rate() - self.w
        if self.pull() <= 0:
            return False
        return separation * 2 * separation / self.pull() / (1 - self.e) <= mpf(10) ** -12 * DURATION

    def hold(self):
        """Move with the mass at the tip until the force on the tip falls to zero."""
        tip = matrix(self.tip)
        mass = matrix(mp.eye(self.n)) + GAMMA * tip * tip.T
        impulse = (self.w - self.tip_rate()) / self.mobility
        self.v = [v + t * impulse for t, v in zip(self.tip, self.v)]
        stiff = diag([s + mpf(OMEGA) ** 2 for s in self.squares])
        root = mp.cholesky(mass)
        inverse = root**-1
        values, vectors = eigsy(inverse * stiff * inverse.T)
        modes = inverse.T * vectors  # mass-orthonormal
        onto = modes.T * mass
        z, rate = onto * matrix(self.q), onto * matrix(self.v)
        flow = Flow([value - mpf(OMEGA) ** 2 for value in values], list(z), list(rate))

        def force(time):
            return GAMMA * sum(
                (tip.T * modes[:, k])[0] * values[k] * part[0] for k, part in enumerate(flow.at(time))
            )

        time = first_zero(force, DURATION - self.time, self.step)
        ended = time is not None
        time = time if ended else DURATION - self.time
        state = flow.at(time)
        q = modes * matrix([p[0] for p in state])
        v = modes * matrix([p[1] for p in state])
        y, w = (tip.T * q)[0], (tip.T * v)[0]
        self.take([*zip(q, v), (y, w)], time)
        return ended


def contacts(count, restitution, most):
    chain = Chain(count, restitution)
    held = chain.sticks() if chain.e == 0 else False
    for number in range(1, most + 1):
        if not held:
            if not chain.fly():
                return
            start, before = chain.time, chain.energy()
            chain.strike()
            held = chain.sticks()
        else:
            start, before = chain.time, chain.energy()
        ended = chain.hold() if held else True
        yield (count, float(restitution), number, start, chain.time, before, chain.energy())
        if not ended:
            return
        held = False


use_digits(40)
rows = [row for count, e, most in [(5, 0.2, 8), (5, 0.0, 6), (5, 0.9, 6), (2, 0.5, 6)]
        for row in contacts(count, e, most)]  # fmt: skip
write_table("contacts.txt", """
Contacts after the impact of the paper's beam alone, mass ratio 0.2 (binary64), 50 rad/s in plane, 1 m/s, record of 0.02 s:
start and end (s) of each, and the Jacobi energy of beam and mass before and after, masses over the beam's, velocities over
the approach velocity; `modes` and restitution `e` belong to the run
""", ["modes", "e", "number", "start", "end", "energy_before", "energy_after"], rows)
