"""The program under test, and a directory of its own for every test."""

import os
from pathlib import Path

import pytest
from faults import Injector
from workplace import MPI_ON_FEW_CORES, Workplace

PROJECT = Path(__file__).parents[2]


def pytest_addoption(parser):
    parser.addoption("--beamwave", default=PROJECT / "build/bin/beamwave", type=Path, help="the program")
    parser.addoption("--beamwave-mpi", type=Path, help="its twin for mpirun; tests that need it are skipped without")
    parser.addoption("--mpirun", default="mpirun", help="what starts it")
    parser.addoption("--injector", type=Path, help="fault_injector, built beside the tests; tests that need it are skipped without")
    parser.addoption("--faulty-program", type=Path, help="ends_in_a_fault, built beside the tests")


@pytest.fixture(scope="session")
def program(request):
    """Path of the program."""
    path = request.config.getoption("--beamwave").resolve()
    assert os.access(path, os.X_OK), f"{path} is no program; --beamwave names it"
    return path


@pytest.fixture
def here(program, tmp_path):
    """A directory with scenes and their results."""
    return Workplace(program, tmp_path)


@pytest.fixture(scope="session")
def shared(program, tmp_path_factory):
    """Makes a directory whose results several tests of a file read."""
    return lambda name: Workplace(program, tmp_path_factory.mktemp(name))


@pytest.fixture(scope="session")
def injector(request):
    """Makes calls of the system fail."""
    library = request.config.getoption("--injector")
    if library is None:
        pytest.skip("nothing can be preloaded here")
    return Injector(library.resolve())


@pytest.fixture
def processes(request, tmp_path):
    """Makes a `here` in which that many processes share the work: 1 is the program itself, more are its twin's."""

    def crew(number):
        if number == 1:
            return Workplace(request.config.getoption("--beamwave").resolve(), tmp_path)
        twin = request.config.getoption("--beamwave-mpi")
        if twin is None:
            pytest.skip("no MPI here")
        launcher = (request.config.getoption("--mpirun"), "-n", str(number))
        return Workplace(twin.resolve(), tmp_path, launcher, {**os.environ, **MPI_ON_FEW_CORES})

    return crew
