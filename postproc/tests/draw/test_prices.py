"""The work–precision diagram: both ladders, what is not resolved, and the price of each digit."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import NothingToDraw, open_result, work_precision


@pytest.fixture
def study():
    """Three tolerances, the last not timed, and two counts."""
    missing = np.nan
    per_rung = {
        "ladder": [1, 1, 1, 2, 2],
        "tolerance": [1e-2, 1e-3, 1e-4, missing, missing],
        "true_error": [5e-3, 4e-4, missing, 1e-2, 1e-5],
        "seconds": [1e-3, 1.2e-3, missing, 1e-3, 1e-2],
        "seconds_lower": [0.9e-3, 1.1e-3, missing, 0.9e-3, 0.9e-2],
        "seconds_upper": [1.1e-3, 1.5e-3, missing, 1.2e-3, 1.1e-2],
        "digit_seconds": [2e-4, missing, missing, missing, missing],
        "digit_growth": [0.2, missing, missing, missing, missing],
    }
    shares = np.outer(np.nan_to_num(per_rung["seconds"]), [0.2, 0.1, 0.7])
    words = {"flag_meanings": "modes events response"}
    return xr.Dataset(
        {name: ("rung", values) for name, values in per_rung.items()}
        | {"stage_seconds": (("rung", "stage"), shares), "converged_error": 2e-5},
        {"rung": np.arange(1, 6), "stage": ("stage", [1, 2, 3], words)},
        {"title": "a study", "machine": "a machine"},
    )


def test_each_ladder_is_a_curve_of_its_timed_rungs(study):
    axes = work_precision(study).axes[0]
    assert axes.get_xlabel() == "Largest error of any history over its peak"
    curves = {line.get_label(): line for line in axes.lines}
    drawn = sorted(len(box.lines[0].get_xdata()) for box in axes.containers)
    assert drawn == [2, 2]
    assert "for comparison: 25% more time for each digit" in curves
    assert axes.get_xlim()[0] > axes.get_xlim()[1]


def test_the_head_says_what_a_digit_takes_on_average(study):
    # A tenth of the error, from 5e-3 to 4e-4, is 1.097 digits: 1.2 to that root.
    said = "each digit takes on average 18% more time, from an error of 0.005 to 0.0004"
    assert any(said in text.get_text().replace("\n", " ") for text in work_precision(study).texts)
    one = study.isel(rung=[0, 3, 4])
    assert not any("on average" in text.get_text() for text in work_precision(one).texts)


def test_errors_below_the_converged_run_are_shaded(study):
    fig = work_precision(study)
    labels = [text.get_text() for text in fig.legends[0].get_texts()]
    assert any("a machine" in text.get_text() for text in fig.texts) and fig.texts[0].get_text() == "a study"
    assert "not resolved by the converged run" in labels
    fine = study.assign(converged_error=1e-13)
    assert "not resolved by the converged run" not in work_precision(fine).axes[0].get_legend_handles_labels()[1]


def test_stage_shares_fill_the_bars_and_digits_carry_their_growth(study):
    _, shares, digits = work_precision(study).axes
    assert shares.get_legend_handles_labels()[1] == ["modes", "events", "response"]
    assert max(bar.get_y() + bar.get_height() for bar in shares.patches) == pytest.approx(100.0)
    assert "+20%" in [text.get_text() for text in digits.texts]


def test_a_price_within_the_noise_has_no_bar(study):
    noisy = study.assign(digit_noise=("rung", [3e-4, *4 * [np.nan]]))
    below = study.assign(digit_seconds=("rung", [-2e-4, *4 * [np.nan]]))
    for measured in (noisy, below):
        digits = work_precision(measured).axes[2]
        assert "+20%" not in [text.get_text() for text in digits.texts]
        assert all(bar.get_height() == 0.0 for bar in digits.patches)


def test_without_an_error_there_is_nothing_to_draw(study, full_result):
    with pytest.raises(NothingToDraw):
        work_precision(study.assign(true_error=("rung", np.zeros(5))))
    with open_result(full_result) as ds, pytest.raises(NothingToDraw):
        work_precision(ds)
