"""Memory stays below twice the result and 200 MB, in sizes at which what is held twice would show."""

import subprocess
import sys
from pathlib import Path

import pytest
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


def peak_memory(program, directory, scene, *words):
    """Bytes that `beamwave run` took."""
    from growth.measure import LAUNCH

    (directory / "large.nml").write_text(scene)
    words = [sys.executable, "-I", "-S", LAUNCH, program, "run", "large.nml", "--quiet", *words]
    ended = subprocess.run(words, cwd=directory, capture_output=True, text=True, check=False)
    assert ended.returncode in (0, 5), ended.stderr  # stopped: the memory was taken before
    return int(ended.stdout.split()[-1])


@pytest.mark.parametrize("groups", CASES.values(), ids=CASES.keys())
def test_memory_stays_below_twice_the_result_and_200_mb(program, tmp_path, groups):
    from growth.slope import bound

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
