"""`beamwave-plot` and `python -m beamwave_postproc.paper`: files in, pictures out, failures said."""

import re
import subprocess
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import synthetic
from PIL import Image

from beamwave_postproc import KINDS, cli, files, open_result, paper
from beamwave_postproc.writing import MARK

PACKAGE = Path(__file__).parents[1]
# Pictures of other files: sweeps, studies, records, bounces, and histories along the whole beam.
ELSEWHERE = {
    "frequency_response",
    "transmission",
    "campbell",
    "sweep_map",
    "ranking",
    "outcomes",
    "outcome_map",
    "impulses",
    "contact_force",
    "record_fit",
    "record_envelopes",
    "record_response",
    "record_spectrum",
    "record_windows",
    "record_repeats",
    "record_shapes",
    "record_dispersion",
    "record_model",
    "identified",
    "acceleration",
    "bending_moment",
    "shear_force",
    "hub_angle",
    "space_time",
    "space_time_moment",
    "wavenumber_spectrum",
    "lines",
    "changes",
    "work_precision",
}
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def modes_only(tmp_path):
    return synthetic.write(tmp_path / "modes.nc", synthetic.scene(impact=None))


@pytest.fixture
def unpainted(monkeypatch):
    """Pictures are made and laid out, and their files hold the first bytes of a PNG only."""

    monkeypatch.setattr("beamwave_postproc.files.write_png", lambda fig, path, *_: path.write_bytes(PNG))


@pytest.fixture
def text_file(tmp_path):
    path = tmp_path / "text.nc"
    path.write_text("not NetCDF")
    return path


def test_the_six_figures_of_the_paper_are_drawn(paper_results, capsys):
    assert paper.main([str(paper_results)]) == 0
    for number in range(2, 8):
        assert (paper_results / f"fig{number}.png").read_bytes().startswith(PNG)
    assert capsys.readouterr().err == ""


def test_the_curves_of_each_figure_are_told_apart_without_colour(paper_results):
    for name, figure in paper.FIGURES.items():
        with open_result(paper_results / f"{name}.nc") as ds:
            handles, labels = figure(ds).axes[0].get_legend_handles_labels()
        assert len(set(labels)) == len(labels) == ds.sizes["case"], name
        assert len({handle.get_marker() for handle in handles}) == len(labels), name


def test_a_missing_figure_is_said_and_the_others_are_drawn(tmp_path, paper_results, capsys, unpainted):
    (tmp_path / "fig2.nc").symlink_to(paper_results / "fig2.nc")
    assert paper.main([str(tmp_path)]) == 3
    assert (tmp_path / "fig2.png").exists()
    assert f"{tmp_path / 'fig3.nc'}: no such file" in capsys.readouterr().err


def test_a_file_is_drawn_beside_itself(modes_only, capsys):
    assert cli.main([str(modes_only)]) == 0
    written = sorted(path.name for path in modes_only.parent.glob("*.png"))
    assert written == ["modes_dispersion.png", "modes_group_velocity.png", "modes_phase_velocity.png"]
    assert len(capsys.readouterr().out.splitlines()) == 3


def test_a_full_result_gives_every_picture_of_one_case(full_result, tmp_path, unpainted):
    assert cli.main([str(full_result), "--output", str(tmp_path / "new/pictures")]) == 0
    written = {path.name for path in (tmp_path / "new/pictures").glob("*.png")}
    assert written == {f"struck_{kind}.png" for kind in KINDS if kind not in ELSEWHERE}


def test_bad_files_are_named_and_good_ones_drawn(modes_only, text_file, tmp_path, capsys, unpainted):
    with netCDF4.Dataset(tmp_path / "other.nc", "w") as file:
        file.source = "another program"
    with netCDF4.Dataset(tmp_path / "later.nc", "w") as file:
        file.source = "beamwave 9"
        file.format_version = 3
    with netCDF4.Dataset(tmp_path / "empty.nc", "w") as file:
        file.source = "beamwave"
        file.format_version = 1
    bad = [text_file, *(tmp_path / f"{name}.nc" for name in ("other", "later", "empty", "absent"))]
    assert cli.main([str(path) for path in (*bad, modes_only)]) == 3
    lines = capsys.readouterr().err.splitlines()
    reasons = ("not readable as NetCDF", "not a beamwave result", "this package reads 1 to 2", "nothing in it", "no such")
    for line, path, reason in zip(lines, bad, reasons):
        assert line.startswith(f"{path}: ") and reason in line
    assert len(lines) == len(bad)
    assert (tmp_path / "modes_dispersion.png").exists()


def test_two_files_of_one_name_into_one_directory_are_refused(modes_only, tmp_path, capsys, unpainted):
    (tmp_path / "second").mkdir()
    twin = tmp_path / "second" / modes_only.name
    twin.symlink_to(modes_only)
    assert cli.main([str(modes_only), str(twin), "--output", str(tmp_path / "out")]) == 2
    assert "modes" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert cli.main([str(modes_only), str(twin)]) == 0


def test_an_output_that_cannot_be_a_directory_is_said(modes_only, text_file, capsys):
    assert cli.main([str(modes_only), "--output", str(text_file / "pictures")]) == 3
    assert f"{text_file} is no directory; accepted: a directory" in capsys.readouterr().err


def test_a_full_disk_leaves_no_picture(modes_only, monkeypatch, capsys):
    def fail(fig, path, *_):
        path.write_bytes(PNG)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("beamwave_postproc.files.write_png", fail)
    assert cli.main([str(modes_only)]) == 3
    assert "No space left" in capsys.readouterr().err
    assert not list(modes_only.parent.glob("*.png"))


def test_a_command_line_without_files_is_refused():
    with pytest.raises(SystemExit) as stopped:
        cli.main([])
    assert stopped.value.code == 2


def test_no_display_is_asked_for(modes_only):
    script = f"from beamwave_postproc.cli import main; main([{str(modes_only)!r}]); import sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], cwd=PACKAGE, capture_output=True, text=True, check=True)
    assert "matplotlib.pyplot" not in done.stdout.split()


def test_a_directory_stands_for_the_results_in_it(tmp_path, unpainted, capsys):
    (tmp_path / "results/old.partial").mkdir(parents=True)
    (tmp_path / "empty").mkdir()
    settings = synthetic.scene(impact=None, modes={"after": 2})
    for name in ("b", "a"):
        synthetic.write(tmp_path / f"results/{name}.nc", settings)
    assert cli.main([str(tmp_path / "results"), "--output", str(tmp_path / "out")]) == 0
    assert {path.name.split("_")[0] for path in (tmp_path / "out").iterdir()} == {"a", "b"}
    capsys.readouterr()
    assert cli.main([str(tmp_path / "empty"), str(tmp_path / "results")]) == 3
    assert capsys.readouterr().err == f"{tmp_path / 'empty'}: a directory without a result (*.nc)\n"
    assert (tmp_path / "results/a_dispersion.png").exists()


def test_two_results_are_laid_over_each_other(tmp_path, unpainted, capsys):
    settings = synthetic.scene(impact=None, modes={"after": 2})
    first, second = (synthetic.write(tmp_path / f"{name}.nc", settings) for name in ("a", "b"))
    assert cli.main(["--compare", str(first), str(second)]) == 0
    assert [path.name for path in tmp_path.glob("*.png")] == ["a_and_b_frequencies.png"]
    capsys.readouterr()
    for words in ([str(first)], [str(first), str(second), str(first)], [str(first), str(second), "--animate"]):
        assert cli.main(["--compare", *words]) == 2
        assert "--compare" in capsys.readouterr().err
    assert cli.main(["--compare", str(first), str(tmp_path / "absent.nc")]) == 3
    assert "absent.nc: no such file" in capsys.readouterr().err


def test_only_the_pictures_that_are_named_are_drawn(full_result, tmp_path, capfd):
    words = [str(full_result), "--output", str(tmp_path)]
    assert cli.main([*words, "--only", "dispersion,velocity_jump", "--only", "mode_shapes"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        f"struck_{kind}.png" for kind in ("dispersion", "velocity_jump", "mode_shapes")
    }
    assert cli.main([*words, "--only", "dispersion", "--only", "disprsion"]) == 2
    told = capfd.readouterr().err
    assert "disprsion: no such picture" in told and "can give dispersion, phase_velocity" in told and "campbell" not in told
    assert cli.main([*words, "--only", "campbell"]) == 3
    assert "it can give dispersion" in capfd.readouterr().err


@pytest.mark.parametrize(("suffix", "start"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_pictures_have_the_format_that_is_asked_for_and_are_replaced_as_its_own(full_result, tmp_path, suffix, start):
    words = [str(full_result), "--output", str(tmp_path), "--only", "displacement", "--format", suffix]
    path = tmp_path / f"struck_displacement.{suffix}"
    for _ in range(2):
        assert cli.main(words) == 0 and path.read_bytes().startswith(start)
    path.write_bytes(b"mine")
    assert cli.main(words) == 3 and path.read_bytes() == b"mine"


@pytest.mark.parametrize(("words", "inches"), [("150x120", (5.906, 4.724)), ("150x120mm", (5.906, 4.724)), ("6x4.5in", (6.0, 4.5))])
def test_a_picture_has_the_size_that_is_asked_for_head_and_all(full_result, tmp_path, words, inches):
    assert cli.main([str(full_result), "--output", str(tmp_path), "--only", "velocity", "--size", words]) == 0
    with Image.open(tmp_path / "struck_velocity.png") as image:
        np.testing.assert_allclose(image.size, files.DPI * np.array(inches), atol=1.0)
        assert "beam l" in image.text["Description"] and image.text["Software"] == MARK


@pytest.mark.parametrize("words", ["150", "150x", "x", "1x1in", "0x100", "100x100cm"])
def test_a_size_that_is_none_is_refused(full_result, words):
    with pytest.raises(SystemExit) as stop:
        cli.main([str(full_result), "--size", words])
    assert stop.value.code == 2


@pytest.mark.parametrize("size", ["90x40", "45x120"])
def test_a_size_without_room_for_the_words_is_refused_and_the_one_that_is_named_suffices(full_result, tmp_path, capfd, size):
    words = [str(full_result), "--output", str(tmp_path), "--only", "measured_wavenumber", "--size"]
    assert cli.main([*words, size]) == 3
    told = re.search(r"the words of a picture have no room in this --size; (\d+x\d+) mm suffices", capfd.readouterr().err)
    assert told and cli.main([*words, told[1]]) == 0
    assert cli.main([*words, size, "--page"]) == 3 and "no room in this --size" in capfd.readouterr().err


@pytest.mark.parametrize("output", [False, True])
def test_results_that_would_write_the_same_picture_are_refused(tmp_path, capfd, output):
    paths = [synthetic.write(tmp_path / name, synthetic.scene()) for name in ("q.nc", "q.nc4")]
    words = ["--output", str(tmp_path)] if output else []
    assert cli.main([*map(str, paths), "--only", "dispersion", *words]) == 2
    assert "several files would write the same: q" in capfd.readouterr().err and not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize("name", ["", ",,"])
def test_a_choice_of_no_picture_is_refused(modes_only, name):
    assert cli.main([str(modes_only), "--only", name]) == 2
    assert not list(modes_only.parent.glob("*.png"))


def test_a_size_without_memory_is_blamed_and_not_the_file(modes_only, monkeypatch, capfd):
    def refused(*_):
        raise MemoryError

    monkeypatch.setattr("beamwave_postproc.files.write_png", refused)
    assert cli.main([str(modes_only), "--only", "dispersion", "--size", "1500x1500"]) == 3
    assert "dispersion: a picture of this --size takes more memory than is allowed" in capfd.readouterr().err


def test_a_letter_that_the_font_lacks_is_said_once(tmp_path, capfd):
    path = synthetic.write(tmp_path / "a.nc", synthetic.scene(impact=None), title="\u6881")
    assert cli.main([str(path)]) == 0
    assert capfd.readouterr().err.count("26753") == 1
