"""A design is the cases of its rows: those of a sweep to the bit where the rows are its product; what is wrong with its table is
listed by line; kills, parts and processes share it as they share a sweep."""

import itertools
import re
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import results
import xarray as xr
from drafts import cases_in
from workplace import captured_beam, namelist, wait_until

PROJECT = Path(__file__).parents[2]
RATIOS = [0.1, 0.5, 1.0]
SPEEDS = [0.0, 100.0]
PRODUCT = list(itertools.product(RATIOS, SPEEDS))
NAMES = ["impact%mass_ratio", "rotation%angular_velocity"]
RESPONSE = {"duration": 0.1, "samples": 256}
DESIGN = {"design": {"file": "table.csv"}}


def table(names, rows, separator=",", end="\n"):
    return end.join(separator.join(map(str, row)) for row in [names, *rows]) + end


def design(here, scene, names, rows, name="a"):
    """Write a scene and its table."""
    here.write("table.csv", table(names, rows))
    here.scene(name, {**scene, **DESIGN})


@pytest.fixture(scope="module")
def product(shared):
    """What a sweep over the product of both inputs gives."""
    place = shared("product")
    sweeps = [{"parameter": name, "values": values} for name, values in zip(NAMES, [RATIOS, SPEEDS])]
    return place.simulate("a", captured_beam(response=RESPONSE), *sweeps)


def differing(one, other):
    """What two results differ in beside the scene's text and the checksum of the table, the report, which names it, and quantiles."""
    names = set(results.differences(one, other)) - {"scene", "design_checksum", "report", "given"}
    return {name for name in names if not name.startswith("quantile")}


def test_rows_that_are_the_product_of_a_sweep_give_its_bits(here, product):
    design(here, captured_beam(response=RESPONSE), NAMES, PRODUCT)
    assert differing(here.run("a"), product) == set()


def test_rows_in_another_order_are_those_cases(here, product):
    order = [4, 0, 5]
    design(here, captured_beam(response=RESPONSE), NAMES[::-1], [PRODUCT[i][::-1] for i in order])
    result = here.run("a")
    np.testing.assert_array_equal(result["rotation_angular_velocity"], [PRODUCT[i][1] for i in order])
    for name, (dimensions, values, _) in result.variables.items():
        if dimensions[:1] == ("case",) and name != "case":
            assert values.tobytes() == product[name][order].tobytes(), name


WRITTEN = {
    "byte-order mark and CRLF": ("\ufeff" + table(NAMES, PRODUCT, end="\r\n")),
    "semicolons": table(NAMES, PRODUCT, ";"),
    "tabs": table(NAMES, PRODUCT, "\t"),
    "blanks": table(NAMES, PRODUCT, "   "),
    "quotes": table([f'"{name}"' for name in NAMES], [[f'"{value}"' for value in row] for row in PRODUCT]),
    "capitals and exponents": table([name.upper() for name in NAMES], [[f"{value:.1E}".replace("E", "D") for value in row] for row in PRODUCT]),
    "comments and empty lines": "# drawn by hand\n\n" + table(NAMES, PRODUCT).replace("\n", "\n\n% more\n"),
    "no end of the last line": table(NAMES, PRODUCT).rstrip(),
}


@pytest.mark.parametrize("way", WRITTEN)
def test_a_table_reads_the_same_however_it_is_written(here, product, way):
    (here.directory / "table.csv").write_text(WRITTEN[way], encoding="utf-8", newline="")
    here.scene("a", {**captured_beam(response=RESPONSE), **DESIGN})
    assert differing(here.run("a"), product) == set()


def test_a_design_opens_in_xarray_with_its_inputs_as_coordinates(here):
    design(here, captured_beam(), NAMES, PRODUCT)
    here.run("a")
    for engine in ["netcdf4", "scipy"]:
        with xr.open_dataset(here.directory / "output/a.nc", engine=engine) as result:
            np.testing.assert_array_equal(result.angular_frequency.impact_mass_ratio, [row[0] for row in PRODUCT])
            grid = result.set_index(case=["impact_mass_ratio", "rotation_angular_velocity"]).unstack("case")
            assert grid.sizes["impact_mass_ratio"] == len(RATIOS)


def test_numbered_names_and_integers_vary(here):
    scene = captured_beam(beam={"length": [0.5, 0.5]}, modes={"before": 4, "after": None})
    scene["modes"].pop("after")
    names = ["beam%length(2)", "modes%before"]
    rows = [(0.5, 3), (0.6, 5)]
    design(here, scene, names, rows)
    result = here.run("a")
    np.testing.assert_array_equal(result["beam_length_2"], [0.5, 0.6])
    np.testing.assert_array_equal(result["mode_count"], [3, 5])


ROW = "0.2,50\n"
HEAD = "impact%mass_ratio,rotation%angular_velocity\n"
# what a table holds, and where and how each error of it is told
BAD = {
    "empty": ("", [("", "holds no rows")]),
    "comments": ("# nothing\n", [("", "holds no rows")]),
    "names alone": (HEAD, [("", "holds no rows")]),
    "an unknown name": ("impact%mass_ration\n0.2\n", [(":1", "did you mean mass_ratio")]),
    "an unknown group": ("imapct%mass_ratio\n0.2\n", [(":1", "did you mean &impact")]),
    "no group": ("mass_ratio\n0.2\n", [(":1", "did you mean 'impact%mass_ratio'")]),
    "an absent group": ("shear%poisson_ratio\n0.2\n", [(":1", "absent")]),
    "an axis": ("response%duration\n0.2\n", [(":1", "axis")]),
    "a text": ("rotation%plane\n1\n", [(":1", "not one number")]),
    "one name twice": ("impact%mass_ratio,impact%mass_ratio\n0.1,0.2\n", [(":1", "two columns")]),
    "a column without a name": (",impact%mass_ratio\n0,0.2\n", [(":1", "column 1")]),
    "a comma behind every line": ("impact%mass_ratio,\n0.2,\n0.3,\n", [(":1", "column 2")]),
    "a blank cell": (HEAD + ROW + "0.3,\n", [(":3", "rotation%angular_velocity: the number is missing")]),
    "a text in a cell": (HEAD + "heavy,1\n", [(":2", "impact%mass_ratio: 'heavy' is not a number")]),
    "nan": (HEAD + "nan,1\n", [(":2", "not a finite number")]),
    "an overflow": (HEAD + "0.2,1e999\n", [(":2", "not a finite number")]),
    "a decimal comma": (HEAD.replace(",", ";") + "0,2;50\n", [(":2", "decimal comma")]),
    "decimal commas between commas": (HEAD + "0,2,50\n", [(":2", "has 3 of 2 columns")]),
    "a short row": (HEAD + ROW + "0.2\n", [(":3", "has 1 of 2 columns")]),
    "a negative mass": (HEAD + "-0.2,50\n", [(":2", "impact%mass_ratio: -0.2 is not accepted; accepted: a real, >= 0")]),
    "no whole number": ("modes%before\n2.5\n", [(":2", "modes%before: 2.5 is not accepted")]),
    "a product that overflows": ("impact%mass_ratio\n0.2\n1e300\n", [(":3", "too large")]),
    "several": (HEAD + "x,y\n0.1,\n-1,0\n" + ROW + "nan,1,2\n", [(":2", "'x'"), (":2", "'y'"), (":3", "missing"), (":4", "-1"), (":6", "3 of 2")]),
    "binary": ("PK\x03\x04\x00\x00\x14", [(":1", "binary")]),
}


@pytest.mark.parametrize("what", BAD)
def test_every_error_of_a_table_is_listed_where_it_stands(here, what):
    text, errors = BAD[what]
    here.write("sub/table.csv", text)
    here.write("sub/a.nml", namelist({**captured_beam(beam={"length": 1e10} if "overflows" in what else {}, response=RESPONSE), **DESIGN}))
    ended = here.beamwave("run", "sub/a.nml")
    assert (ended.returncode, ended.stdout) == (2, ""), ended.stderr
    lines = ended.stderr.splitlines()
    assert len(lines) == len(errors), ended.stderr
    for line, (place, words) in zip(lines, errors):
        assert line.startswith(f"sub/table.csv{place}: "), line
        assert words in line and "accepted: " in line, line
    assert here.left(".") == ["sub", "sub/a.nml", "sub/table.csv"]


def test_rows_whose_numbers_do_not_go_together_are_all_listed(here):
    scene = {
        "beam": captured_beam()["beam"],
        "initial": {"force": 1.0},
        "body": {"position": 0.5, "mass": 0.1, "from": 0.01, "until": 1.0},
        "modes": {"before": 4},
        "response": RESPONSE,
    }
    design(here, scene, ["body%until"], [(0.5,), (0.005,), (0.05,), (0.01,)])
    ended = here.beamwave("check", "a.nml", status=2)
    assert [line.split(": ")[:2] for line in ended.stderr.splitlines()] == [["table.csv:3", "body%until"], ["table.csv:5", "body%until"]]


def test_errors_of_the_scene_and_of_its_table_are_listed_together(here):
    here.write("table.csv", HEAD + "x,0\n")
    here.write("a.nml", namelist({**captured_beam(beam={"density": -1.0}), **DESIGN}))
    said = here.beamwave("check", "a.nml").stderr
    assert re.search(r"^a\.nml:\d+: beam%density: ", said, re.MULTILINE)
    assert re.search(r"^table\.csv:2: impact%mass_ratio: ", said, re.MULTILINE)
    assert len(said.splitlines()) == 2


def test_a_table_that_cannot_be_read_is_status_3(here):
    scene = captured_beam(impact={"approach_velocity": 2.0})
    scene["impact"].pop("mass_ratio")
    here.scene("a", {**scene, **DESIGN})
    (here.directory / "d.csv").mkdir()
    here.scene("b", {**captured_beam(), "design": {"file": "d.csv"}})
    for name, words in [("a", "table.csv"), ("b", "is a directory")]:
        ended = here.beamwave("run", f"{name}.nml")
        assert (ended.returncode, ended.stdout) == (3, "")
        assert words in ended.stderr and len(ended.stderr.splitlines()) == 1, ended.stderr


@pytest.mark.parametrize("other", [{"sweep": {"parameter": NAMES[0], "values": [0.1]}}, {"design": {"file": "b.csv"}}])
def test_a_design_is_alone(here, other):
    here.write("table.csv", table(NAMES, PRODUCT))
    here.write("a.nml", namelist({**captured_beam(), **DESIGN}) + namelist(other))
    ended = here.beamwave("check", "a.nml")
    assert ended.returncode == 2 and len(ended.stderr.splitlines()) == 1
    assert "design" in ended.stderr


def test_a_changed_table_is_another_scene(here):
    design(here, captured_beam(), NAMES, PRODUCT)
    here.run("a")
    assert "nothing to do" in here.beamwave("run", "a.nml").stdout
    here.write("table.csv", table(NAMES, [*PRODUCT[:-1], (1.0, 100.5)]))
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == 3 and "--overwrite" in ended.stderr
    assert here.run("a", "--overwrite")["rotation_angular_velocity"][-1] == 100.5


def test_the_resolved_scene_gives_the_same_numbers(here):
    design(here, captured_beam(), NAMES, PRODUCT)
    first = here.run("a")
    here.write("b.nml", first.attributes["scene"])
    assert set(results.differences(here.run("b"), first)) == {"given"}  # which names what the scene itself says


def test_the_report_and_check_name_the_table(here):
    design(here, captured_beam(response=RESPONSE), NAMES, PRODUCT)
    for command in ["check", "run"]:
        said = here.beamwave(command, "a.nml").stdout
        assert "6 cases: the rows of table.csv with impact%mass_ratio (0.1 to 1), rotation%angular_velocity (0 to 100)" in said


def test_of_many_columns_some_are_listed_and_the_others_counted(here):
    pieces = 12
    beam = {"length": [0.1] * pieces, "diameter": 0.037, "density": 7870.0, "youngs_modulus": 2e11}
    design(here, {"beam": beam, "modes": {"before": 2}}, [f"beam%length({i + 1})" for i in range(pieces)], [[0.1] * pieces])
    said = here.beamwave("check", "a.nml").stdout
    assert "1 case: the rows of table.csv" in said
    assert "beam%length(8) (0.1 to 0.1), and 4 more\n" in said


def test_a_study_takes_the_first_row(here):
    design(here, captured_beam(response=RESPONSE), NAMES, PRODUCT)
    here.beamwave("effects", "a.nml", status=0)
    result = here.result("a.effects")
    assert result["impact_mass_ratio"] == 0.1 and "design" not in result.attributes["scene"]


def test_the_example_runs_without_a_warning(here):
    ended = here.beamwave("run", PROJECT / "input/design.nml", "--quiet")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert here.result("design").sizes["case"] == 192


LEVELS = [0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0]


def test_quantiles_are_those_of_numpy_over_the_cases_that_have_the_number(here):
    # the last rows are above the critical speed, where mode 1 has no frequency
    rows = [(0.1 + 0.02 * i, 4.0 * i) for i in range(40)]
    scene = captured_beam(response={**RESPONSE, "bending_moment": True}, modes={"before": 5, "after": 5})
    design(here, scene, NAMES, rows)
    result = here.run("a", "--quiet")
    np.testing.assert_array_equal(result["quantile"], LEVELS)
    summed = [name[len("quantile_") :] for name in result.variables if name.startswith("quantile_") and "cases" not in name]
    assert set(summed) == {
        "angular_frequency",
        "critical_angular_velocity",
        "impulse",
        "largest_displacement",
        "largest_stress",
    }
    for name in summed:
        values = np.where(results.is_fill(result[name]), np.nan, result[name])
        np.testing.assert_array_equal(result[f"quantile_cases_{name}"], np.isfinite(values).sum(axis=0), name)
        # two values are weighed with one rounding each
        np.testing.assert_allclose(result[f"quantile_{name}"], np.nanquantile(values, LEVELS, axis=0), rtol=1e-14, err_msg=name)
    assert 0 < result["quantile_cases_angular_frequency"][0] < 40


def test_a_number_that_no_case_has_has_no_quantile(here):
    design(here, captured_beam(modes={"before": 2, "after": 2}), NAMES, [(1.0, 2000.0), (2.0, 2000.0)])
    result = here.run("a", "--quiet")
    assert results.is_fill(result["quantile_angular_frequency"][:, 0]).all()
    assert result["quantile_cases_angular_frequency"][0] == 0


def test_the_report_has_the_quantiles_in_hertz(here):
    design(here, captured_beam(), NAMES, PRODUCT)
    said = here.beamwave("run", "a.nml").stdout
    median = here.result("a")["quantile_angular_frequency"][3, 0] / (2.0 * np.pi)
    (line,) = [line for line in said.splitlines() if "frequency, mode 1 (Hz)" in line]
    assert float(line.split()[4]) == pytest.approx(median, rel=1e-5)  # six digits


def test_the_report_leaves_out_what_is_0_in_every_case(here):
    scene = captured_beam(response={**RESPONSE, "points": [0.0, 1.0], "bending_moment": True})
    design(here, scene, NAMES, PRODUCT)
    said = here.beamwave("run", "a.nml").stdout.split("Quantiles over")[1]
    assert "largest sample of the displacement at xi = 1 (m)" in said
    assert "largest sample of the bending stress at xi = 0 (Pa)" in said
    assert "displacement at xi = 0" not in said and "stress at xi = 1" not in said  # a clamped root, a free tip


def test_the_report_has_the_numbers_of_a_row_and_its_line_where_columns_are_many(here):
    columns = ["impact%mass_ratio", "beam%density", "beam%length", "beam%diameter", "impact%approach_velocity"]
    rows = [(0.1, 7870, 1, 0.037, 1.5), (0.2, 7850, 1.1, 0.038, 2.5)]
    design(here, captured_beam(), columns, rows)
    said = here.beamwave("run", "a.nml").stdout
    shown = "impact%mass_ratio = 0.2, beam%density = 7850, beam%length = 1.1, beam%diameter = 0.038, ... (line 3)"
    assert shown in said
    design(here, captured_beam(), columns[:4], [row[:4] for row in rows])
    said = here.beamwave("run", "a.nml", "--overwrite").stdout
    assert "beam%length = 1.1, beam%diameter = 0.038\n" in said and "(line" not in said


def test_a_sweep_has_no_quantiles(product):
    assert "quantile" not in product.sizes


CASES = 60
MANY = captured_beam(modes={"before": 30, "after": 30}, response={"duration": 4.0, "samples": 1024})
ROWS = [(0.1 + 0.01 * i, 150.0 - i) for i in range(CASES)]


@pytest.fixture(scope="module")
def whole(shared):
    """What one run of a larger design gives."""
    place = shared("whole")
    design(place, MANY, NAMES, ROWS)
    return place.run("a")


def test_a_killed_design_goes_on_and_a_changed_table_begins_anew(here, whole):
    design(here, MANY, NAMES, ROWS)
    running = here.start("run", "a.nml", "--quiet")
    partial = here.directory / "output/a.partial"
    wait_until(lambda: running.poll() is not None or cases_in(partial))
    running.send_signal(signal.SIGKILL)
    running.communicate()
    assert results.differences(here.run("a"), whole) == []
    here.beamwave("run", "a.nml", "--overwrite", "--max-seconds", "0", status=5)
    here.write("table.csv", table(NAMES, ROWS[::-1]))
    result = here.run("a", "--overwrite")
    np.testing.assert_array_equal(result["displacement"], whole["displacement"][::-1])


def test_a_hundred_thousand_rows_are_read_and_checked_within_seconds(here):
    rows = np.random.default_rng(20261127).uniform([0.1, 0.0], [1.0, 100.0], (100_000, 2)).tolist()
    design(here, captured_beam(), NAMES, rows)
    began = time.perf_counter()
    ended = here.beamwave("check", "a.nml", status=0)
    assert "100000 cases: the rows of table.csv" in ended.stdout
    assert time.perf_counter() - began < 60  # a few here; a build with checks takes ten times as long
