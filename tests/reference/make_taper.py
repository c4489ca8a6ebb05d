"""Writes taper_modes.txt: modes of rotating beams that taper, by Ritz's method with powers of x, in 200 digits."""

from itertools import product
from multiprocessing import Pool
from typing import NamedTuple

from mpmath import mp, mpf

from table import write_table


class Case(NamedTuple):
    """A rectangle of sides b = 1 - c_b x, h = 1 - c_h x; units are l, EI and rho A at the root."""

    c_b: float
    c_h: float
    omega: float = 0.0
    hub: float = 0.0
    in_plane: int = 0
    mass: float = 0.0  # of a body at the tip, over rho A l of the root's section
    inertia: float = 0.0
    compliance: float = 0.0  # EI/(kappa G A l^2) of the root's section; 0: Euler and Bernoulli
    rotary: float = 0.0  # I/(A l^2) of it


CASES = [Case(*sides) for sides in [(0.0, 0.2), (0.4, 0.4), (0.8, 0.8), (-0.5, 0.3)]]
CASES += [Case(*sides, 5.0, 0.5, plane, *body) for sides, plane, body in
          product([(0.0, 0.2), (0.4, 0.4), (0.8, 0.8)], (0, 1), [(0.0, 0.0), (0.2, 0.01)])]
CASES += [Case(0.4, 0.6, 5.0, 0.5, plane, *body, 0.0025, 0.0008) for plane, body in product((0, 1), [(0.0, 0.0), (0.2, 0.01)])]
MODES = 6


def times(a, b):
    c = [mpf(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            c[i + j] += x * y
    return c


def linear(c):
    return [mpf(1), -mpf(c)]


def gram(weight, functions):
    """The matrix of the integrals of w f_i f_j from 0 to 1; a function is a coefficient and a power, or None."""
    n = len(functions)
    matrix = mp.zeros(n)
    for i in range(n):
        for j in range(i + 1):
            if functions[i] is None or functions[j] is None:
                continue
            (a, p), (b, q) = functions[i], functions[j]
            matrix[i, j] = matrix[j, i] = a * b * sum(w / (p + q + k + 1) for k, w in enumerate(weight))
    return matrix


def squares(case, count):
    """The first beta squared, in `count` functions of each kind."""
    h = linear(case.c_h)
    area = times(linear(case.c_b), h)
    second = times(area, times(h, h))
    omega2 = mpf(case.omega) ** 2
    pull = times(area, [mpf(case.hub), mpf(1)])  # T' = -omega^2 m (R + x)
    pull = [mpf(0)] + [c / (k + 1) for k, c in enumerate(pull)]
    tension = [-omega2 * c for c in pull]
    tension[0] += omega2 * (sum(pull) + mpf(case.mass) * (mpf(case.hub) + 1))
    thick = case.compliance > 0
    first = 1 if thick else 2
    v = [(mpf(1), first + j) for j in range(count)] + ([None] * count if thick else [])
    slope = [f and (f[0] * f[1], f[1] - 1) for f in v]
    if thick:
        psi = [None] * count + [(mpf(1), 1 + j) for j in range(count)]
        bend = [f and (f[0] * f[1], f[1] - 1) for f in psi]
    else:
        psi, bend = slope, [(f[0] * f[1], f[1] - 1) if f[1] else None for f in slope]
    n = len(v)
    tip = mp.matrix([0 if f is None else f[0] for f in v])
    tip_turn = mp.matrix([0 if f is None else f[0] for f in psi])
    moving = gram(area, v) + mpf(case.mass) * tip * tip.T
    turning = mpf(case.rotary) * gram(second, psi) if thick else mp.zeros(n)
    stiff = gram(second, bend) + gram(tension, slope)
    if thick:  # the angle of shear is v' - psi
        one, other = gram(area, slope), gram(area, psi)
        cross = mp.zeros(n)
        for i in range(count):
            for j in range(count):
                (a, p), (b, q) = slope[i], psi[count + j]
                cross[i, count + j] = cross[count + j, i] = a * b * sum(w / (p + q + k + 1) for k, w in enumerate(area))
        stiff += (one + other - cross) / mpf(case.compliance)
    if case.in_plane:
        stiff -= omega2 * moving
    else:
        stiff -= omega2 * turning
    mass = moving + turning + mpf(case.inertia) * tip_turn * tip_turn.T
    root = mp.cholesky(mass)
    inverse = mp.inverse(root)
    return sorted(mp.eigsy(inverse * stiff * inverse.T, eigvals_only=True))[:MODES]


def rows_of(case):
    mp.dps = 200
    count = 26 if case.compliance > 0 else 30 if max(case.c_b, case.c_h) < 0.7 else 52
    found, more = squares(case, count), squares(case, count + 3)
    assert all(abs(a - b) < mpf(10) ** -16 * abs(b) for a, b in zip(found, more)), (case, found, more)
    print(case, flush=True)
    return [(*case, k, square) for k, square in enumerate(more, 1)]


def main():
    mp.dps = 200
    with Pool(2) as pool:
        rows = [row for some in pool.map(rows_of, CASES, chunksize=1) for row in some]
    write_table("taper_modes.txt", """
Modes of a clamped beam whose rectangular section tapers linearly, b = 1 - c_b x, h = 1 - c_h x, by Ritz's method, to 16 digits: beta squared
in EI/(rho A l^4) of the root. omega in the root of it, mass and inertia of a body at the tip in rho A l and rho A l^3; compliance is
EI/(kappa G A l^2) and rotary I/(A l^2) of the root, 0 without shear.
""", [*Case._fields, "k", "beta_squared"], rows)


if __name__ == "__main__":
    main()
