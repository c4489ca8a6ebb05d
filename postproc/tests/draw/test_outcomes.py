"""What the cases of a sweep of one input came to, over that input."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import NothingToDraw, outcome_map, outcomes


def swept(name, values, units="1", **variables):
    """A sweep of one input; `variables` are dimensions, numbers and unit of each."""
    ds = xr.Dataset({key: (dims, numbers, {"units": unit}) for key, (dims, numbers, unit) in variables.items()})
    cases = {"case": np.arange(1, len(values) + 1), name: ("case", np.array(values), {"units": units})}
    return ds.assign_coords(cases | {"point_position": ("point", [0.0, 0.5, 1.0]), "mode": [1, 2]})


def struck(places=(0.6, 0.2, 1.0)):
    stress = np.array([[3e6, 2e6, 0.0], [1e6, 1.5e6, 0.0], [4e6, 1e6, 0.0]])
    moved = np.array([[0.0, 2e-3, 4e-3], [0.0, 1e-3, 3e-3], [0.0, 3e-3, 6e-3]])
    along = ("case", "point")
    return swept("impact_position", places, largest_stress=(along, stress, "Pa"), largest_displacement=(along, moved, "m"))


def lines(axes):
    """Numbers of the curves on the axes, by their colour."""
    return {line.get_color(): line.get_xydata().tolist() for line in axes.lines if len(line.get_xdata())}


def test_numbers_stand_over_the_input_in_its_order_each_point_in_one_colour():
    fig = outcomes(struck())
    moved, stress = fig.axes
    assert (moved.get_ylabel(), stress.get_ylabel()) == ("Largest displacement (mm)", "Largest bending stress (MPa)")
    assert r"$\xi_0$" in moved.get_xlabel()
    entries = zip(fig.legends[0].get_texts(), fig.legends[0].get_lines())
    root, middle, tip = [(text.get_text(), line.get_color()) for text, line in entries]
    assert [words.split("= ")[1] for words, _ in (root, middle, tip)] == ["0", "0.5", "1"]
    assert lines(stress)[root[1]] == pytest.approx(np.array([[0.2, 1.0], [0.6, 3.0], [1.0, 4.0]]))
    assert lines(moved)[tip[1]] == pytest.approx(np.array([[0.2, 3.0], [0.6, 4.0], [1.0, 6.0]]))
    assert root[1] not in lines(moved) and tip[1] not in lines(stress)  # where nothing moves, or bends


def test_frequencies_that_an_input_changes_are_in_hertz_and_those_over_the_speed_are_left_to_campbell():
    beta = 2.0 * np.pi * np.array([[10.0, 50.0], [11.0, 50.0], [12.0, 50.0]])
    root = swept("support_rotational_stiffness", [1e2, 1e4, 1e6], "N m rad-1", angular_frequency=(("case", "mode"), beta, "rad s-1"))
    (axes,) = outcomes(root).axes
    assert axes.get_ylabel() == "Frequency of mode 1 (Hz)" and axes.get_xscale() == "log"
    assert [y for _, y in next(iter(lines(axes).values()))] == pytest.approx([10.0, 11.0, 12.0])
    with pytest.raises(NothingToDraw, match="differs from case to case"):
        outcomes(root.rename(support_rotational_stiffness="rotation_angular_velocity"))


def test_a_case_without_a_number_is_counted_and_leaves_a_gap():
    ds = struck()
    fig = outcomes(ds.where(ds["case"] != 1))
    assert any("up to 1 without numbers" in text.get_text() for text in fig.texts)
    assert np.isnan([line[1] for line in lines(fig.axes[0]).values()]).any()


def test_a_number_that_no_axis_holds_counts_as_missing():
    force = ("case", [1.0, 1.6e308, 2.0], "N")
    fig = outcomes(swept("impact_mass", [1.0, 2.0, 3.0], "kg", largest_contact_force=force))
    fig.draw_without_rendering()
    assert fig.axes[0].get_ylim()[1] < 10.0 and any("up to 1 without numbers" in text.get_text() for text in fig.texts)


def test_the_restitution_is_named_as_that_of_the_first_contact():
    (axes,) = outcomes(swept("impact_mass", [1.0, 2.0, 3.0], "kg", restitution=("case", [0.3, 0.4, 0.5], "1"))).axes
    assert axes.get_ylabel() == "Restitution of the first contact"


def test_some_outcomes_can_be_drawn_alone():
    (axes,) = outcomes(struck(), only=["largest_stress"]).axes
    assert axes.get_ylabel().startswith("Largest bending stress") and len(lines(axes)) == 2  # the tip has none
    with pytest.raises(NothingToDraw, match="no frequency"):
        outcomes(struck(), only=["restitution"])


def test_two_inputs_or_two_cases_are_no_curve():
    ds = struck()
    with pytest.raises(NothingToDraw, match="vary one input alone"):
        outcomes(ds.assign_coords(impact_mass=("case", [1.0, 2.0, 3.0])))
    with pytest.raises(NothingToDraw, match="three cases"):
        outcomes(ds.isel(case=[0, 1]))


@pytest.mark.parametrize(("stiffness", "scale"), [([1e5, 2e5, 4e5], "log"), ([1e5, 2e5, 3e5], "linear"), ([1.0, 9.0, 100.0], "log")])
def test_an_axis_is_spaced_as_the_values_of_the_sweep(stiffness, scale):
    inputs = {"contact_stiffness": stiffness, "impact_mass": [1.0, 2.0]}
    grid = np.array(np.meshgrid(*inputs.values(), indexing="ij")).reshape(2, -1)
    force = ("case", grid[0] * grid[1], {"units": "N"})
    ds = xr.Dataset({"largest_contact_force": force}).assign_coords(case=np.arange(6))
    ds = ds.assign_coords({name: ("case", values, {"units": "1"}) for name, values in zip(inputs, grid)})
    axes = outcome_map(ds, inputs=list(inputs)).axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == (scale, "linear")
    first, second = stiffness[:2]  # the first cell is as far around its value as to the middle between both
    edge = first * np.sqrt(first / second) if scale == "log" else 1.5 * first - 0.5 * second
    assert axes.get_xlim()[0] == pytest.approx(edge)
    (line,) = outcomes(swept("contact_stiffness", stiffness, largest_contact_force=("case", [1.0, 2.0, 4.0], "N"))).axes
    assert line.get_xscale() == scale
