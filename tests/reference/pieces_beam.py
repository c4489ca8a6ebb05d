"""Beams of uniform pieces with bodies, springs, shear and rotation: references by exponentials and dynamic stiffness.

Lengths in l; stiffness, mass and time in any units that belong together. In every piece the state (v, psi, M, N), N the
shear force, obeys v' = psi + s N, psi' = M/B, M' = -N - R rho psi, N' = -m lambda v: four exponentials e^(mu x), taken
from the end at which they are largest. Nothing here is shared with the program: complex exponentials instead of real
functions of either parity, a dense stiffness matrix instead of an elimination, digits instead of care.
"""

from dataclasses import dataclass, field

from mpmath import matrix, mp, mpc, mpf


@dataclass
class Piece:
    length: float
    stiffness: float = 1.0  # B = EI
    mass: float = 1.0  # m = rho A
    compliance: float = 0.0  # s = 1/(kappa G A)
    rotary: float = 0.0  # rho I


@dataclass
class Joint:
    """What is attached where a piece ends."""
    mass: float = 0.0
    inertia: float = 0.0
    stiffness: float = 0.0
    turning_stiffness: float = 0.0


@dataclass
class Beam:
    pieces: list
    joints: list  # one at the outer end of every piece
    root: tuple = (None, None)  # springs on v and psi; None is rigid
    omega: float = 0.0
    in_plane: int = 1
    waves: dict = field(default_factory=dict, repr=False)

    def loads(self, beta_squared):
        """lambda, with every translation, and rho, with the turning of sections."""
        spin = mpf(self.omega) ** 2
        return (beta_squared + spin, beta_squared) if self.in_plane else (beta_squared, beta_squared + spin)


def exponents(piece, lam, rho):
    """The four mu with the states (v, psi, M, N) of e^(mu x)."""
    b, m, s = mpf(piece.stiffness), mpf(piece.mass), mpf(piece.compliance)
    r = mpf(piece.rotary) * rho
    sigma = s * m * lam
    half = (r + sigma * b) / (2 * b)
    root = mp.sqrt(mpc(half * half + m * lam * (1 - s * r) / b))
    out = []
    for square in (-half - root, -half + root):
        mu = mp.sqrt(square)
        for sign in (mu, -mu):
            out.append((sign, (mpc(1), (square + sigma) / sign, b * (square + sigma), -m * lam / sign)))
    return out


def end_states(piece, lam, rho):
    """States at the near and the far end of the four exponentials, two lists of columns."""
    near, far = [], []
    for mu, state in exponents(piece, lam, rho):
        whole = mpf(piece.length)
        from_near, from_far = (mpf(0), whole) if mu.real <= 0 else (-whole, mpf(0))
        near.append([x * mp.exp(mu * from_near) for x in state])
        far.append([x * mp.exp(mu * from_far) for x in state])
    return near, far


def stiffness(piece, lam, rho):
    """Dynamic stiffness of a piece on (v, psi) at its near and far ends."""
    near, far = end_states(piece, lam, rho)
    d, f = matrix(4, 4), matrix(4, 4)
    for j in range(4):
        d[0, j], d[1, j], d[2, j], d[3, j] = near[j][0], near[j][1], far[j][0], far[j][1]
        f[0, j], f[1, j], f[2, j], f[3, j] = -near[j][3], -near[j][2], far[j][3], far[j][2]
    return (f * d ** -1).apply(mp.re)


def negative(a):
    """Number of negative eigenvalues of a symmetric matrix, by elimination."""
    a = a.copy()
    n, count = a.rows, 0
    for i in range(n):
        if a[i, i] < 0:
            count += 1
        for j in range(i + 1, n):
            if a[j, i] != 0:
                factor = a[j, i] / a[i, i]
                for k in range(i + 1, n):
                    a[j, k] -= factor * a[i, k]
    return count


def clamped_count(piece, k, lam, rho):
    """Modes of a piece with both ends clamped below the frequency, from those with hinged ends."""
    b, m, s = mpf(piece.stiffness), mpf(piece.mass), mpf(piece.compliance)
    r = mpf(piece.rotary) * rho
    sigma = s * m * lam
    half = (r + sigma * b) / (2 * b)
    inside = half * half + m * lam * (1 - s * r) / b
    hinged = 0
    if inside >= 0:
        high, low = half + mp.sqrt(inside), half - mp.sqrt(inside)
        turns = [int(mp.floor(mp.sqrt(z) * piece.length / mp.pi)) if z > 0 else 0 for z in (high, low)]
        if s * r > 1:
            hinged = turns[0] + turns[1] + 1 if lam > 0 else turns[0] + 1
        else:
            hinged = turns[0] if lam > 0 else turns[0] - turns[1]
    ends = matrix([[k[1, 1], k[1, 3]], [k[3, 1], k[3, 3]]])
    return hinged - negative(ends)


def count(beam, beta_squared):
    """Modes below beta^2 (Wittrick and Williams)."""
    lam, rho = beam.loads(beta_squared)
    n = len(beam.pieces)
    total = matrix(2 * n + 2, 2 * n + 2)
    below = 0
    for i, piece in enumerate(beam.pieces):
        k = stiffness(piece, lam, rho)
        below += clamped_count(piece, k, lam, rho)
        for a in range(4):
            for c in range(4):
                total[2 * i + a, 2 * i + c] += k[a, c]
        joint = beam.joints[i]
        total[2 * i + 2, 2 * i + 2] += mpf(joint.stiffness) - mpf(joint.mass) * lam
        total[2 * i + 3, 2 * i + 3] += mpf(joint.turning_stiffness) - mpf(joint.inertia) * beta_squared
    kept = list(range(2, 2 * n + 2))
    for place in (1, 0):
        if beam.root[place] is not None:
            total[place, place] += mpf(beam.root[place])
            kept.insert(0, place)
    kept.sort()
    reduced = matrix(len(kept), len(kept))
    for a, row in enumerate(kept):
        for c, column in enumerate(kept):
            reduced[a, c] = total[row, column]
    return below + negative(reduced)


def conditions(beam, beta_squared):
    """The pole-free matrix of all conditions on the amplitudes of the exponentials, rows of order one."""
    lam, rho = beam.loads(beta_squared)
    n = len(beam.pieces)
    a = matrix(4 * n, 4 * n)
    ends = [end_states(piece, lam, rho) for piece in beam.pieces]
    row = 0
    for place in (0, 1):
        for j in range(4):
            state = ends[0][0][j]
            spring = beam.root[place]
            a[row, j] = state[place] if spring is None else state[3 - place] - mpf(spring) * state[place]
        row += 1
    for i, joint in enumerate(beam.joints):
        load = mpf(joint.stiffness) - mpf(joint.mass) * lam
        turn = mpf(joint.turning_stiffness) - mpf(joint.inertia) * beta_squared
        for j in range(4):
            v, psi, moment, force = ends[i][1][j]
            left = [v, psi, moment + turn * psi, force + load * v]
            if i + 1 < n:
                right = ends[i + 1][0][j]
                for q in range(4):
                    a[row + q, 4 * i + j] = left[q]
                    a[row + q, 4 * i + 4 + j] = -right[q]
            else:
                a[row, 4 * i + j] = left[2]
                a[row + 1, 4 * i + j] = left[3]
        row += 4
    for r in range(4 * n):
        largest = max(abs(a[r, c]) for c in range(4 * n))
        for c in range(4 * n):
            a[r, c] /= largest
    return a


def bracket(beam, k, low, high):
    """Bisect until the count says that mode k alone is inside."""
    at_low, at_high = count(beam, low), count(beam, high)
    while at_high < k:
        high = high * 2 + 1
        at_high = count(beam, high)
    while at_low != k - 1 or at_high != k:
        if abs(high - low) < mpf(10) ** (10 - mp.dps) * abs(high):
            raise ArithmeticError("nearly double")
        middle = (low + high) / 2
        found = count(beam, middle)
        if found < k:
            low, at_low = middle, found
        else:
            high, at_high = middle, found
    return low, high


def root(beam, k, low, high):
    """beta^2 of mode k between low and high, from the determinant of the conditions."""
    low, high = bracket(beam, k, low, high)
    while high - low > mpf(10) ** -10 * abs(high):  # the determinant, which is complex, then hardly turns between them
        middle = (low + high) / 2
        low, high = (middle, high) if count(beam, middle) < k else (low, middle)

    def value(x):
        return mp.det(conditions(beam, x))

    scale = value(low)
    f = lambda x: mp.re(value(x) / scale)
    return ridder(f, low, high)


def ridder(f, low, high):
    f_low, f_high = f(low), f(high)
    assert f_low * f_high < 0, (low, high, f_low, f_high)
    last = None
    for _ in range(400):
        middle = (low + high) / 2
        f_middle = f(middle)
        step = (middle - low) * f_middle / mp.sqrt(f_middle**2 - f_low * f_high)
        new = middle + (step if f_low > f_high else -step)
        if last is not None and abs(new - last) <= mpf(10) ** (-45) * abs(new):
            return new
        last = new
        f_new = f(new)
        if f_new == 0:
            return new
        points = sorted([(low, f_low), (middle, f_middle), (new, f_new), (high, f_high)], key=lambda p: p[0])
        for (a, f_a), (b, f_b) in zip(points, points[1:]):
            if f_a * f_b <= 0:
                low, f_low, high, f_high = a, f_a, b, f_b
                break
    raise ArithmeticError("no convergence")


class Mode:
    """A mode from its beta^2: complex amplitudes of the exponentials, and what follows from them."""

    def __init__(self, beam, beta_squared):
        self.beam, self.square = beam, beta_squared
        lam, rho = beam.loads(beta_squared)
        self.waves = [exponents(piece, lam, rho) for piece in beam.pieces]
        a = conditions(beam, beta_squared)
        n = a.rows
        x = matrix([mp.mpf(1) / (3 + (7 * i) % 11) for i in range(n)])
        for _ in range(2):
            x = mp.lu_solve(a, x)
            x /= max(abs(value) for value in x)
        self.amplitude = [[x[4 * i + j] for j in range(4)] for i in range(len(beam.pieces))]
        # the factor that makes it real
        tip = max((self.state(i, f) for i in range(len(beam.pieces)) for f in (mpf(1) / 3, mpf(1))),
                  key=lambda s: abs(s[0]))[0]
        self.amplitude = [[value / tip for value in piece] for piece in self.amplitude]

    def state(self, i, fraction):
        """(v, psi, M, N) at a fraction of piece i."""
        piece = self.beam.pieces[i]
        x = mpf(piece.length) * fraction
        total = [mpc(0)] * 4
        for (mu, state), a in zip(self.waves[i], self.amplitude[i]):
            factor = a * mp.exp(mu * (x if mu.real <= 0 else x - mpf(piece.length)))
            total = [t + factor * s for t, s in zip(total, state)]
        return total

    def at(self, xi):
        """(v, psi, M, N) at a point of the beam."""
        xi = mpf(xi)
        for i, piece in enumerate(self.beam.pieces):
            if xi <= piece.length or i == len(self.beam.pieces) - 1:
                return [mp.re(s) for s in self.state(i, xi / piece.length)]
            xi -= piece.length
        raise ValueError

    def squares(self, i):
        """Integrals of v^2 and psi^2 over piece i."""
        length = mpf(self.beam.pieces[i].length)
        v2, psi2 = mpc(0), mpc(0)
        for (mu, one), a in zip(self.waves[i], self.amplitude[i]):
            for (nu, other), b in zip(self.waves[i], self.amplitude[i]):
                s = mu + nu
                start = (-mu * length if mu.real > 0 else 0) + (-nu * length if nu.real > 0 else 0)
                part = a * b * (mp.exp(start) * length if abs(s) * length < mpf(10) ** (-mp.dps // 2)
                                else (mp.exp(start + s * length) - mp.exp(start)) / s)
                v2 += part * one[0] * other[0]
                psi2 += part * one[1] * other[1]
        return mp.re(v2), mp.re(psi2)

    def masses(self):
        """Integral of v^2 over the beam, and the modal mass."""
        mean, mass = mpf(0), mpf(0)
        for i, (piece, joint) in enumerate(zip(self.beam.pieces, self.beam.joints)):
            v2, psi2 = self.squares(i)
            mean += v2
            v, psi = [mp.re(s) for s in self.state(i, mpf(1))[:2]]
            mass += piece.mass * v2 + piece.rotary * psi2 + joint.mass * v**2 + joint.inertia * psi**2
        return mean, mass
