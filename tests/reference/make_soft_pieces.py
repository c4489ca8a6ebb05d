"""Writes soft_beams.txt and soft_modes.txt: beams that hardly bend in their lowest modes, with pieces as short as 1e-9 that
carry inertia and springs; their first modes by dynamic stiffness."""

import math
import random

from make_pieces import COLUMNS, row_of, spread
from mpmath import mp, mpf

from pieces_beam import Beam, Joint, Piece, root
from table import write_table

BEAMS = 42
MODES = 4
SEED = 31
DIGITS = 120  # short pieces are 1e27 times as stiff as the beam, whose root is as soft as 1e-12


def hinged_rod():
    """A steel rod of 1 m and 50 mm, hinged by 1e-3 N m/rad; two flywheels of 1000 kg m2 at its tip, 10 nm apart."""
    stiffness, mass = 2e11 * math.pi * 0.05**4 / 64, 7870 * math.pi * 0.05**2 / 4
    flywheel = Joint(inertia=1000 / mass)
    return Beam([Piece(0.99999999), Piece(1e-8)], [flywheel, flywheel], (None, 1e-3 / stiffness), 0.0, 1)


def joint_of(draw):
    """What is attached where a piece ends: masses, inertia and springs from nothing to a million beams."""
    joint = Joint()
    if draw.random() < 0.4:
        return joint
    joint.mass = spread(draw, 1e-6, 1e4) if draw.random() < 0.4 else 0.0
    joint.inertia = spread(draw, 1e-9, 1e6) if draw.random() < 0.7 else 0.0
    joint.stiffness = spread(draw, 1e-9, 1e9) if draw.random() < 0.15 else 0.0
    joint.turning_stiffness = spread(draw, 1e-9, 1e9) if draw.random() < 0.2 else 0.0
    return joint


def random_beam(draw):
    """One or two long pieces, up to five short ones between and beyond them, and springs of 1e-12 to 1e3 at the root."""
    lengths = [spread(draw, 1e-9, 1e-3)] if draw.random() < 0.3 else []
    for _ in range(draw.randint(1, 2)):
        lengths += [draw.uniform(0.2, 1)] + [spread(draw, 1e-9, 1e-3) for _ in range(draw.randint(0, 2))]
    lengths.append(spread(draw, 1e-9, 1e-3))
    rotary = spread(draw, 1e-6, 1e-3) if draw.random() < 0.4 else 0.0
    alike = draw.random() < 0.6
    pieces = []
    for length in lengths:
        stiffness, mass = (1.0, 1.0) if alike else (spread(draw, 1e-2, 1e2), spread(draw, 0.1, 10))
        pieces.append(Piece(length, stiffness, mass, 2.9 * rotary / stiffness, rotary * mass))
    held = draw.choice(((1, 0), (1, 0), (0, 1), (0, 0)))
    springs = tuple(None if rigid else spread(draw, 1e-12, 1e3) for rigid in held)
    omega = draw.choice((0.0, 0.0, spread(draw, 1e-4, 10)))
    return Beam(pieces, [joint_of(draw) for _ in pieces], springs, omega, draw.randint(0, 1))


def modes_of(number, beam):
    for k in range(1, MODES + 1):
        spin = mpf(beam.omega) ** 2 if beam.in_plane else mpf(0)
        square = root(beam, k, mpf(10) ** -24 - spin, mpf(k) ** 4)
        value = mp.nstr(square + spin, 20)  # more digits than tests look at
        yield number, k, mpf(value)
        print(number, k, value, flush=True)


if __name__ == "__main__":
    mp.dps = DIGITS
    draw = random.Random(SEED)
    beams = list(enumerate([hinged_rod()] + [random_beam(draw) for _ in range(BEAMS - 1)], 1))
    write_table("soft_beams.txt", """
Beams of uniform pieces that hardly bend in their lowest modes; columns as those of piece_beams.txt
""", COLUMNS, [row_of(number, beam, i) for number, beam in beams for i in range(len(beam.pieces))])
    write_table("soft_modes.txt", """
Modes of the beams of soft_beams.txt by exponentials and dynamic stiffness: lambda, that is beta squared and, in plane, omega
squared
""", ["beam", "k", "lambda"], [row for number, beam in beams for row in modes_of(number, beam)])
