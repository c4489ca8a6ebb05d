"""A sweep is its cases run one by one, in the product's order, with what a case lacks left as fill."""

import itertools

import numpy as np
import pytest
import results
from workplace import captured_beam

RATIOS = [0.1, 0.5, 1.0]
SPEEDS = [0.0, 100.0]
COUNTS = [3, 9, 5]
RESPONSE = {"duration": 0.1, "samples": 256}


def sweep(parameter, values):
    return {"parameter": parameter, "values": values}


@pytest.fixture(scope="module")
def product(shared):
    """Mass ratio slowest, then angular velocity."""
    place = shared("product")
    return place.simulate(
        "a",
        captured_beam(response=RESPONSE),
        sweep("impact%mass_ratio", RATIOS),
        sweep("rotation%angular_velocity", SPEEDS),
    )


def test_case_leads_what_depends_on_it_and_nothing_else(product):
    alone = {"mode", "mode_before", "event", "stage", "stage_seconds", "time", "point_position", "profile_position"}
    swept = {"impact_mass_ratio", "rotation_angular_velocity"}
    for name, (dimensions, _, attributes) in product.variables.items():
        is_input = name.split("_")[0] in captured_beam() | {"response": {}}
        if name in alone or (is_input and name not in swept):
            assert "case" not in dimensions, name
        else:
            assert dimensions[0] == "case", name
            if name != "case" and name not in swept:
                assert swept <= set(attributes["coordinates"].split()), name


def test_a_case_holds_what_its_own_scene_gives(product, here):
    for case, (ratio, speed) in enumerate(itertools.product(RATIOS, SPEEDS)):
        name = f"case{case}"
        alone = here.simulate(
            name, captured_beam(impact={"mass_ratio": ratio}, rotation={"angular_velocity": speed}, response=RESPONSE)
        )
        for variable, (dimensions, values, _) in alone.variables.items():
            swept = "case" in product.variables[variable].dimensions
            if variable != "stage_seconds":
                there = product[variable][case] if swept else product[variable]
                assert there.tobytes() == values.tobytes(), (variable, dimensions)


def test_a_value_that_is_swept_replaces_the_one_in_its_group(here):
    here.scene("a", captured_beam(impact={"mass_ratio": 7.0}), sweep("impact%mass_ratio", RATIOS))
    np.testing.assert_array_equal(here.run("a")["impact_mass_ratio"], RATIOS)


def test_modes_that_a_case_lacks_are_fill(here):
    result = here.simulate("a", captured_beam(modes={"before": 4}), sweep("modes%after", COUNTS))
    assert result.sizes["mode"] == max(COUNTS)
    np.testing.assert_array_equal(result["mode_count"], COUNTS)
    expected = np.arange(max(COUNTS)) >= np.array(COUNTS)[:, np.newaxis]
    for name in ["alpha", "angular_frequency", "growth_rate", "modal_mass", "modal_velocity", "group_velocity"]:
        np.testing.assert_array_equal(results.is_fill(result[name]), expected, err_msg=name)
    np.testing.assert_array_equal(result["modes_after"], COUNTS)


def test_a_range_is_its_values(here):
    ranged = {"parameter": "impact%mass_ratio", "first": 0.125, "last": 8.0, "count": 4, "spacing": "log"}
    here.scene("a", captured_beam(), ranged)
    here.scene("b", captured_beam(), {**ranged, "spacing": "linear"})
    # powers of the ratio: a rounding each; the ends are the given numbers
    logarithmic, linear = here.run("a")["impact_mass_ratio"], here.run("b")["impact_mass_ratio"]
    np.testing.assert_allclose(logarithmic, [0.125, 0.5, 2.0, 8.0], rtol=1e-15)
    np.testing.assert_allclose(linear, [0.125, 2.75, 5.375, 8.0], rtol=1e-15)
    assert (logarithmic[0], logarithmic[-1], linear[0], linear[-1]) == (0.125, 8.0, 0.125, 8.0)


def test_the_lowest_speed_at_which_a_mode_grows_is_where_it_grows(here):
    critical = float(here.simulate("one", captured_beam())["critical_angular_velocity"])
    speeds = [critical * (1 - 1e-12), critical * (1 + 1e-12)]
    result = here.simulate("a", captured_beam(), sweep("rotation%angular_velocity", speeds))
    assert (result["growth_rate"][:, 0] > 0).tolist() == [False, True]
    assert results.is_fill(result["angular_frequency"][:, 0]).tolist() == [False, True]
    assert not (result["growth_rate"][:, 1:] > 0).any()
