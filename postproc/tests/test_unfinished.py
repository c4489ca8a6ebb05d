"""Files that are not whole: cut short, or the draft of a sweep that was stopped."""

import netCDF4
import numpy as np
import pytest
import synthetic

from beamwave_postproc import cli, open_result
from beamwave_postproc.export import cli as export
from beamwave_postproc.parts.describe import brief_of


@pytest.mark.parametrize("command", [cli, export])
def test_a_file_cut_short_is_refused(tmp_path, capfd, command):
    path = synthetic.write(tmp_path / "cut.nc", synthetic.scene())
    whole = path.read_bytes()
    path.write_bytes(whole[:-2000])
    assert command.main([str(path)]) == 3
    assert f"damaged, cut short: {len(whole) - 2000} of {len(whole)} bytes" in capfd.readouterr().err


def test_of_a_draft_the_cases_that_ran_are_shown_and_counted(tmp_path):
    sweep = {"rotation_angular_velocity": [0.0, 1.0, 2.0, 3.0]}
    path = synthetic.write(tmp_path / "draft.nc", synthetic.scene(), sweep)
    with netCDF4.Dataset(path, "a") as file:
        file.createVariable("case_status", "i4", ("case",))[:] = [0, -1, 0, -1]
    with open_result(path) as ds:
        assert np.array_equal(ds["case"], [1, 3])
        assert brief_of(ds)[:2] == ["draft.nc", "2 of 4 cases have run"]
