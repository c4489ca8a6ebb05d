"""The program under test, and a directory of its own for every test."""

import os
from pathlib import Path

import pytest
from workplace import Workplace

PROJECT = Path(__file__).parents[2]


def pytest_addoption(parser):
    parser.addoption("--beamwave", default=PROJECT / "build/bin/beamwave", type=Path, help="the program")
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
