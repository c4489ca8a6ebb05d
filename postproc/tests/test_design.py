"""Designs have the distributions and the evenness that they promise; rankings find what explains a spread that is known."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy import stats

from beamwave_postproc import NothingToDraw, rankings
from beamwave_postproc.design import (
    check_name,
    latin_hypercube,
    lognormal,
    log_uniform,
    main,
    normal,
    parse_input,
    sobol_sequence,
    uniform,
    whole,
    write_design,
)
from beamwave_postproc.parts.main_effects import first_order_indices
from beamwave_postproc.terminal import Refusal

INPUTS = {
    "beam%length": uniform(0.9, 1.1),
    "support%stiffness": log_uniform(1e3, 1e9),
    "beam%youngs_modulus": normal(2e11, 1e10),
    "impact%mass": lognormal(0.2, 0.1),
}
SHAPES = {
    "beam%length": stats.uniform(0.9, 0.2),
    "support%stiffness": stats.loguniform(1e3, 1e9),
    "beam%youngs_modulus": stats.norm(2e11, 1e10),
    "impact%mass": stats.lognorm(s=np.sqrt(np.log(1.25)), scale=0.2 / np.sqrt(1.25)),
}
N = 256


@pytest.mark.parametrize("draw", [latin_hypercube, sobol_sequence])
def test_each_input_has_one_value_in_each_part_of_its_distribution(draw):
    table = draw(INPUTS, N)
    assert list(table) == list(INPUTS)
    for name, shape in SHAPES.items():
        np.testing.assert_array_equal(np.sort((N * shape.cdf(table[name])).astype(int)), np.arange(N))


@pytest.mark.parametrize("draw", [latin_hypercube, sobol_sequence])
def test_inputs_are_independent_and_a_seed_makes_another_design(draw):
    table = draw(INPUTS, N)
    between = stats.spearmanr(table).statistic - np.eye(len(INPUTS))
    assert np.abs(between).max() < 4.0 / np.sqrt(N)  # four standard deviations of independent ranks
    pd.testing.assert_frame_equal(table, draw(INPUTS, N))
    assert not table.equals(draw(INPUTS, N, seed=1))


def test_a_lognormal_number_has_the_mean_and_deviation_that_are_given():
    values = sobol_sequence({"impact%mass": lognormal(0.2, 0.1)}, 2**16)["impact%mass"]
    assert values.mean() == pytest.approx(0.2, rel=1e-3)  # an even sequence is right to about 1/N
    assert values.std() == pytest.approx(0.1, rel=1e-2)


def test_whole_numbers_are_equally_often_both_ends_among_them():
    values = latin_hypercube({"modes%before": whole(3, 6)}, 100)["modes%before"]
    assert values.dtype.kind == "i"
    np.testing.assert_array_equal(np.unique(values, return_counts=True), [[3, 4, 5, 6], [25] * 4])


def test_a_table_reads_back_to_the_bit(tmp_path):
    table = latin_hypercube(INPUTS, 20)
    write_design(table, tmp_path / "a.csv", ["# about"])
    lines = [line.split(",") for line in (tmp_path / "a.csv").read_text().splitlines()[1:]]
    assert lines[0] == list(table)
    np.testing.assert_array_equal(np.array(lines[1:], dtype=float), table.to_numpy())


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"beam%length": [1.0, np.nan]}, "row 2: beam%length: 'nan' is not a finite number"),
        ({"beam%length": [1.0, np.inf]}, "row 2: beam%length: 'inf' is not a finite number"),
        ({"beam%length": [None, 1.0]}, "row 1: beam%length: 'nan' is not a finite number"),
        ({"beam%length": ["long"]}, "row 1: beam%length: 'long' is not a finite number"),
        ({"beam%length": [True]}, "row 1: beam%length: 'True' is not a finite number"),
        ({"beam%length": []}, "holds 0 rows of 1 names"),
        ({}, "holds 0 rows of 0 names"),
        ({"x": [1.0]}, "'x' names no input; accepted: 'group%name'"),
        ({"": [0], "beam%length": [1.0]}, "'' names no input"),
        ({"beam%length": [1.0], "Beam%Length": [2.0]}, "'beam%length' has two columns"),
    ],
)
def test_a_table_that_no_scene_can_take_is_not_written(tmp_path, table, said):
    with pytest.raises(Refusal, match=re.escape(said)):
        write_design(pd.DataFrame(table), tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


def test_a_path_may_be_a_text_and_whole_numbers_stay_whole(tmp_path):
    table = pd.DataFrame({"modes%before": [3, 4], "body(2)%mass": [np.float32(0.5), 1], "beam%length(1)": ["0.1", "2"]}, index=["a", "b"])
    write_design(table, str(tmp_path / "a.csv"))
    assert (tmp_path / "a.csv").read_text() == "modes%before,body(2)%mass,beam%length(1)\n3,0.5,0.1\n4,1.0,2.0\n"


@pytest.mark.parametrize(
    ("name", "said"),
    [("beam%lenth", "'beam%lenth' is not a known name (did you mean length?); accepted: length density"), ("beem%length", "accepted: &scene &beam")],
)
def test_a_name_that_the_program_does_not_know_is_refused(tmp_path, capsys, beamwave, name, said):
    check_name("beam%length(2)")
    check_name("frequency_response%position")
    with pytest.raises(Refusal, match=re.escape(said)):
        check_name(name)
    assert main([str(tmp_path / "a.csv"), f"{name}=uniform,1,2"]) == 2
    assert said in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_without_the_program_names_are_not_checked(monkeypatch):
    monkeypatch.setattr("beamwave_postproc.design.find_program", lambda: (_ for _ in ()).throw(FileNotFoundError()))
    check_name("beam%lenth")


def test_the_command_writes_what_its_words_say(tmp_path, capsys):
    path = tmp_path / "a.csv"
    words = [str(path), "beam%length=uniform,0.9,1.1", "modes%before=whole,3,6", "--rows", "64"]
    assert main(words) == 0
    assert path.read_text().splitlines()[:4] == [
        "# made by beamwave-design: Latin hypercube of 64 rows, seed 0",
        "# beam%length=uniform,0.9,1.1",
        "# modes%before=whole,3,6",
        "beam%length,modes%before",
    ]
    assert main(words) == 3 and "--overwrite" in capsys.readouterr().err
    before = path.read_text()
    assert main([*words, "--overwrite"]) == 0 and path.read_text() == before
    assert main([*words, "--overwrite", "--sobol"]) == 0 and path.read_text() != before


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("words", ["whole,-2147483647,2147483647", "normal,1e300,1e300", "lognormal,1,1e9", "log,5e-324,1e-20"])
def test_large_numbers_within_bounds_are_finite(words):
    values = latin_hypercube(dict([parse_input(f"a%a={words}")]), 64)["a%a"].to_numpy(float)
    assert np.isfinite(values).all() and (np.diff(np.sort(values)) >= 0.0).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("length=uniform,0,1", "group%name"),
        ("beam%length=even,0,1", "accepted: uniform, log"),
        ("beam%length=uniform,1", "two numbers"),
        ("beam%length=uniform,1,x", "two numbers"),
        ("beam%length=uniform,1,nan", "two numbers"),
        ("beam%length=uniform,2,1", "lower end first"),
        ("beam%length=log,0,1", "0 < low"),
        ("beam%length=normal,1,0", "above 0"),
        ("modes%before=whole,1,2.5", "whole numbers"),
        ("modes%before=whole,1,1e30", "at most ±2147483647"),
        ("beam%length=uniform,-1e308,1e308", "below 1.8e+308"),
        ("beam%length=log,1e-300,1e300", "below 1.8e+308"),
        ("beam%length=normal,0,1e308", "below 1.8e+308"),
        ("beam%length=lognormal,1,1e300", "below 1.8e+308"),
        ("beam%length=lognormal,1e-320,1", "below 1.8e+308"),
    ],
)
def test_wrong_words_are_refused_with_what_would_be_accepted(tmp_path, capsys, words, said):
    with pytest.raises(Refusal):
        parse_input(words)
    assert main([str(tmp_path / "a.csv"), words]) == 2
    assert said in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_a_sobol_sequence_needs_a_power_of_two():
    with pytest.raises(Refusal, match="64 or 128"):
        sobol_sequence(INPUTS, 100)


def cases(inputs, values):
    """A result of so many cases whose inputs and largest displacement these are."""
    ds = xr.Dataset({"largest_displacement": ("case", values, {"units": "m", "long_name": "largest displacement"})})
    coordinates = {name: ("case", given) for name, given in inputs.items()}
    return ds.assign_coords({**coordinates, "case": np.arange(1, len(values) + 1)})


def ishigami(count):
    """Ishigami's function of three independent inputs, whose first-order indices are known."""
    x = np.pi * (2.0 * stats.qmc.LatinHypercube(d=3, seed=1).random(count).T - 1.0)
    return x, np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])


def test_first_order_indices_are_those_of_ishigami():
    x, y = ishigami(4096)
    # the scatter of such a table is 0.008, that of sin² x₂ over its mean included
    np.testing.assert_allclose(first_order_indices(x, y).first_order, [0.3139, 0.4424, 0.0], atol=0.03)


def randomly(inputs, rows, *, seed):
    """A table of independent rows."""
    dice = np.random.default_rng(seed)
    return pd.DataFrame({name: one.inverse(dice.random(rows)) for name, one in inputs.items()})


PRODUCT = {
    "beam%length": lognormal(1.0, 0.05),
    "beam%youngs_modulus": lognormal(2e11, 3e10),
    "beam%density": uniform(7e3, 9e3),
    "modes%before": whole(3, 7),
}


def shares_of_product():
    """The first-order indices of √(E/ρ)/l²: of a product of independent factors the relative variance of each over that of
    all, Π(1 + cᵢ²) − 1."""
    mean, square = 2.0 * (np.sqrt(9e3) - np.sqrt(7e3)) / 2e3, np.log(9.0 / 7.0) / 2e3  # of 1/√ρ
    relative = np.array([(1.0 + 0.05**2) ** 4, (1.0 + 0.15**2) ** 0.25, square / mean**2, 1.0]) - 1.0
    return relative / (np.prod(1.0 + relative) - 1.0)


@pytest.mark.parametrize(("draw", "scatter_of_length"), [(randomly, 0.023), (latin_hypercube, 0.005), (sobol_sequence, 0.002)])
def test_indices_are_without_bias_however_the_table_was_drawn(draw, scatter_of_length):
    found, chance = [], []
    for seed in range(12):
        table = draw(PRODUCT, 512, seed=seed)
        length, modulus, density, _ = inputs = table.to_numpy(float).T
        indices = first_order_indices(inputs, np.sqrt(modulus / density) / length**2)
        found.append(indices.first_order)
        chance.append(indices.by_chance)
    found, chance = np.array(found), np.array(chance)
    scatter = found.std(axis=0, ddof=1) / np.sqrt(12)
    # four standard errors of the mean, and 0.002 for what twelve terms leave of a main effect
    assert (np.abs(found.mean(axis=0) - shares_of_product()) < 4.0 * scatter + 0.002).all()
    assert found[:, 0].std(ddof=1) < 1.7 * scatter_of_length  # as the README says; of twelve tables, once in a thousand more
    assert (found > chance)[:, :3].all()
    assert (found > chance)[:, 3].sum() <= 4  # by chance 5 % of 12: more than 4 once in 5000


@pytest.mark.parametrize("draw", [randomly, latin_hypercube])
def test_an_input_that_acts_with_others_alone_is_not_taken_for_one_that_acts_by_itself(draw):
    """Interactions that grow towards the ends, x³ times a sign, scatter more there than chance does on the average."""
    beyond = 0
    for seed in range(40):
        table = draw({"a%a": uniform(-1, 1), "b%b": uniform(-1, 1), "c%c": uniform(-1, 1)}, 512, seed=seed)
        x = table.to_numpy().T
        indices = first_order_indices(x, x[0] + x[1] ** 3 * np.sign(x[2]))
        beyond += indices.first_order[1] > indices.by_chance[1]
    assert beyond <= 8  # of 40 draws at 5 %: more than 8 once in 4000


def test_indices_of_values_whose_squares_overflow_are_those_of_smaller_ones():
    x, y = ishigami(64)
    np.testing.assert_array_equal(*(first_order_indices(x, y * scale).first_order for scale in (1.0, 2.0**700)))


def test_inputs_that_cannot_be_told_apart_or_are_too_many_have_no_index():
    dice = np.random.default_rng(1)
    x = dice.normal(size=(3, 200))
    for inputs in (np.array([x[0], x[0] ** 2]), dice.normal(size=(51, 200))):
        assert np.isnan(first_order_indices(inputs, x[1]).first_order).all()
    assert np.isfinite(first_order_indices(dice.normal(size=(50, 200)), x[1]).first_order).all()
    assert list(first_order_indices(np.ones((1, 200)), x[1]).first_order) == [0.0]  # the same in all cases that came to a number


def test_the_ranking_orders_inputs_by_what_they_explain():
    x, y = ishigami(1024)
    table = rankings(cases({"a": x[0], "b": x[1], "c": x[2]}, y)).set_index("input")
    assert list(table["first_order_index"].sort_values(ascending=False).index) == ["b", "a", "c"]
    assert table.loc["c", "first_order_index"] < 2.0 * table.loc["c", "by_chance"]
    assert table.loc["a", "rank_correlation"] > 0.3 and abs(table.loc["b", "rank_correlation"]) < 0.1


def test_of_a_grid_the_index_is_that_of_the_analysis_of_variance():
    a, b = (grid.ravel() for grid in np.meshgrid(np.arange(8.0), np.arange(8.0), indexing="ij"))
    table = rankings(cases({"a": a, "b": b}, 3.0 * a + b)).set_index("input")
    # of an additive response the shares are those of the variances, and no noise is left
    assert list(table["first_order_index"]) == pytest.approx([0.9, 0.1], rel=1e-12)


def test_a_critical_speed_has_a_rank_only_where_the_beam_rotates():
    x, y = ishigami(64)
    ds = cases({"a": x[0]}, y).assign(quantile_largest_displacement=0.0, quantile_critical_angular_velocity=0.0)
    ds["critical_angular_velocity"] = ("case", 2.0 + x[1])
    assert list(rankings(ds)["outcome"]) == ["Largest displacement"]
    turning = ds.assign(rotation_angular_velocity=10.0)
    assert list(rankings(turning)["outcome"]) == ["Largest displacement", "Critical angular velocity"]


def test_correlated_inputs_have_no_index():
    x, y = ishigami(256)
    table = rankings(cases({"a": x[0], "b": x[0] + 0.1 * x[1]}, y))
    assert table["first_order_index"].isna().all() and table["rank_correlation"].notna().all()


def test_inputs_that_are_correlated_by_chance_have_indices():
    """Of ten independent inputs in 64 rows some two have a rank correlation above 0.3 in half of all tables. The shares of 3a + b are
    9/10 and 1/10 in any: each input of a Latin hypercube has its variance to about 1/64."""
    for seed in range(20):
        table = latin_hypercube({f"a%{letter}": uniform(0, 1) for letter in "abcdefghij"}, 64, seed=seed)
        inputs = {name[2:]: given.to_numpy() for name, given in table.items()}
        found = rankings(cases(inputs, 3.0 * inputs["a"] + inputs["b"])).set_index("input")
        assert list(found.index[found["first_order_index"] > 0.01]) == ["a", "b"]
        assert list(found["first_order_index"][["a", "b"]]) == pytest.approx([0.9, 0.1], abs=0.005)


def test_cases_without_a_number_are_left_out_and_few_are_refused():
    x, y = ishigami(64)
    y[::4] = np.nan
    assert (rankings(cases({"a": x[0]}, y))["cases"] == 48).all()
    with pytest.raises(NothingToDraw):
        rankings(cases({"a": x[0][:20]}, y[:20]))
