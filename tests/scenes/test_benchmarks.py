"""docs/benchmarks.md: the program gives the published numbers, to their digits or the stated difference, and the page shows what it gives."""

import re
import sys

import pytest
import xarray as xr
from conftest import PROJECT

sys.path.insert(0, str(PROJECT / "bench"))
from benchmarks.__main__ import line_of, section  # noqa: E402
from benchmarks.problems import problems  # noqa: E402

PAGE = (PROJECT / "docs/benchmarks.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("problem", problems(), ids=lambda problem: problem.title)
def test_published_numbers_are_met_and_shown(shared, problem):
    place = shared("benchmarks")
    place.beamwave("run", *(PROJECT / f"input/benchmarks/{scene}.nml" for scene in problem.scenes), "--quiet", status=0)
    results = {scene: xr.load_dataset(place.directory / f"output/{scene}.nc") for scene in problem.scenes}
    assert problem.rows
    for row in problem.rows:
        assert row.ours(results) == pytest.approx(float(row.published), rel=row.tolerance), row.what
        assert line_of(row, results) in PAGE
    assert section(problem, results).strip() in PAGE


def test_every_benchmark_scene_is_compared():
    used = {scene for problem in problems() for scene in problem.scenes}
    assert used == {path.stem for path in (PROJECT / "input/benchmarks").glob("*.nml")}
    assert used == set(re.findall(r"benchmarks/(\w+)\.nml", PAGE))
