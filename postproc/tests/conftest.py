"""Results to test on: synthetic ones always, and a directory of real ones where it is given."""

import os
from pathlib import Path

import pytest
import synthetic

from beamwave_postproc.run import find_program

PAPER_SWEEPS = {
    "fig2": ({}, {"rotation_angular_velocity": [0.0, 50.0, 100.0]}),
    "fig3": ({}, {"modes_before": [5, 10, 20, 50]}),
    "fig4": ({}, {"rotation_angular_velocity": [0.0, 50.0, 100.0]}),
    "fig5": ({}, {"rotation_angular_velocity": [0.0, 50.0, 100.0]}),
    "fig6": (
        {"response": {"duration": 0.2, "samples": 2000, "points": [0.5, 1.0]}},
        {"rotation_angular_velocity": [0.0, 50.0, 100.0]},
    ),
    "fig7": (
        {"response": {"duration": 0.2, "samples": 2000, "points": [0.5, 1.0]}, "rotation": {"angular_velocity": 50.0}},
        {"impact_mass_ratio": [0.1, 0.2, 0.5, 1.0]},
    ),
}


def pytest_addoption(parser):
    parser.addoption(
        "--results",
        default=os.environ.get("BEAMWAVE_RESULTS"),
        help="directory of results made by the program, for the tests of the xarray idioms "
        "(default: $BEAMWAVE_RESULTS, else synthetic files)",
    )


@pytest.fixture(autouse=True)
def _coarse(monkeypatch):
    """Files of pictures have few dots, which are written sooner."""
    monkeypatch.setattr("beamwave_postproc.files.DPI", 50)
    monkeypatch.setattr("beamwave_postproc.page.html.DPI", 50)


@pytest.fixture(scope="session")
def beamwave():
    """Path of the program, where it is built; elsewhere what needs it is skipped."""
    try:
        return str(Path(find_program()).absolute())
    except FileNotFoundError:
        pytest.skip("the program is not built")


@pytest.fixture(scope="session")
def stand_in():
    """Makes a program `beamwave` in a directory that does what a script says; returns its path."""

    def make(directory, script):
        path = directory / "beamwave"
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)
        return path

    return make


@pytest.fixture(scope="session")
def paper_results(tmp_path_factory):
    """Directory with fig2.nc … fig7.nc."""
    directory = tmp_path_factory.mktemp("paper")
    for name, (groups, sweep) in PAPER_SWEEPS.items():
        synthetic.write(directory / f"{name}.nc", synthetic.scene(**groups), sweep)
    return directory


@pytest.fixture(scope="session")
def full_result(tmp_path_factory):
    """One case with everything: events, displacement, velocity, spectrum, measured peaks."""
    settings = synthetic.scene(
        rotation={"angular_velocity": 50.0},
        modes={"before": 40, "after": 40},
        response={"duration": 1.0, "samples": 2**14, "velocity": True},
        spectrum={"max_peaks": 10},
    )
    return synthetic.write(tmp_path_factory.mktemp("full") / "struck.nc", settings)


@pytest.fixture(scope="session")
def grid_result(tmp_path_factory):
    """Sweep of two inputs, unstable (filled) where the beam turns fast."""
    settings = synthetic.scene(modes={"before": 6, "after": 6})
    sweep = {
        "impact_mass_ratio": [0.1, 0.2, 0.5, 1.0],
        "rotation_angular_velocity": [float(omega) for omega in range(0, 151, 10)],
    }
    return synthetic.write(tmp_path_factory.mktemp("grid") / "grid.nc", settings, sweep)


@pytest.fixture(scope="session")
def results(request, paper_results, full_result, grid_result):
    """Paths of the results that the idioms are tried on."""
    given = request.config.getoption("--results")
    if given is None:
        return [*sorted(paper_results.glob("*.nc")), full_result, grid_result]
    found = sorted(Path(given).glob("*.nc"))
    assert found, f"no result in {given}"
    return found
