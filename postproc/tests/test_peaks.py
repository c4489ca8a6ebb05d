"""Tables of the waves that were measured."""

import csv

import numpy as np
import pytest
import synthetic

from beamwave_postproc import NothingToDraw, open_result
from beamwave_postproc.peaks import MEASURED, main, peaks

RESPONSE = {"duration": 1.0, "samples": 2**14}


def test_a_line_holds_what_the_file_holds_of_its_peak(full_result, capsys):
    assert main([str(full_result)]) == 0
    path = full_result.with_name("struck_peaks.csv")
    assert capsys.readouterr().out == f"{path}\n"
    with path.open(newline="") as file:
        lines = list(csv.DictReader(file))
    with open_result(full_result) as ds:
        for name in ["peak", *(name for name in MEASURED if name in ds)]:
            np.testing.assert_array_equal([float(line[name]) for line in lines], ds[name])


def test_peaks_that_are_not_there_have_no_line_and_cases_their_swept_input(tmp_path):
    settings = synthetic.scene(modes={"before": 4, "after": 4}, response=RESPONSE, spectrum={"max_peaks": 6})
    path = synthetic.write(tmp_path / "sweep.nc", settings, {"rotation_angular_velocity": [0.0, 50.0]})
    with open_result(path) as ds:
        found = ds["measured_angular_frequency"]
        table = peaks(ds.assign(measured_angular_frequency=found.where((found.case == 1) | (found.peak < 3))))
    assert table.index.tolist() == [(1, 1), (1, 2), (1, 3), (1, 4), (2, 1), (2, 2)]
    assert table["rotation_angular_velocity"].tolist() == 4 * [0.0] + 2 * [50.0]


def test_a_result_without_a_spectrum_is_said(tmp_path, capsys):
    path = synthetic.write(tmp_path / "modes.nc", synthetic.scene())
    with open_result(path) as ds, pytest.raises(NothingToDraw, match="measured_angular_frequency"):
        peaks(ds)
    assert main([str(path)]) == 3
    assert f"{path}: the result holds no measured_angular_frequency" in capsys.readouterr().err


def test_a_full_disk_leaves_no_table(full_result, monkeypatch, capsys):
    def fail(table, path):
        path.write_text("peak")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pandas.DataFrame.to_csv", fail)
    full_result.with_name("struck_peaks.csv").unlink(missing_ok=True)
    assert main([str(full_result)]) == 3
    assert "No space left" in capsys.readouterr().err
    assert not full_result.with_name("struck_peaks.csv").exists()
