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


@pytest.mark.parametrize("groups", CASES.values(), ids=CASES.keys())
def test_memory_stays_below_twice_the_result_and_200_mb(program, tmp_path, groups):
    from growth.measure import LAUNCH
    from growth.slope import bound

    (tmp_path / "large.nml").write_text(namelist(captured_beam(**groups)))
    words = [sys.executable, "-I", "-S", LAUNCH, program, "run", "large.nml", "--quiet"]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    memory = int(ended.stdout.split()[-1])
    assert memory <= bound({"result_bytes": (tmp_path / "output/large.nc").stat().st_size})
