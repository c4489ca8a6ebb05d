"""Writes piece_beams.txt and piece_modes.txt: random beams of pieces, and some of their modes, by dynamic stiffness."""

import math
import random

from mpmath import mp, mpf

from pieces_beam import Beam, Joint, Mode, Piece, root
from table import write_table

BEAMS = 24
SEED = 17
NUMBERS = (1, 2, 3, 7, 20, 50)
COLUMNS = ["beam", "piece", "length", "stiffness", "mass", "compliance", "rotary", "body_mass", "body_inertia", "spring",
           "turning_spring", "root_spring", "root_turning", "omega", "in_plane"]
HIGH = {0: (1000,), 5: (1000,), 10: (100000,), 15: (100000,)}


def spread(draw, low, high):
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def random_beam(draw):
    """1 to 5 pieces, up to 3 bodies, springs over 18 decades, slenderness D/l from 1e-6 to 0.5, either plane."""
    cuts = sorted(draw.random() for _ in range(draw.randint(0, 4)))
    shear = draw.random() < 0.6
    diameter = spread(draw, 1e-6, 0.5)
    stuff = []
    for _ in range(len(cuts) + 1):
        ratio = spread(draw, 0.3, 3) if cuts else 1.0
        stiffness, mass = ratio**4 * spread(draw, 0.3, 3), ratio**2 * spread(draw, 0.3, 3)
        square = (min(diameter * ratio, 0.5) / 4) ** 2
        stuff.append((stiffness, mass, 2.93 * square / stiffness, mass * square) if shear else (stiffness, mass))
    joints = {position: Joint() for position in cuts + [1.0]}
    for _ in range(draw.randint(0, 3)):
        joint = joints.setdefault(draw.choice(cuts + [1.0, draw.random(), draw.random()]), Joint())
        joint.mass = spread(draw, 1e-6, 1e3)
        joint.inertia = spread(draw, 1e-9, 10) if draw.random() < 0.5 else 0.0
        joint.stiffness = spread(draw, 1e-6, 1e12) if draw.random() < 0.5 else 0.0
        joint.turning_stiffness = spread(draw, 1e-6, 1e12) if draw.random() < 0.5 else 0.0
    pieces, last = [], 0.0
    for position in sorted(joints):
        pieces.append(Piece(position - last, *stuff[sum(cut < (last + position) / 2 for cut in cuts)]))
        last = position
    springs = tuple(None if draw.random() < 0.5 else spread(draw, 1e-6, 1e12) for _ in range(2))
    omega = draw.choice([0.0, draw.uniform(0, 100), spread(draw, 1e-3, 100)])
    return Beam(pieces, [joints[position] for position in sorted(joints)], springs, omega, draw.randint(0, 1))


def row_of(number, beam, i):
    """Piece i with what is attached to its end, and what the whole beam has; a rigid root has springs of -1."""
    piece, joint = beam.pieces[i], beam.joints[i]
    return (number, i + 1, piece.length, piece.stiffness, piece.mass, piece.compliance, piece.rotary, joint.mass, joint.inertia,
            joint.stiffness, joint.turning_stiffness, *(-1.0 if s is None else s for s in beam.root), beam.omega, beam.in_plane)


def modes_of(number, beam):
    for k in NUMBERS + HIGH.get(number - 1, ()):
        square = root(beam, k, mpf(10) ** -25 - mpf(beam.omega) ** 2, mpf(k) ** 4)
        mode = Mode(beam, square)
        mean, mass = mode.masses()
        yield number, k, square, mass / mean, mode.at(0.5)[0] ** 2 / mean, mode.at(1)[0] ** 2 / mean
        print(number, k, mp.nstr(square, 20), flush=True)


if __name__ == "__main__":
    mp.dps = 60
    draw = random.Random(SEED)
    beams = list(enumerate((random_beam(draw) for _ in range(BEAMS)), 1))
    write_table("piece_beams.txt", """
Beams of uniform pieces: each piece with its length in l, EI, rho A, 1/(kappa G A), rho I, and the mass, the inertia and the
springs at its outer end; of the beam the springs at its root (-1: rigid), omega and whether it bends in the plane of rotation
""", COLUMNS, [row_of(number, beam, i) for number, beam in beams for i in range(len(beam.pieces))])
    write_table("piece_modes.txt", """
Modes of the beams of piece_beams.txt by exponentials and dynamic stiffness: beta squared; and, with the integral of the squared
deflection 1, the modal mass and the squared deflections at the midpoint and at the tip
""", ["beam", "k", "beta_squared", "modal_mass", "middle_square", "tip_square"],
                [row for number, beam in beams for row in modes_of(number, beam)])
