"""Which cases of a sweep are drawn, on which axes, and what is said of the rest."""

import numpy as np
import pytest
import synthetic

from beamwave_postproc import NothingToDraw, dispersion, open_result, swept_inputs
from beamwave_postproc.parts.curves import panels_of
from beamwave_postproc.style import MAX_CURVES

BETA = "angular_frequency"


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    """A sweep of three inputs: 2 × 3 × 2 cases."""
    sweep = {
        "beam_length": [1.0, 2.0],
        "impact_mass_ratio": [0.1, 0.2, 0.5],
        "rotation_angular_velocity": [0.0, 10.0],
    }
    settings = synthetic.scene(modes={"before": 3, "after": 3})
    with open_result(synthetic.write(tmp_path_factory.mktemp("three") / "three.nc", settings, sweep)) as ds:
        return ds.load()


def test_swept_inputs_come_slowest_first(grid_result, full_result):
    with open_result(grid_result) as ds:
        assert swept_inputs(ds) == ["impact_mass_ratio", "rotation_angular_velocity"]
    with open_result(full_result) as ds:
        assert swept_inputs(ds) == []


def test_the_curves_of_a_panel_differ_in_one_input_and_the_panels_in_another(grid_result):
    with open_result(grid_result) as ds:
        drawn = panels_of(ds, BETA)
        assert [panel.title for panel in drawn.panels] == [
            rf"$\gamma$ = {ratio}".replace(" ", "\u00a0") for ratio in (0.1, 0.2, 0.5, 1)
        ]
        for panel, ratio in zip(drawn.panels, (0.1, 0.2, 0.5, 1.0)):
            assert {float(curve.data["impact_mass_ratio"]) for curve in panel.curves} == {ratio}
            speeds = [float(curve.data["rotation_angular_velocity"]) for curve in panel.curves]
            assert speeds[0] == 0.0 and np.all(np.diff(speeds) > 0.0)
        assert drawn.notes == ["20 of 64 cases"]
        assert len(dispersion(ds).axes) == 4


def test_of_three_inputs_the_slowest_stays_and_is_told(three):
    drawn = panels_of(three, BETA)
    assert [len(panel.curves) for panel in drawn.panels] == [2, 2, 2]
    assert {float(curve.data["beam_length"]) for curve in drawn.curves} == {1.0}
    assert drawn.notes == ["6 of 12 cases, all with $l$\u00a0=\u00a01\u00a0m"]


def test_on_one_pair_of_axes_all_inputs_but_the_fastest_stay(three):
    drawn = panels_of(three, BETA, panels=1)
    assert len(drawn.panels) == 1 and len(drawn.curves) == 2
    assert "$l$" in drawn.notes[0] and r"$\gamma$" in drawn.notes[0]


def test_cases_that_are_no_product_share_a_panel_and_name_all_that_differs(three):
    (panel,) = panels_of(three.isel(case=[0, 3, 11]), BETA).panels
    assert len({curve.label for curve in panel.curves}) == 3
    assert all(curve.label.count("=") == 3 for curve in panel.curves)


def test_cases_that_do_not_differ_still_have_names(three):
    assert all("$l$" in curve.label for curve in panels_of(three.isel(case=[0, 0]), BETA).curves)


def test_many_cases_of_one_input_are_thinned_evenly_and_the_head_says_so(grid_result):
    with open_result(grid_result) as ds:
        one = ds.isel(case=slice(16))
        drawn = panels_of(one, BETA)
        assert len(drawn.curves) == MAX_CURVES and drawn.notes == ["8 of 16 cases"]
        assert [int(curve.data["case"]) for curve in drawn.curves][:: MAX_CURVES - 1] == [1, 16]


def test_labels_have_as_many_digits_as_tell_the_cases_apart(tmp_path):
    speeds = [121.8335, 121.83354, 121.8336]
    settings = synthetic.scene(modes={"before": 2, "after": 2})
    with open_result(synthetic.write(tmp_path / "near.nc", settings, {"rotation_angular_velocity": speeds})) as ds:
        assert len({curve.label for curve in panels_of(ds, "wavenumber").curves}) == 3


def test_a_case_without_numbers_is_named_with_its_status(three):
    flags = {"flag_values": [0, 1], "flag_meanings": "done diverged"}
    status = ("case", np.where(three["case"] == 1, 1, 0), flags)
    holed = three.assign({BETA: three[BETA].where(three["case"] != 1), "case_status": status}).isel(case=[0, 1])
    drawn = panels_of(holed, BETA)
    assert len(drawn.curves) == 1
    assert drawn.notes == ["no numbers: $\\omega$\u00a0=\u00a00\u00a0rad/s (diverged)"]
    with pytest.raises(NothingToDraw, match="nothing but fill"):
        panels_of(three.assign({BETA: np.nan * three[BETA]}), BETA)
