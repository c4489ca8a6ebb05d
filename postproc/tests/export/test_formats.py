"""What `beamwave-export` writes is read by other libraries, and what it cannot write is refused in a sentence."""

import re
import sys

import numpy as np
import pytest
import pyuff
import scipy.io
import xarray as xr

from beamwave_postproc import modal_model, run, state_space
from beamwave_postproc.export.cli import main

pytestmark = pytest.mark.filterwarnings("ignore::beamwave_postproc.ProgramWarning")
BEAM = {"length": 1.2, "diameter": 0.03, "density": 7800.0, "youngs_modulus": 2.0e11}
SCENE = {
    "beam": BEAM,
    "damping": {"ratio": 0.02},
    "force": {"amplitude": 1.0, "duration": 0.01},
    "response": {"duration": 0.1, "samples": 16, "points": [0.0, 0.25, 1.0]},
    "modes": {"before": 5, "modal_model": True},
}


@pytest.fixture(scope="module")
def results(beamwave, tmp_path_factory):
    """Makes a result of a scene, by its name."""
    directory = tmp_path_factory.mktemp("results")

    def make(name, scene):
        path = directory / f"{name}.nc"
        if not path.exists():
            run(scene, directory, program=beamwave).close()
            (directory / "scene.nc").rename(path)
        return path

    return make


@pytest.fixture
def plain(results):
    return results("plain", {"scene": {"title": "a beam"}, **SCENE})


def test_npz_holds_everything_by_name(plain, tmp_path):
    assert main([str(plain), "--output", str(tmp_path)]) == 0
    with xr.open_dataset(plain) as ds, np.load(tmp_path / "plain.npz") as found:
        model, space = modal_model(ds), state_space(modal_model(ds))
        assert found["title"] == "a beam" and list(found["inputs"]) == space.inputs
        for name, expected in {"A": space.a, "B": space.b, "C": space.c, "D": space.d, "shape": model.shape}.items():
            assert np.array_equal(found[name], expected), name
        assert found["frequency"] == pytest.approx(
            ds.angular_frequency.values / np.sqrt(1 - 0.02**2) / (2 * np.pi), rel=1e-12
        )
        assert found["damping_ratio"] == pytest.approx(0.02, rel=1e-13)


def test_mat_is_read_by_scipy_with_cells_of_names(plain, tmp_path):
    assert main([str(plain), "--format", "mat", "--output", str(tmp_path)]) == 0
    found = scipy.io.loadmat(tmp_path / "plain.mat")
    with xr.open_dataset(plain) as ds:
        space = state_space(modal_model(ds))
    assert [str(cell.item()) for cell in found["outputs"].ravel()] == space.outputs
    assert np.array_equal(found["A"], space.a) and found["modal_mass"].shape == (5, 1)


def test_a_universal_file_has_nodes_and_a_shape_for_each_mode(plain, tmp_path):
    assert main([str(plain), "--format", "unv", "--output", str(tmp_path)]) == 0
    sets = pyuff.UFF(str(tmp_path / "plain.unv")).read_sets()
    assert [one["type"] for one in sets] == [151, 164, 15, *[55] * 5]
    assert sets[2]["x"] == pytest.approx([0.0, 0.3, 1.2])
    with xr.open_dataset(plain) as ds:
        model = modal_model(ds)
    for k, one in enumerate(sets[3:]):
        assert one["analysis_type"] == 2 and one["mode_n"] == k + 1
        assert one["freq"] == pytest.approx(model.angular_frequency[k] / (2 * np.pi), rel=1e-4)
        assert one["modal_m"] == pytest.approx(model.mass[k], rel=1e-4) and one["modal_damp_vis"] == pytest.approx(
            0.02, rel=1e-4
        )
        # six digits each
        assert one["r2"] == pytest.approx(model.shape[k], abs=1e-5) and one["r6"] == pytest.approx(
            model.slope[k], abs=1e-3
        )


def test_without_pyuff_it_is_said_how_to_get_it(plain, tmp_path, monkeypatch, capfd):
    monkeypatch.setitem(sys.modules, "pyuff", None)
    assert main([str(plain), "--format", "unv", "--output", str(tmp_path)]) == 3
    assert "pip install './postproc[records]'" in capfd.readouterr().err  # as the README has it


def test_the_header_of_a_universal_file_has_dates_and_whole_numbers_in_its_columns(plain, tmp_path):
    """Records 4, 5 and 7 of data set 151: (10A1, 10A1, 3I10), (10A1, 10A1) twice."""
    assert main([str(plain), "--format", "unv", "--output", str(tmp_path)]) == 0
    lines = (tmp_path / "plain.unv").read_text().splitlines()
    for line in (lines[5], lines[6], lines[8]):
        assert re.fullmatch(r"\d\d-\w{3}-\d\d", line[:10].strip()) and re.fullmatch(r"\d\d:\d\d:\d\d", line[10:20].strip())
    assert [int(lines[5][at : at + 10]) for at in (20, 30, 40)] == [0, 0, 0]
    assert not any("None" in line or "nan" in line for line in lines)


FREE = {**SCENE, "support": {"stiffness": 0.0, "rotational_stiffness": 0.0}}


def test_rigid_modes_of_a_free_beam_have_frequency_0(results, tmp_path):
    assert main([str(results("free", FREE)), "--format", "unv", "--output", str(tmp_path)]) == 0
    modes = pyuff.UFF(str(tmp_path / "free.unv")).read_sets()[3:]
    assert [one["freq"] for one in modes[:2]] == [0.0, 0.0] and modes[2]["freq"] > 0.0
    assert [one["modal_damp_vis"] for one in modes] == pytest.approx([0.0, 0.0, 0.02, 0.02, 0.02], rel=1e-4)
    distance = np.array([0.0, 0.3, 1.2])
    for one in modes[:2]:  # straight, turned by its slope; six digits of numbers up to 3
        assert one["r2"] == pytest.approx(one["r2"][0] + one["r6"][0] * distance, abs=1e-5)
        assert one["r6"] == pytest.approx(one["r6"][0], abs=1e-5)


def test_a_universal_file_and_arrays_have_the_turn_of_a_hub(results, tmp_path):
    path = str(results("hub", {**SCENE, "hub": {"rotary_inertia": 0.3, "radius": 0.1}}))
    assert main([path, "--format", "unv", "--output", str(tmp_path)]) == 0 == main([path, "--output", str(tmp_path)])
    modes = pyuff.UFF(str(tmp_path / "hub.unv")).read_sets()[3:]
    with xr.open_dataset(path) as ds, np.load(tmp_path / "hub.npz") as found:
        turn, shape = ds.hub_turn.values, ds.shape_at_points.values
        assert np.array_equal(found["hub_turn"], turn) and found["hub_radius"] == 0.1
        assert found["residual_hub_turn"].shape == (3,) and list(found["outputs"])[-1] == "hub_angle"
    for k, one in enumerate(modes):  # the first is the rigid turn
        assert one["r2"] == pytest.approx(shape[k] + turn[k] * np.array([0.1, 0.4, 1.3]), abs=1e-5 * (1 + abs(turn[k])))
    assert modes[0]["freq"] == 0.0 and modes[0]["r6"] == pytest.approx(turn[0], rel=1e-5)


SWEPT = {**SCENE, "sweep": {"parameter": "damping%ratio", "values": [0.0, 0.1]}}
REFUSED = {
    "a result without a model": ({**SCENE, "modes": {"before": 5}}, [], "modal_model = .true."),
    "a growing mode": (
        {**SCENE, "rotation": {"angular_velocity": 200.0}},
        ["--format", "unv"],
        "mode 1 grows or is overdamped",
    ),
    "overdamped modes": (
        {**SCENE, "damping": {"ratio": 2.0}},
        ["--format", "unv"],
        "modes 1, 2, 3, 4, 5 grow or are overdamped",
    ),
    "rigid modes that a damping holds back": (
        {**FREE, "damping": {"mass_proportional": 2.0, "stiffness_proportional": 0.0}},
        ["--format", "unv"],
        "modes 1, 2 grow or are overdamped",
    ),
    "a sweep without a case": (SWEPT, [], "has 2 cases; accepted: --case"),
    "a case that is not there": (SWEPT, ["--case", "3"], "2 cases, and no case 3"),
    "a case of a single scene": (SCENE, ["--case", "2"], "has one case, and no case 2"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_exported_is_refused_in_one_line(results, name, tmp_path, capfd):
    scene, words, why = REFUSED[name]
    path = results(name.replace(" ", "_"), scene)
    assert main([str(path), *words, "--output", str(tmp_path)]) == 3
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 1 and why in said[0] and str(path) in said[0]
    assert list(tmp_path.iterdir()) == []


def test_a_growing_mode_is_in_the_arrays(results, tmp_path):
    path = results("a_growing_mode", REFUSED["a growing mode"][0])
    assert main([str(path), "--output", str(tmp_path)]) == 0
    with np.load(tmp_path / "a_growing_mode.npz") as found:
        assert found["modal_stiffness"][0] < 0 and np.isnan(found["frequency"][0]) and np.isfinite(found["A"]).all()


def test_a_case_is_in_the_name_and_nothing_is_replaced_unasked(results, tmp_path, capfd):
    path = results("swept", SWEPT)
    words = [str(path), "--case", "2", "--output", str(tmp_path)]
    assert main(words) == 0
    assert np.load(tmp_path / "swept_case2.npz")["damping_ratio"] == pytest.approx(0.1)
    assert main(words) == 3 and "is there already" in capfd.readouterr().err
    assert main([*words, "--overwrite"]) == 0
