"""Tolerances are kept and no error is above its estimate: a few scenes of every class, others with BEAMWAVE_SEED.

All classes with many scenes, whose figures docs/method/errors.md gives: `python -m errors` in bench/.
"""

import os

import numpy as np
import pytest
import tails
from continuum import Modes, Motion

SEED = int(os.environ.get("BEAMWAVE_SEED", "1"))
DRAWS = int(os.environ.get("BEAMWAVE_DRAWS", "1"))  # of every class
LEAST, MOST = 1e-5, 1000  # tolerance and samples, so that 30 times the modes cost little


@pytest.mark.parametrize("kind", tails.KINDS)
def test_tolerances_and_estimates_hold_against_thirty_times_the_modes(here, kind):
    compared = 0
    for i, record in enumerate(tails.RECORDS):
        for number, scene, *ways in tails.scenes(SEED, kind, record, range(DRAWS), LEAST, MOST):
            modes = ways[(i + number + tails.KINDS.index(kind)) % 2]  # a tolerance and counts in turns
            found = tails.compare(here, scene, modes)
            if found is not None:
                assert tails.holds(*found[1:]), f"seed {SEED}: {kind}, {record} {number}: {found}, {modes}"
                compared += 1
    assert compared >= (len(tails.RECORDS) - 1) * DRAWS  # a tolerance may be out of reach


@pytest.mark.parametrize("ratio", [0.0, 1e-4])
def test_rounding_is_counted_where_every_sample_is_near_a_zero_of_the_first_mode(here, ratio):
    rng = np.random.default_rng([SEED, 17])
    samples, half_periods = 400, 5
    for _ in range(3):
        gamma = tails.log_between(rng, 1, 10)
        motion = Motion(gamma, ratio=ratio)
        step = half_periods * np.pi / float(Modes(motion, gamma, 1).alpha[0] ** 2)
        groups = {"beam": tails.PAPER_BEAM, "impact": {"mass_ratio": gamma}, "capture": {}}
        if ratio:
            groups["damping"] = {"ratio": ratio}
        duration = samples * step * (1 + 1e-9) / float(tails.H)
        groups["response"] = {"duration": duration, "samples": samples, "points": [0.3, 0.5, 1.0], "velocity": True}
        found = tails.compare(here, tails.Scene(groups, motion), {"tolerance": 1e-3})
        assert found is not None
        assert min(found[2] + found[3]) >= 1, f"seed {SEED}: {gamma}, {found}"


@pytest.mark.parametrize("step", [4 / np.pi / 64, 4 / np.pi / 2**14, 3 / np.pi / 1024, 1e-6, 0.0123])
@pytest.mark.parametrize("point", [0.999, 0.5])
def test_a_few_samples_of_a_long_record_tell_what_is_left_out_at_all(here, step, point):
    """Waves meet at multiples of the step, or have not spread yet at the first samples, or do neither."""
    samples = 2**15
    duration = samples * step / float(tails.H)
    groups = {"beam": tails.PAPER_BEAM, "impact": {"mass_ratio": 0.2}, "capture": {},
              "response": {"duration": duration, "samples": samples, "points": [point, 1.0]}}
    here.scene("few", {**groups, "modes": {"tolerance": 1e-4}})
    few, many = here.run("few"), here.simulate("many", {**groups, "modes": {"tolerance": 1e-8}})
    error = np.abs(few["displacement"] - many["displacement"]).max(axis=1)
    peak = np.abs(many["displacement"]).max(axis=1)
    assert error.max() <= 1e-4 * peak.max()
    seen = error > 1e-12 * peak
    assert (few["displacement_error"] >= error - many["displacement_error"])[seen].all()
    assert (few["displacement_bound"] >= few["displacement_error"]).all()
