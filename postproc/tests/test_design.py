"""Designs have the distributions and the evenness that they promise; rankings find what explains a spread that is known."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy import stats

from beamwave_postproc import NothingToDraw, rankings
from beamwave_postproc.design import (
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
from beamwave_postproc.parts.outcome import first_order_index
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
    # 0.3139, 0.4424 and 0; of 128 cases in each of 32 parts the scatter is about 0.02, and a width of 1/32 loses 0.005
    for given, exact in zip(x, [0.3139, 0.4424, 0.0]):
        assert first_order_index(given, y) == pytest.approx(exact, abs=0.04)


def test_the_ranking_orders_inputs_by_what_they_explain():
    x, y = ishigami(1024)
    table = rankings(cases({"a": x[0], "b": x[1], "c": x[2]}, y)).set_index("input")
    assert list(table["first_order_index"].sort_values(ascending=False).index) == ["b", "a", "c"]
    assert table.loc["c", "first_order_index"] < 2.0 * table.loc["c", "by_chance"]
    assert table.loc["a", "rank_correlation"] > 0.3 and abs(table.loc["b", "rank_correlation"]) < 0.1


def test_of_a_grid_the_index_is_that_of_the_analysis_of_variance():
    a, b = (grid.ravel() for grid in np.meshgrid(np.arange(8.0), np.arange(8.0), indexing="ij"))
    table = rankings(cases({"a": a, "b": b}, 3.0 * a + b)).set_index("input")
    # of an additive response the shares are those of the variances, less what no freedom is left for: 1/7 of the rest
    assert table.loc["a", "first_order_index"] == pytest.approx(1.0 - 0.1 * (63.0 / 56.0), rel=1e-12)


def test_correlated_inputs_have_no_index():
    x, y = ishigami(256)
    table = rankings(cases({"a": x[0], "b": x[0] + 0.1 * x[1]}, y))
    assert table["first_order_index"].isna().all() and table["rank_correlation"].notna().all()


def test_cases_without_a_number_are_left_out_and_few_are_refused():
    x, y = ishigami(64)
    y[::4] = np.nan
    assert (rankings(cases({"a": x[0]}, y))["cases"] == 48).all()
    with pytest.raises(NothingToDraw):
        rankings(cases({"a": x[0][:20]}, y[:20]))
