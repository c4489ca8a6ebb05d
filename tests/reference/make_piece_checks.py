"""Writes piece_waves.txt: what follows from modes of pieces, for beams of piece_beams.txt."""

from mpmath import mp, mpf

from pieces_beam import Beam, Joint, Mode, Piece
from table import FOLDER, write_table

WAVES = (1, 3, 20)


def rows_of(name):
    lines = [line.split() for line in (FOLDER / name).read_text().splitlines() if not line.startswith("#")]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


def beam_of(number):
    rows = [row for row in rows_of("piece_beams.txt") if int(row["beam"]) == number]
    value = lambda row, *names: [float(row[name]) for name in names]
    pieces = [Piece(*value(row, "length", "stiffness", "mass", "compliance", "rotary")) for row in rows]
    joints = [Joint(*value(row, "body_mass", "body_inertia", "spring", "turning_spring")) for row in rows]
    springs = tuple(None if s < 0 else s for s in value(rows[0], "root_spring", "root_turning"))
    return Beam(pieces, joints, springs, float(rows[0]["omega"]), int(rows[0]["in_plane"]))


def mean_wave(beam, square):
    """Sum of the pieces' lengths times the wave numbers of their bending waves: the larger root of the dispersion relation."""
    lam, rho = beam.loads(square)
    total = mpf(0)
    for piece in beam.pieces:
        b, s, turn = mpf(piece.stiffness), mpf(piece.compliance), mpf(piece.rotary) * rho
        stiff = s * b
        first, last = turn + stiff * piece.mass * lam, piece.mass * lam * (1 - s * turn)
        total += piece.length * mp.sqrt((first + mp.sqrt(first**2 + 4 * b * last)) / (2 * b))
    return total


def product(one, other, i, c):
    """Integral over piece i of the products of the numbers c of two modes' states."""
    length, total = mpf(one.beam.pieces[i].length), mp.mpc(0)
    for (mu, state), a in zip(one.waves[i], one.amplitude[i]):
        for (nu, state_too), b in zip(other.waves[i], other.amplitude[i]):
            start = sum(-m * length if m.real > 0 else 0 for m in (mu, nu))
            s = mu + nu
            part = mp.exp(start) * length if abs(s) * length < mpf(10) ** -30 else (mp.exp(start + s * length) - mp.exp(start)) / s
            total += a * b * part * state[c] * state_too[c]
    return mp.re(total)


def elastic_square(mode):
    """Energy in bending, in shear and in springs over that of motion at a frequency of 1."""
    beam = mode.beam
    energy = sum(product(mode, mode, i, 2) / piece.stiffness + mpf(piece.compliance) * product(mode, mode, i, 3)
                 for i, piece in enumerate(beam.pieces))
    for i, joint in enumerate(beam.joints):
        v, psi = [mp.re(x) for x in mode.state(i, mpf(1))[:2]]
        energy += joint.stiffness * v**2 + joint.turning_stiffness * psi**2
    for place in (0, 1):
        if beam.root[place] is not None:
            energy += beam.root[place] * mp.re(mode.state(0, mpf(0))[place]) ** 2
    return energy / mode.masses()[1]


def wave_rows():
    for row in rows_of("piece_modes.txt"):
        number, k = int(row["beam"]), int(row["k"])
        if k not in WAVES:
            continue
        beam, square = beam_of(number), mpf(row["beta_squared"])
        alpha, rise = mean_wave(beam, square), mp.diff(lambda x: mean_wave(beam, x), square)
        beta = mp.sqrt(square) if square > 0 else None
        yield (number, k, square, alpha, *((beta / alpha, 1 / (2 * beta * rise)) if beta else (-1, -1)),
               elastic_square(Mode(beam, square)))


if __name__ == "__main__":
    mp.dps = 60
    write_table("piece_waves.txt", """
Modes of the beams of piece_beams.txt: beta squared, the mean of the pieces' bending waves over the beam, beta over it and the
derivative of beta by it (-1: not there), and elastic energy over that of motion at a frequency of 1
""", ["beam", "k", "beta_squared", "alpha", "phase_velocity", "group_velocity", "elastic"], list(wave_rows()))
