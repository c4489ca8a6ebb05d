"""Memory stays below twice the result and 200 MB, in sizes at which what is held twice would show; a check foretells it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from long_work import TENSION, of_pieces, with_tolerance
from workplace import captured_beam, namelist

BENCH = Path(__file__).parents[2] / "bench"
sys.path.insert(0, str(BENCH))

CASES = {
    "many modes": {"modes": {"before": 50, "after": 1_000_000}, "response": {"duration": 1.0, "samples": 4096}},
    "a long record with its waves measured": {
        "modes": {"before": 1, "after": 1},
        "response": {"duration": 1.0, "samples": 3 * 2**20},
        "spectrum": {},
    },
}

FORETOLD = {
    "a tolerance with tension and shear": with_tolerance(1e-4, stiffening={}, shear={}),
    "many modes with tension": captured_beam(stiffening={}, modes={"before": 400, "after": 400}),
    "pieces with tension": of_pieces(30, modes={"before": 20, "after": 20}, **TENSION),
    "many modes of pieces": of_pieces(200, modes={"before": 2, "after": 600}),
    **{name: captured_beam(**groups) for name, groups in CASES.items()},
}


RECORD = (2**16, 32)  # samples and sensors: of a few lines in noise


@pytest.fixture
def large_record(tmp_path):
    """A scene of a record that takes more memory than the program, and than what does not grow with it."""
    from large_records.bench import write

    write(tmp_path / "record.nc", *RECORD)
    return "&record\n  file = 'record.nc'\n/\n&spectrum /\n"


def peak_memory(program, directory, scene, *words):
    """Bytes that `beamwave run` took."""
    from common.measuring import LAUNCH

    (directory / "large.nml").write_text(scene)
    words = [sys.executable, "-I", "-S", LAUNCH, program, "run", "large.nml", "--quiet", *words]
    ended = subprocess.run(words, cwd=directory, capture_output=True, text=True, check=False)
    assert ended.returncode in (0, 5), ended.stderr  # stopped: the memory was taken before
    return int(ended.stdout.split()[-1])


@pytest.mark.parametrize("groups", CASES.values(), ids=CASES.keys())
def test_memory_stays_below_twice_the_result_and_200_mb(program, tmp_path, groups):
    from growth.bench import bound

    memory = peak_memory(program, tmp_path, namelist(captured_beam(**groups)))
    assert memory <= bound({"result_bytes": (tmp_path / "output/large.nc").stat().st_size})


def test_memory_hardly_grows_with_the_number_of_cases(program, tmp_path):
    sweeps = [
        {"parameter": f"beam%{name}", "first": first, "last": 2 * first, "count": 150}
        for name, first in [("length", 1.0), ("diameter", 0.03), ("density", 4000.0)]
    ]
    few, many = (
        peak_memory(program, tmp_path, namelist({**captured_beam(), "modes": {"before": 1, "after": 1}}, *some), *words)
        for some, words in [(sweeps[:1], ()), (sweeps, ("--overwrite", "--max-seconds", "1"))]
    )
    assert many - few <= 8 * 150**3  # bytes a case: less than one number


@pytest.mark.parametrize("groups", FORETOLD.values(), ids=FORETOLD.keys())
def test_a_check_foretells_memory(program, tmp_path, groups):
    foretells(program, tmp_path, namelist(groups))


def test_a_check_foretells_the_memory_of_a_record(program, tmp_path, large_record):
    foretells(program, tmp_path, large_record)


def foretells(program, tmp_path, scene):
    used = peak_memory(program, tmp_path, scene)
    ended = subprocess.run([program, "check", "large.nml"], cwd=tmp_path, capture_output=True, text=True, check=True)
    number, unit = re.search(r"memory +([\d.]+) ([MG])B", ended.stdout).groups()
    assert used <= float(number) * {"M": 1e6, "G": 1e9}[unit] <= 5 * used
