"""Writes contacts.txt: a mass that comes back to the paper's beam, its contacts one by one."""

from beam import use_digits
from contact_simulator import Chain, Scene
from table import write_table


def contacts(count, restitution, most):
    scene = Scene(count, 0.2, restitution, 0.02, 50.0, max_contacts=most)
    for contact in Chain(scene).contacts():
        yield (count, restitution, contact.number, contact.start, contact.end, contact.energy_before, contact.energy_after,
               contact.impulse)  # fmt: skip


use_digits(100)
rows = [row for count, e, most in [(5, 0.2, 8), (5, 0.0, 6), (5, 0.9, 6), (2, 0.5, 6)] for row in contacts(count, e, most)]
write_table("contacts.txt", """
Contacts after the impact of the paper's beam alone, mass ratio 0.2 (binary64), 50 rad/s in plane, 1 m/s, record of 0.02 s:
start and end (s) of each, the Jacobi energy of beam and mass before and after, and the impulse on the tip, masses over the
beam's, velocities over the approach velocity; `modes` and restitution `e` belong to the run
""", ["modes", "e", "number", "start", "end", "energy_before", "energy_after", "impulse"], rows)
