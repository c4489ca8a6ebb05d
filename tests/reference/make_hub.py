"""Writes hub_modes.txt: modes of the paper's beam on a hub that is free to turn, by power series in 60 digits.

Between root and tip EI u'''' = (T u')' + rho A (beta^2 + omega^2) u in the frame that turns with omega. The root is held to u(0) = R theta
and u'(0) = theta, rigidly or by springs. The hub's own equation and those of the tip close the system, whose determinant is 0 at a
mode. The rigid turn u = theta (R + x), with beta = 0, is not among the modes.
"""

from multiprocessing import Pool
from typing import NamedTuple

from mpmath import findroot, matrix, mp, mpf

from table import write_table

TERMS = 170
MODES = 6


class Case(NamedTuple):
    inertia: float  # J, kg m^2
    omega: float  # rad/s
    radius: float  # R, m
    gamma: float  # mass at the tip over that of the beam
    stiffness: float = -1.0  # of the support, N/m; -1: rigid
    rotational_stiffness: float = -1.0  # N m/rad


CASES = [Case(*numbers) for numbers in [(2.0, 0.0, 0.0, 0.2), (2.0, 50.0, 0.0, 0.2), (2.0, 50.0, 0.3, 0.0), (0.05, 80.0, 0.1, 1.0),
                                        (40.0, 20.0, 0.5, 0.2), (0.5, 0.0, 0.4, 0.0), (2.0, 50.0, 0.3, 0.2, 1e6, 1e5),
                                        (2.0, 0.0, 0.3, 0.2, 1e5, 1e4), (2.0, 30.0, 0.3, 0.2, -1.0, 1e4)]]


def section():
    """EI and rho A of the paper's beam, l = 1, from its binary inputs."""
    diameter = mpf(0.037)
    return mpf(2e11) * mp.pi / 64 * diameter**4, 7870 * mp.pi / 4 * diameter**2


def at_tip(case, square, start):
    """u, u', u'' and u''' at the tip from those at the root."""
    stiff, mass = section()
    omega2, r = mpf(case.omega) ** 2, mpf(case.radius)
    t = [omega2 * mass * (mpf(1) / 2 + r + mpf(case.gamma) * (1 + r)), -omega2 * mass * r, -omega2 * mass / 2]
    c = [start[0], start[1], start[2] / 2, start[3] / 6] + [mpf(0)] * TERMS
    for n in range(TERMS):
        pull = sum(t[j] * (n + 2 - j) * c[n + 2 - j] for j in range(3) if n + 2 - j > 0)  # T u', of x^(n + 1)
        c[n + 4] = ((n + 1) * pull + mass * (square + omega2) * c[n]) / stiff / ((n + 1) * (n + 2) * (n + 3) * (n + 4))
    return [sum(mp.ff(k, d) * x for k, x in enumerate(c) if k >= d) for d in range(4)]


def determinant(case, square):
    stiff, mass = section()
    omega2, r = mpf(case.omega) ** 2, mpf(case.radius)
    tip = mass * mpf(case.gamma)
    tension = omega2 * (mass * (mpf(1) / 2 + r) + tip * (1 + r))  # at the root
    system = matrix(5, 5)
    for j in range(5):  # theta, u(0), u'(0), u''(0), u'''(0), in turn 1
        theta, u, slope, bend, third = (mpf(int(i == j)) for i in range(5))
        force = stiff * third - tension * slope + tension * theta
        k, k_turn = mpf(case.stiffness), mpf(case.rotational_stiffness)
        end = at_tip(case, square, [u, slope, bend, third])
        column = [
            u - r * theta if k < 0 else (k * (u - r * theta) + force) / stiff,
            slope - theta if k_turn < 0 else (k_turn * (slope - theta) - stiff * bend) / stiff,
            (tension * (u - r * theta) + r * force - stiff * bend - mpf(case.inertia) * square * theta) / stiff,
            end[2],
            end[3] + (tip * (square + omega2) * end[0] - omega2 * tip * (1 + r) * end[1]) / stiff,
        ]
        for i in range(5):
            system[i, j] = column[i]
    return mp.det(system)


def rows_of(case):
    mp.dps = 60
    stiff, mass = section()
    h = mp.sqrt(stiff / mass)

    def f(alpha):
        return determinant(case, h**2 * alpha**4)

    grid = [mpf(i) / 20 for i in range(10, 460)]
    found, last = [], f(grid[0])
    for a, b in zip(grid, grid[1:]):
        value = f(b)
        if value * last < 0:
            alpha = findroot(f, (a, b), solver="anderson", tol=1e-90)
            found.append(h * alpha**2)
            if len(found) == MODES:
                break
        last = value
    print(case, mp.nstr(found[:3], 15), flush=True)
    return [(*case, k, beta) for k, beta in enumerate(found, 2)]


def main():
    mp.dps = 60
    with Pool(2) as pool:
        rows = [row for some in pool.map(rows_of, CASES, chunksize=1) for row in some]
    write_table("hub_modes.txt", """
Modes of the paper's beam on a hub that is free to turn, by power series: beta in rad/s. Inertia of the hub in kg m^2, omega in rad/s,
radius of the hub in m, mass at the tip over that of the beam, springs between hub and root in N/m and N m/rad, -1 where rigid.
Mode 1 is the rigid turn.
""", [*Case._fields, "k", "beta"], rows)


if __name__ == "__main__":
    main()
