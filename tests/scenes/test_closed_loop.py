"""Random beams are struck, their histories get noise, and the beam is identified from these: the true numbers are inside the
intervals as often as these say. BEAMWAVE_DRAWS multiplies the number of beams, by hand."""

import os

import numpy as np
from workplace import namelist

BEAMS = 9 * int(os.environ.get("BEAMWAVE_DRAWS", "1"))
LEVELS = [60, 40, 20]  # dB: signal over noise, root mean squares of the first sensor
DURATION, SAMPLES = 1.0, 4096
ROUND = {"length": 1.0, "density": 7870.0, "youngs_modulus": 2e11, "diameter": 0.037}
STEPPED = {**ROUND, "length": [0.4, 0.3, 0.3], "diameter": [0.037, 0.032, 0.028]}
RANGES = {  # of each unknown: first, last, and whether its logarithm is drawn
    "beam%youngs_modulus": (1.5e11, 2.5e11, False),
    "support%rotational_stiffness": (1e4, 1e7, True),
    "body%mass": (0.05, 4.0, True),
    "body%position": (0.55, 0.98, False),
}
KINDS = [
    (ROUND, ["beam%youngs_modulus", "support%rotational_stiffness"]),
    (ROUND, ["body%mass", "body%position"]),
    (STEPPED, ["beam%youngs_modulus", "support%rotational_stiffness", "body%mass"]),
]


def with_values(beam, values):
    """The groups of a beam with these numbers; a body that is not looked for stands at 0.8."""
    groups = {"beam": dict(beam)}
    for name, value in values.items():
        group, key = name.split("%")
        groups.setdefault(group, {})[key] = value
    if "body" in groups:
        groups["body"].setdefault("position", 0.8)
    return groups


def drawn(dice, beam, unknowns):
    """The true beam, what is unknown of it, and what does not change between the two."""
    true = {}
    for name in unknowns:
        first, last, logarithmic = RANGES[name]
        way = dice.uniform(0.1, 0.9)
        true[name] = float(first * (last / first) ** way if logarithmic else first + (last - first) * way)
    same = {"rotation": {"angular_velocity": float(dice.uniform(0, 30))}}
    struck = {
        **with_values(beam, true),
        **same,
        "damping": {"ratio": float(10 ** dice.uniform(-3.3, -2.3))},
        "impact": {"mass": 0.05, "position": float(dice.uniform(0.85, 1.0)), "restitution": 0.5},
        "modes": {"before": 5},
        "response": {"duration": DURATION, "samples": SAMPLES, "points": [1.0, 0.47], "velocity": True},
    }
    return true, struck, {**with_values(beam, dict.fromkeys(unknowns)), **same}


def without_values(groups, unknowns):
    """The groups as a person has them who does not know these numbers."""
    return {name: {key: value for key, value in group.items() if f"{name}%{key}" not in unknowns} for name, group in groups.items()}


def as_record(result, level, dice):
    """The velocities in noise, as text."""
    noise = np.sqrt((result["velocity"][0] ** 2).mean()) * 10 ** (-level / 20)
    values = result["velocity"] + noise * dice.standard_normal(result["velocity"].shape)
    rows = (",".join([repr(float(t)), *(f"{value:.9e}" for value in row)]) for t, row in zip(result["time"], values.T))
    return "\n".join(["time [s],tip [m/s],middle [m/s]", *rows]) + "\n"


def test_true_numbers_are_inside_their_intervals(here):
    dice = np.random.default_rng(19)
    beams = []
    for number in range(BEAMS):
        beam, unknowns = KINDS[number % 3]
        true, struck, known = drawn(dice, beam, unknowns)
        here.write(f"struck/s{number}.nml", namelist(struck))
        groups = {**without_values(known, unknowns), "record": {"file": f"s{number}.csv"}, "spectrum": {}}
        text = "".join(
            namelist({"identify": {"parameter": name, "first": RANGES[name][0], "last": RANGES[name][1]}}) for name in unknowns
        )
        here.write(f"found/i{number}.nml", namelist(groups) + text)
        beams.append((true, LEVELS[number // 3 % 3]))
    assert here.beamwave("run", "struck", "--quiet", timeout=20 * BEAMS).returncode == 0
    for number, (_, level) in enumerate(beams):
        here.write(f"found/s{number}.csv", as_record(here.result(f"s{number}"), level, dice))
    ended = here.beamwave("run", "found", "--quiet", timeout=20 * BEAMS)
    assert ended.returncode == 0, ended.stderr

    inside, explained = {level: [] for level in LEVELS}, []
    for number, (true, level) in enumerate(beams):
        result = here.result(f"i{number}")
        values = np.array(list(true.values()))
        inside[level] += list((result["identified_low"] <= values) & (values <= result["identified_high"]))
        explained.append(result["misfit_probability"] > 1e-3)
    if BEAMS > 9:
        print({level: (np.mean(held), len(held)) for level, held in inside.items()}, np.mean(explained))
    held = np.concatenate([inside[level] for level in LEVELS])
    # unknowns of a beam err together, two or three of them: the deviation of the share is that of so many fewer
    assert abs(held.mean() - 0.95) < max(0.02, 3.3 * np.sqrt(0.05 * 0.95 * 2.5 / held.size))
    assert np.mean(explained) > 0.9
