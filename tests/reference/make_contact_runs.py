"""Writes contact_scenes.txt, contact_times.txt and contact_histories.txt: seeded scenes with recontact, their contacts and
some of their samples.

`--scenes N --folder DIR` writes as many scenes as that elsewhere (200 take ten minutes): tests/scenes/test_contact_errors.py
reads them from the directory that BEAMWAVE_CONTACT_RUNS names.
"""

import argparse
import random
from concurrent.futures import ProcessPoolExecutor
from dataclasses import astuple, fields
from pathlib import Path

import contact_simulator
import table
from beam import use_digits

SEED = 20240607
STORED = [*range(23), 53, 157]  # the last two are more than binary128 carries to the end
SAMPLES = 2000  # of the record, of which some are kept
KEPT = [*range(0, SAMPLES, 97), SAMPLES - 1]
DIGITS = 110


def scene(number):
    """Scene `number`, the same however many there are; of scene 0 binary64 keeps 26 contacts of 63."""
    if number == 0:
        return contact_simulator.Scene(modes=8, mass_ratio=1.0, restitution=1.0, duration=0.3, omega=50.0)
    draw = random.Random(f"{SEED} {number}")
    modes = draw.choice([1, 2, 3, 5, 8, 12, 20])
    restitution = draw.choice([0.0, 1.0, 1.0, draw.random(), draw.random(), draw.uniform(0.8, 1)])
    omega = draw.choice([0.0, draw.uniform(0, 100), draw.uniform(100, 180)])
    damping = draw.choice([0.0, 0.0, 10 ** draw.uniform(-5, -1)])
    mass_ratio = 10 ** draw.uniform(-2, 1.5)
    if restitution > 4 * modes * mass_ratio:  # the mass would fly off, most likely for good
        mass_ratio = restitution / modes * draw.uniform(0.25, 2)
    return contact_simulator.Scene(modes, mass_ratio, restitution, 10 ** draw.uniform(-2, 0), omega, damping)


def followed(number):
    """The rows of all tables."""
    use_digits(DIGITS)
    chain = contact_simulator.Chain(scene(number))
    contacts = [(number, contact.number, contact.start, contact.end) for contact in chain.contacts()]
    times = [(j, chain.duration * j / SAMPLES) for j in KEPT]
    motion = zip(times, chain.displacements([t for _, t in times]), chain.velocities([t for _, t in times]))
    histories = [(number, j, *places, *rates) for (j, _), places, rates in motion]
    return (number, *astuple(chain.scene), len(contacts)), contacts, histories


if __name__ == "__main__":
    words = argparse.ArgumentParser()
    words.add_argument("--scenes", type=int, help="as many, from the first")
    words.add_argument("--folder", type=Path, default=table.FOLDER)
    words.add_argument("--processes", type=int, default=2)
    words = words.parse_args()
    use_digits(DIGITS)
    table.FOLDER, table.DIGITS = words.folder, 22  # more than what is compared with them holds
    with ProcessPoolExecutor(words.processes) as pool:
        runs = list(pool.map(followed, range(words.scenes) if words.scenes else STORED))
    inputs = [field.name for field in fields(contact_simulator.Scene)]
    table.write_table("contact_scenes.txt", """
Scenes of the paper's beam alone with recontact: inputs (binary64; omega in plane, rad/s; duration in s), and the number of
contacts that come after the impact. From contact_simulator.py
""", ["scene", *inputs, "contacts"], [row for row, _, _ in runs])
    table.write_table("contact_times.txt", """
Start and end (s) of each of these contacts
""", ["scene", "number", "start", "end"], [row for _, rows, _ in runs for row in rows])
    table.write_table("contact_histories.txt", f"""
Displacement (s) and velocity, over the approach velocity, of the same scenes at samples of {SAMPLES}, at the points 0.5 and 1
""", ["scene", "sample", "displacement_0.5", "displacement_1", "velocity_0.5", "velocity_1"],
        [row for _, _, rows in runs for row in rows])
