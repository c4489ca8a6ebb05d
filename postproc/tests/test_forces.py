"""The force of contacts as a file for `&force`."""

import numpy as np
import pandas as pd
import pytest

from beamwave_postproc import NothingToDraw, open_result, run
from beamwave_postproc.forces import FINE, forces, main

SAMPLES = 128
PARTS = 0.5 * (1.0 - np.cos(np.pi * np.arange(SAMPLES) / (SAMPLES - 1)))
BEAM = {"length": 1.0, "density": 7870.0, "youngs_modulus": 2e11, "diameter": 0.037}
RESPONSE = {"duration": 5e-3, "samples": 1024, "points": [0.5, 1.0]}


@pytest.fixture
def touched(full_result):
    """Two contacts, the second of which begins as the first ends; forces are a polynomial and half a sine."""
    force = np.stack([PARTS**2 * (1.0 - PARTS), np.sin(np.pi * PARTS)])
    times = {"event_time": ("event", [0.1, 0.2]), "event_end": ("event", [0.2, 0.4])}
    with open_result(full_result) as ds:
        bare = ds.drop_vars([name for name in ds.variables if name.startswith("event")]).load()
    return bare.assign({**times, "contact_force": (("event", "contact_sample"), force, {"units": "N"})})


def test_between_the_points_of_a_contact_lies_the_polynomial_through_them(touched):
    time, force = forces(touched, [1]).values.T
    part = (time - 0.1) / 0.1
    assert time.size == FINE * (SAMPLES - 1) + 1 and (time[0], time[-1]) == pytest.approx((0.1, 0.2))
    np.testing.assert_allclose(force, part**2 * (1.0 - part), atol=1e-13)  # rounding


def test_contacts_follow_each_other_in_times_that_rise(touched):
    time, force = forces(touched).values.T
    assert np.all(np.diff(time) > 0.0) and time.size == 2 * FINE * (SAMPLES - 1) + 1
    # Straight over intervals h = (pi/2n) sin(theta) T, half a sine of length T loses 1/12 of the integral of F'' h^2.
    late = time >= 0.2
    impulse = np.sum(0.5 * np.diff(time[late]) * (force[late][1:] + force[late][:-1]))
    exact, theta, n = 0.2 * 2.0 / np.pi, np.linspace(0.0, np.pi, 20001), FINE * (SAMPLES - 1)
    curve = np.sin(0.5 * np.pi * (1.0 - np.cos(theta))) * np.sin(theta) ** 3
    lost = 0.2 * (np.pi**2 / 12.0) * (np.pi / (2 * n)) ** 2 * 0.5 * np.sum(curve) * (theta[1] - theta[0])
    assert exact - impulse == pytest.approx(lost, rel=1e-3) and lost < 1e-5 * exact


def test_a_contact_that_is_not_there_is_named(touched):
    with pytest.raises(NothingToDraw, match="no contact 3; it has 2, from 1 to 2"):
        forces(touched, [1, 3])


def test_the_force_of_the_contacts_moves_the_beam_as_the_contacts_do(beamwave, tmp_path, capsys):
    strike = {"impact": {"mass": 0.515, "approach_velocity": 1.0}, "contact": {"radius": 0.025}}
    struck = run({"beam": BEAM, **strike, "response": RESPONSE}, output=tmp_path, program=beamwave)
    assert main([str(tmp_path / "scene.nc")]) == 0
    table, group = capsys.readouterr().out.splitlines()
    assert group.strip() == "&force position = 1, shape = 'file', file = 'scene_contact_force.csv' /"
    assert list(pd.read_csv(table, comment="#")) == ["time [s]", "force [N]"]
    force = {"position": 1.0, "shape": "file", "file": table}
    forced = run({"beam": BEAM, "force": force, "response": RESPONSE}, program=beamwave)
    peak = np.abs(struck["displacement"]).max("time")
    wrong = (np.abs(forced["displacement"] - struck["displacement"]).max("time") / peak).values
    # The impulse that straight lines lose, 6e-6 of it, and the tolerances of both runs, 1e-6.
    assert wrong.max() < 1e-5
