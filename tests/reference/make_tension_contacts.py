"""Writes tension_contacts.txt: a mass that comes back to a rotating beam with tension, by the modes of tension_modes.txt."""

from mpmath import mpf

from beam import use_digits
from contact_simulator import Chain, Mode, Scene
from table import FOLDER, write_table

DURATION = 2.0
BEAM_ALONE = {"hub": 0, "gamma": 0, "compliance": 0, "inertia": 0}
CASES = [  # omega in h/l^2, whether in its plane, modes, mass ratio, restitution
    (3.0, 1, 4, 1.25, 1.0), (3.0, 1, 4, 2.0, 0.375), (3.0, 0, 3, 10.0, 1.0), (12.0, 1, 3, 4.0, 1.0), (12.0, 1, 4, 0.5, 0.0),
    (12.0, 0, 4, 7.0, 0.5),
]  # fmt: skip


def tension_modes(omega, in_plane, count):
    """From the table, in units of h/l^2 and of the beam's mass, with a tip displacement of 1."""
    lines = [line.split() for line in (FOLDER / "tension_modes.txt").read_text().splitlines() if not line.startswith("#")]
    rows = [dict(zip(lines[0], map(mpf, line))) for line in lines[1:]]
    wanted = {**BEAM_ALONE, "omega": omega, "in_plane": in_plane}
    rows = [row for row in rows if all(row[name] == value for name, value in wanted.items())]
    turning = in_plane * mpf(omega) ** 2
    return [Mode(row["beta_squared"] + turning, mpf(1), row["mean_square"], [row["midpoint"], mpf(1)]) for row in rows][:count]


use_digits(60)
contacts = []
for omega, in_plane, count, mass_ratio, restitution in CASES:
    scene = Scene(count, mass_ratio, restitution, DURATION, in_plane * omega)
    for contact in Chain(scene, tension_modes(omega, in_plane, count)).contacts():
        contacts.append((omega, in_plane, count, mass_ratio, restitution, contact.number, contact.start, contact.end))
write_table("tension_contacts.txt", """
Contacts after the impact of a rotating beam with tension, clamped at the hub's line, alone: start and end in l^2/h, in a record
of 2 l^2/h; omega in h/l^2
""", ["omega", "in_plane", "modes", "mass_ratio", "restitution", "number", "start", "end"], contacts)
