"""Writes tension_pieces.txt: modes of beams of pieces with the tension of rotation, by power series from joint to joint.

The state (v, psi, M, Q), Q = N + Tv' the whole force across the beam, obeys v' = (sQ + psi)/(1 + sT), psi' = M/B,
M' = T v' - Q - rho I rho psi, Q' = -m lambda v. From the root two motions are carried to the tip, where M and Q must vanish with
what is attached; beta squared is a root of the determinant, all roots from 0 on being counted by its changes of sign.
"""

from mpmath import mp, mpf

from pieces_beam import Beam, Joint, Piece
from table import write_table

TERMS = 60  # of the series in a step, beyond the 50th digit
STEPS = 8  # in a piece


def tension_of(beam, hub, i):
    """Coefficients of T in the distance from the inner end of piece i."""
    spin, ends, x = mpf(beam.omega) ** 2, [mpf(hub)], mpf(hub)
    for piece in beam.pieces:
        x += mpf(piece.length)
        ends.append(x)
    total = mpf(0)
    for j in range(i, len(beam.pieces)):
        total += beam.pieces[j].mass * (ends[j + 1] ** 2 - ends[j] ** 2) / 2 + beam.joints[j].mass * ends[j + 1]
    mass = mpf(beam.pieces[i].mass)
    return [spin * total, -spin * mass * ends[i], -spin * mass / 2]


def carry(piece, tension, lam, rho, state):
    """The state at the outer end of a piece."""
    b, m, s, r = mpf(piece.stiffness), mpf(piece.mass), mpf(piece.compliance), mpf(piece.rotary) * rho
    h = mpf(piece.length) / STEPS
    for step in range(STEPS):
        x = h * step
        t = [tension[0] + x * (tension[1] + x * tension[2]), tension[1] + 2 * x * tension[2], tension[2]]
        v, psi, moment, force, slope = ([value] for value in (*state, mpf(0)))
        slope.clear()
        for n in range(TERMS):
            rest = s * force[n] + psi[n] - s * sum(t[j] * slope[n - j] for j in (1, 2) if j <= n)
            slope.append(rest / (1 + s * t[0]))
            pull = sum(t[j] * slope[n - j] for j in (0, 1, 2) if j <= n)
            v.append(slope[n] / (n + 1))
            psi.append(moment[n] / b / (n + 1))
            moment.append((pull - force[n] - r * psi[n]) / (n + 1))
            force.append(-m * lam * v[n] / (n + 1))
        state = [sum(c * h**n for n, c in enumerate(series)) for series in (v, psi, moment, force)]
    return state


def tip_lack(beam, hub, square):
    """The determinant of moment and force at the tip."""
    lam, rho = beam.loads(square)
    columns = []
    for j in (0, 1):
        state = [mpf(0)] * 4
        place = (0, 3) if j == 0 else (1, 2)
        spring = beam.root[j]
        state[place[0]], state[place[1]] = (mpf(0), mpf(1)) if spring is None else (mpf(1), mpf(spring))
        for i, (piece, joint) in enumerate(zip(beam.pieces, beam.joints)):
            state = carry(piece, tension_of(beam, hub, i), lam, rho, state)
            state[3] += (mpf(joint.stiffness) - mpf(joint.mass) * lam) * state[0]
            state[2] += (mpf(joint.turning_stiffness) - mpf(joint.inertia) * square) * state[1]
        columns.append(state[2:])
    return columns[0][0] * columns[1][1] - columns[0][1] * columns[1][0]


def first_squares(beam, hub, count):
    """The lowest beta squared, by steps so small in beta squared + Omega squared that none is passed over, and secants."""
    low = -mpf(beam.omega) ** 2 * mpf("1.01") - 1
    at_low, found, width = tip_lack(beam, hub, low), [], mpf("0.5")
    while len(found) < count:
        high = low + width
        at_high = tip_lack(beam, hub, high)
        if at_low * at_high < 0:
            found.append(mp.findroot(lambda x: tip_lack(beam, hub, x), (low, high), solver="anderson", tol=mpf(10) ** -80,
                                     verify=False))
        low, at_low, width = high, at_high, width * mpf("1.03")
    return found


BEAMS = [  # hub radius, beam
    (0.0, Beam([Piece(1.0)], [Joint()], omega=6.0, in_plane=0)),
    (0.125, Beam([Piece(0.25, 1.0, 1.25), Piece(0.75, 0.5, 0.75)], [Joint(), Joint(0.25, 0.03125)], omega=5.0)),
    (0.0, Beam([Piece(0.625), Piece(0.375)], [Joint(0.5, 0.0625), Joint()], omega=10.0)),
    (0.25, Beam([Piece(0.5, 1.0, 1.0, 0.001953125, 0.000732421875), Piece(0.25, 0.25, 0.5, 0.0078125, 0.00018310546875),
                 Piece(0.25, 2.0, 1.5, 0.00146484375, 0.001220703125)],
                [Joint(), Joint(0.125, 0.0, 30.0, 0.25), Joint(0.0625)], (None, 12.0), 8.0, 0)),
    (0.0, Beam([Piece(0.375, 1.0, 1.0, 0.0078125, 0.0029296875), Piece(0.625, 0.5, 1.0, 0.0078125, 0.0029296875)],
               [Joint(0.0, 0.0, 100.0), Joint(1.0, 0.125)], (2000.0, 0.0), 3.0, 1)),
    # pieces far stiffer than the beam: at the tip, between two bodies, at roots that turn or move, before a heavy body, and thick
    (0.125, Beam([Piece(1 - 2.0**-30), Piece(2.0**-30)], [Joint(0.25, 0.03125), Joint()], omega=5.0)),
    (0.0, Beam([Piece(0.5, 1.0, 1.0, 0.0078125, 0.0029296875), Piece(2.0**-20, 1.0, 1.0, 0.0078125, 0.0029296875),
                Piece(0.5 - 2.0**-20, 1.0, 1.0, 0.0078125, 0.0029296875)], [Joint(0.5, 0.0625), Joint(0.25), Joint()],
               omega=8.0, in_plane=0)),
    (0.0, Beam([Piece(2.0**-30), Piece(1 - 2.0**-30)], [Joint(2.0, 0.125), Joint()], (None, 12.0), 6.0)),
    (0.25, Beam([Piece(2.0**-10), Piece(0.75 - 2.0**-10), Piece(0.25 - 2.0**-26), Piece(2.0**-26)],
                [Joint(0.5), Joint(), Joint(0.125, 0.03125), Joint(1.0, 0.25)], (2000.0, 10.0), 4.0)),
    (0.0, Beam([Piece(1 - 2.0**-10), Piece(2.0**-10)], [Joint(), Joint(1024.0)], omega=0.125)),
    (0.0, Beam([Piece(0.25), Piece(0.25, 2.0**20, 2.0), Piece(0.5)], [Joint(), Joint(), Joint(0.5)], omega=4.0)),
    (0.0, Beam([Piece(2.0**-30), Piece(2.0**-13 - 2.0**-30), Piece(1 - 2.0**-13)],
               [Joint(0.03125, 0.125), Joint(8.0), Joint()], omega=6.0, in_plane=0)),
    (0.0, Beam([Piece(0.5), Piece(2.0**-20), Piece(0.5 - 2.0**-20)],
               [Joint(0.25, 0.0625, 0.0, 2.0**40), Joint(0.5, 0.25, 0.0, 2.0**-10), Joint()], omega=6.0)),
    # a short piece of soft material, which takes most of the flexibility, beyond a body, of a soft root
    (0.0, Beam([Piece(0.5), Piece(0.5 - 2.0**-19), Piece(2.0**-19, 2.0**-23)], [Joint(1.0), Joint(), Joint()], (None, 2.0**-20),
               1.0, 0)),
]

if __name__ == "__main__":
    mp.dps = 50
    rows = []
    for number, (hub, beam) in enumerate(BEAMS, 1):
        squares = first_squares(beam, hub, 6)
        print(number, [mp.nstr(x, 15) for x in squares], flush=True)
        for i, (piece, joint) in enumerate(zip(beam.pieces, beam.joints)):
            rows.append((number, i + 1, hub, piece.length, piece.stiffness, piece.mass, piece.compliance, piece.rotary, joint.mass,
                         joint.inertia, joint.stiffness, joint.turning_stiffness, *(-1.0 if s is None else s for s in beam.root),
                         beam.omega, beam.in_plane, *squares))
    write_table("tension_pieces.txt", """
Beams of pieces with the tension of rotation, as those of piece_beams.txt, each with the radius of its hub, and their first six
beta squared
""", ["beam", "piece", "hub_radius", "length", "stiffness", "mass", "compliance", "rotary", "body_mass", "body_inertia", "spring",
      "turning_spring", "root_spring", "root_turning", "omega", "in_plane", *(f"square_{k}" for k in range(1, 7))], rows)
