"""Contacts and histories against a simulation in a hundred digits: what is given is within its error, and fill after that.

BEAMWAVE_CONTACT_RUNS names a directory with tables of more scenes, as tests/reference/make_contact_runs.py writes them; with
`pytest -s` the ratios of estimates to errors are printed.
"""

import os
from collections import defaultdict
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import results
from conftest import PROJECT
from workplace import PAPER_BEAM

TABLES = Path(os.environ.get("BEAMWAVE_CONTACT_RUNS", PROJECT / "tests/reference"))
SAMPLES, POINTS = 2000, [0.5, 1.0]
NOT_CONVERGED, ILL_CONDITIONED = 2, 3
MOST = 100  # contacts that the tables have of a scene, and max_contacts by default


def rows(name, folder=TABLES):
    """A table's rows by its columns' names."""
    lines = [line.split() for line in (folder / name).read_text().splitlines() if not line.startswith("#")]
    return [dict(zip(lines[0], line)) for line in lines[1:]]


def by_scene(name):
    """The rows of each scene."""
    scenes = defaultdict(list)
    for row in rows(name):
        scenes[row["scene"]].append(row)
    return scenes


def scene_of(row):
    """The scene of a row of inputs."""
    number = {name: float(value) for name, value in row.items()}
    scene = {
        "beam": dict(PAPER_BEAM),
        "impact": {"mass_ratio": number["mass_ratio"], "restitution": number["restitution"]},
        "recontact": {"max_contacts": int(row["max_contacts"])},
        "modes": {"before": int(row["modes"])},
        "response": {"duration": number["duration"], "samples": SAMPLES, "points": POINTS, "velocity": True},
    }
    if number["omega"]:
        scene["rotation"] = {"angular_velocity": number["omega"]}
    if number["damping_ratio"]:
        scene["damping"] = {"ratio": number["damping_ratio"]}
    return scene


class Run(NamedTuple):
    """A result beside what is true of it, in digits that binary64 does not have."""

    inputs: dict
    result: results.Result
    contacts: list
    samples: list

    def known_contacts(self):
        """How many the result has."""
        return int((self.result["event_kind"] == 4).sum())

    def known_samples(self):
        """How many of the history."""
        return int((~results.is_fill(self.result["displacement"][0])).sum())

    def event_ratios(self):
        """Estimates over errors of starts and ends of contacts, where there is an error."""
        for name, column in [("event_time", "start"), ("event_end", "end")]:
            times, estimates = self.result[name][1:], self.result[f"{name}_error"][1:]
            for truth, time, estimate in zip(self.contacts, times[: self.known_contacts()], estimates):
                yield from ratio(estimate, time, truth[column])

    def history_ratios(self):
        """The same of the largest errors at each point."""
        for name in ["displacement", "velocity"]:
            for point, estimate in zip([0, 1], self.result[f"{name}_error"]):
                column = f"{name}_{POINTS[point]:g}"
                history = self.result[name][point]
                known = [row for row in self.samples if int(row["sample"]) < self.known_samples()]
                every = [found for row in known for found in ratio(estimate, history[int(row["sample"])], row[column])]
                if every:
                    yield min(every)


def ratio(estimate, value, truth):
    """An estimate over the error of a value; nothing where the value is the nearest there is."""
    error = abs(Decimal(float(value)) - Decimal(truth))
    if error > abs(Decimal(truth)) * Decimal(2) ** -53:
        yield float(Decimal(float(estimate)) / error)


@pytest.fixture(scope="module")
def runs(shared):
    here = shared("contacts")
    inputs = rows("contact_scenes.txt")
    names = [here.scene(f"scene_{row['scene']}", scene_of(row)) for row in inputs]
    here.beamwave("run", "--quiet", *names)
    contacts, samples = by_scene("contact_times.txt"), by_scene("contact_histories.txt")
    return [
        Run(row, here.result(Path(name).stem), contacts[row["scene"]], samples[row["scene"]])
        for row, name in zip(inputs, names)
    ]


def test_times_and_histories_are_within_their_errors(runs):
    """The furthest of the neighbours is further from the motion than the truth."""
    for run in runs:
        assert all(found >= 1 for found in run.event_ratios()), run.inputs
        assert all(found >= 1 for found in run.history_ratios()), run.inputs


def test_estimates_are_not_far_above_the_errors(runs):
    """The median over all contacts and all histories; amplified is what is no rounding of the result any more."""
    events = [list(run.event_ratios()) for run in runs]
    histories = [found for run in runs for found in run.history_ratios()]
    for name, found, most in [("times", sum(events, []), 40), ("histories", histories, 200)]:
        print(f"{name}: {len(found)} ratios, least {min(found):.2f}, median {np.median(found):.2f}")
        assert np.median(found) <= most


def test_what_is_not_known_is_fill_and_said(runs):
    """All contacts are there, or the case is ill-conditioned or has used them up, and every number from some time on is fill."""
    for run in runs:
        known, result = run.known_contacts(), run.result
        assert results.is_fill(result["event_time"][1 + known :]).all()
        assert (result["event_kind"][1 + known :] == 0).all()
        ended = result["case_status"] == ILL_CONDITIONED
        assert ended == ("the motion is unknown" in result.attributes.get("notes", ""))
        samples = run.known_samples()
        assert results.is_fill(result["displacement"][:, samples:]).all()
        used_up = result["case_status"] == NOT_CONVERGED
        assert used_up == ("contacts used up" in result.attributes.get("notes", ""))
        if used_up:
            assert known == len(run.contacts) == int(run.inputs["max_contacts"])
            assert samples > float(run.contacts[-1]["end"]) * SAMPLES / float(run.inputs["duration"])
            continue
        if not ended:
            assert (known, samples) == (len(run.contacts), SAMPLES)
            continue
        assert samples < SAMPLES
        assert known <= len(run.contacts)
        later = run.contacts[known:]  # none of them before the histories end
        assert all(float(row["start"]) > (samples - 1) * float(run.inputs["duration"]) / SAMPLES for row in later)
    print(f"{sum(run.result['case_status'] == ILL_CONDITIONED for run in runs)} of {len(runs)} ill-conditioned")


def test_contacts_are_followed_as_long_as_16_digits_hold(runs):
    """Of all runs eight in ten contacts are given."""
    given, there = sum(run.known_contacts() for run in runs), sum(len(run.contacts) for run in runs)
    print(f"{given} of {there} contacts")
    assert given >= 0.8 * there


def tension_runs():
    """Rows of contacts of each scene with tension."""
    runs = defaultdict(list)
    for row in rows("tension_contacts.txt", PROJECT / "tests/reference"):
        runs[tuple(float(row[name]) for name in ["omega", "in_plane", "modes", "mass_ratio", "restitution"])].append(row)
    return runs


@pytest.mark.parametrize("inputs, contacts", tension_runs().items())
def test_with_fewer_digits_of_the_modes_there_is_less_that_is_known(here, inputs, contacts):
    """Modes of a beam with tension, by power series in the reference: within the errors, which are larger, every contact."""
    omega, in_plane, count, mass_ratio, restitution = inputs
    one = dict.fromkeys(["length", "area", "second_moment", "density", "youngs_modulus"], 1.0)  # h = l = 1
    scene = {
        "beam": one,
        "rotation": {"angular_velocity": omega, "plane": "in" if in_plane else "out"},
        "stiffening": {},
        "impact": {"mass_ratio": mass_ratio, "restitution": restitution},
        "recontact": {},
        "modes": {"before": int(count)},
        "response": {"duration": 2.0, "samples": 10},
    }
    result = here.simulate("a", scene, status=4 if len(contacts) == MOST else 0)
    known = (result["event_kind"] == 4).sum()
    assert known == len(contacts)
    for name, column in [("event_time", "start"), ("event_end", "end")]:
        for row, time, error in zip(contacts, result[name][1:], result[f"{name}_error"][1:]):
            assert all(found >= 1 for found in ratio(error, time, row[column]))
