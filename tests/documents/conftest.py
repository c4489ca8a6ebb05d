"""Options and programs of the documents' tests."""

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "scenes"))

from documents import PROJECT  # noqa: E402


def pytest_addoption(parser):
    parser.addoption("--beamwave", default=PROJECT / "build/bin/beamwave", type=Path, help="the program")
    parser.addoption("--beamwave-mpi", type=Path, help="its twin for mpirun, where it was built")


@pytest.fixture(scope="session")
def program(request):
    """Path of the program."""
    path = request.config.getoption("--beamwave").resolve()
    assert os.access(path, os.X_OK), f"{path} is no program; --beamwave names it"
    return path


@pytest.fixture(scope="session")
def twin(request):
    """Path of its twin for mpirun; None where it was not built."""
    path = request.config.getoption("--beamwave-mpi")
    return path and path.resolve()
