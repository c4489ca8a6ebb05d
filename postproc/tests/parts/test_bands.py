"""Many cases at once: the bands in which they lie."""

import numpy as np
import pytest
import synthetic
from matplotlib.figure import Figure

from beamwave_postproc import displacement, group_velocity, open_result
from beamwave_postproc.parts.bands import BANDS, draw_bands, is_scattered

GRID = {"impact_mass_ratio": [0.1, 0.2, 0.3, 0.4], "impact_approach_velocity": [1.0, 1.5, 2.0]}


@pytest.fixture(scope="module")
def grid(tmp_path_factory):
    settings = synthetic.scene(modes={"before": 4, "after": 4}, response={"duration": 0.1, "samples": 64})
    with open_result(synthetic.write(tmp_path_factory.mktemp("bands") / "grid.nc", settings, GRID)) as ds:
        return ds.load()


def test_cases_of_a_table_are_scattered_and_those_of_a_grid_or_few_are_not(grid):
    assert is_scattered(grid.isel(case=slice(1, None)))
    assert not is_scattered(grid) and not is_scattered(grid.isel(case=slice(1, 8))) and not is_scattered(grid.isel(case=0))


def test_bands_hold_their_share_of_evenly_spread_cases():
    axes = Figure().subplots()
    draw_bands(axes, np.array([0.0, 1.0]), np.linspace([0.0, 10.0], [1.0, 30.0], 101))
    for drawn, (share, *_) in zip(axes.collections, BANDS):
        heights = drawn.get_paths()[0].vertices
        for at, low, high in ((0.0, 0.0, 1.0), (1.0, 10.0, 30.0)):
            ends = heights[heights[:, 0] == at, 1]
            assert np.ptp(ends) == pytest.approx(share * (high - low))
    np.testing.assert_allclose(axes.lines[0].get_ydata(), [0.5, 20.0])


def test_scattered_cases_are_bands_on_the_axes_of_histories_and_of_waves(grid):
    cases = grid.isel(case=slice(1, None))
    fig = displacement(cases)
    assert [len(axes.collections) for axes in fig.axes] == [len(BANDS)] * 2
    assert any("11 cases" in text.get_text() for text in fig.texts)
    above, below = group_velocity(cases).axes
    np.testing.assert_allclose(above.lines[0].get_ydata(), cases["group_velocity"].median("case"))
    assert len(below.collections) == len(BANDS) and "%" in below.get_ylabel()


def test_a_case_without_numbers_is_counted(grid):
    cases = grid.isel(case=slice(1, None)).copy(deep=True)
    cases["displacement"].values[3] = np.nan
    assert any("10 cases, 1 more without numbers" in text.get_text() for text in displacement(cases).texts)
