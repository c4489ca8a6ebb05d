"""A Slurm for the tests of this session, and a directory of its own for every test."""

import os
import shutil
import sys
from pathlib import Path

import pytest

for folder in ("scenes", "documents"):
    sys.path.insert(0, str(Path(__file__).parents[1] / folder))

from slurm import PROJECT, Jobs, Slurm  # noqa: E402
from workplace import Workplace  # noqa: E402

NEEDED = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo"]
SKIPPED = 77  # what CTest takes for a skip


def pytest_addoption(parser):
    parser.addoption("--beamwave", default=PROJECT / "build/bin/beamwave", type=Path, help="the program")


def pytest_sessionstart():
    """Without Slurm all is skipped, or, where it has to be there, fails."""
    os.environ["PATH"] += ":/usr/sbin:/sbin"  # where daemons are, and users do not look
    missing = [name for name in NEEDED if not shutil.which(name)]
    if missing:
        required = os.environ.get("BEAMWAVE_REQUIRE_SLURM")
        pytest.exit(f"Slurm is not installed: no {', '.join(missing)}", returncode=1 if required else SKIPPED)


@pytest.fixture(scope="session")
def slurm():
    """A Slurm that runs."""
    with Slurm() as running:
        yield running


@pytest.fixture(scope="session")
def program(request):
    """Path of the program."""
    return request.config.getoption("--beamwave").resolve()


@pytest.fixture
def here(program, tmp_path):
    """A directory with scenes and their results, whose name has a space."""
    return place_in(program, tmp_path)


@pytest.fixture(scope="session")
def shared(program, tmp_path_factory):
    """Makes a directory that several tests use."""
    return lambda name: place_in(program, tmp_path_factory.mktemp(name))


def place_in(program, directory):
    place = directory / "a place"
    place.mkdir()
    return Workplace(program, place)


@pytest.fixture(scope="session")
def jobs(slurm, program):
    """Submits jobs that find the program, and this Python, on their PATH."""
    path = f"{program.parent}:{Path(sys.executable).parent}:{os.environ['PATH']}"
    as_root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return Jobs({**os.environ, **as_root, "PATH": path, "SLURM_CONF": str(slurm.configuration)})
