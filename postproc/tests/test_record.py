"""`beamwave-record`: histories come through as they are, from files that the tests write."""

import subprocess

import numpy as np
import pytest
import scipy.io
import scipy.io.wavfile
import xarray as xr

from beamwave_postproc.record import NotARecord, Wanted, cli, read_channels
from beamwave_postproc.run import _scene_file

RATE, SAMPLES = 2048.0, 300
TIMES = np.arange(SAMPLES) / RATE
HISTORIES = np.column_stack([np.cos(300 * TIMES) * np.exp(-5 * TIMES), 0.25 * np.sin(700 * TIMES)])


def converted(path, *words):
    assert cli.main([str(path), *words]) == 0
    return xr.load_dataset(path.with_suffix(".nc"))


def assert_histories(ds, names, tolerance=0.0):
    assert [name for name in ds.data_vars] == names
    assert np.abs(ds["time"] - TIMES).max() <= 1e-12
    for name, history in zip(names, HISTORIES.T):
        assert np.abs(ds[name] - history).max() <= tolerance


def write_uff(path, binary):
    pyuff = pytest.importorskip("pyuff")
    for number, (history, kind, unit) in enumerate(zip(HISTORIES.T, (12, 3), ("m/s^2", "strain")), 1):
        one = pyuff.prepare_58(
            binary=int(binary), func_type=1, rsp_node=number, rsp_dir=3, ref_dir=3, ref_node=1, data=history, x=TIMES,
            id1=f"sensor {number}", rsp_ent_name="BEAM", abscissa_spacing=1, abscissa_inc=1 / RATE, abscissa_min=0.0,
            abscissa_spec_data_type=17, ordinate_spec_data_type=kind, ordinate_axis_units_lab=unit,
            orddenom_spec_data_type=0, ord_data_type=4,
        )  # fmt: skip
        pyuff.UFF(str(path)).write_sets(one, mode="add")


@pytest.mark.parametrize("binary", [False, True])
def test_universal_files_keep_names_units_and_quantities(tmp_path, binary):
    path = tmp_path / "impact.uff"
    write_uff(path, binary)
    ds = converted(path)
    assert_histories(ds, ["BEAM_1+z", "BEAM_2+z"], 0.0 if binary else 1e-11)
    assert [ds[name].attrs["quantity"] for name in ds.data_vars] == ["acceleration", "strain"]
    assert ds["BEAM_1+z"].attrs["units"] == "m/s^2"
    assert "sensor 2" in ds["BEAM_2+z"].attrs["long_name"]


def test_a_matlab_file_of_version_5_with_structures(tmp_path):
    path = tmp_path / "five.mat"
    scipy.io.savemat(path, {"run1": {"t": TIMES, "acc": HISTORIES}, "note": "by hand", "gain": 3.0})
    assert_histories(converted(path), ["run1.acc_1", "run1.acc_2"])


def test_a_matlab_file_whose_number_fs_tells_the_rate(tmp_path):
    path = tmp_path / "rate.mat"
    scipy.io.savemat(path, {"Fs": RATE, "a": HISTORIES[:, 0], "b": HISTORIES[:, 1], "other": np.zeros(7)})
    assert_histories(converted(path), ["a", "b"])


def test_a_matlab_file_of_version_7_3(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["time"] = TIMES[np.newaxis]
        file["y"] = HISTORIES.T  # as MATLAB stores its columns
        file["text"] = np.array([[65, 66]], dtype="u2")
        file["text"].attrs["MATLAB_class"] = np.bytes_("char")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(512))
    assert_histories(converted(path), ["y_1", "y_2"])


@pytest.mark.parametrize("turned", [False, True])
def test_an_array_of_numpy_along_its_longer_axis(tmp_path, turned):
    path = tmp_path / "acc.npy"
    np.save(path, HISTORIES.T if turned else HISTORIES)
    assert cli.main([str(path)]) == 3  # nothing tells the times
    words = ["--sample-rate", "2048", "--unit", "g", "--quantity", "acceleration", "--points", "0.5", "1"]
    ds = converted(path, *words)
    assert_histories(ds, ["acc_1", "acc_2"])
    assert ds["acc_2"].attrs["position"] == 1.0
    assert ds["acc_1"].attrs["units"] == "g"


def test_an_archive_of_numpy_holds_its_time_and_no_unit(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, t=TIMES, acc=HISTORIES, name="by hand")
    ds = converted(path)
    assert_histories(ds, ["acc_1", "acc_2"])
    assert "units" not in ds["acc_1"].attrs


def test_an_array_of_three_dimensions_is_refused_with_its_shape(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((2, 30, 3)))
    for wanted in (Wanted(), Wanted(time="1"), Wanted(variables=["a"])):
        with pytest.raises(NotARecord, match=r"a has 3 dimensions, \(2, 30, 3\); accepted: two, samples and sensors"):
            read_channels(tmp_path / "a.npy", wanted)


def test_single_precision_stays_single(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, HISTORIES.astype(np.float32))
    assert converted(path, "--sample-rate", "2048")["a_1"].dtype == np.float32


@pytest.mark.parametrize(("kind", "scale"), [("int16", 32768), ("int32", 2**31), ("float32", 1.0)])
def test_a_sound_file_is_part_of_its_full_scale(tmp_path, kind, scale):
    path = tmp_path / "a.wav"
    data = HISTORIES * min(scale, 2**31 - 1) if kind != "float32" else HISTORIES
    scipy.io.wavfile.write(path, int(RATE), np.clip(data, -scale, scale - 1 if scale > 1 else 1).astype(kind))
    assert_histories(converted(path), ["channel_1", "channel_2"], 2.0 / scale if scale > 1 else 1e-7)


def test_histories_of_two_rates_become_two_files(tmp_path):
    path = tmp_path / "two.uff"
    write_uff(path, True)
    pyuff = pytest.importorskip("pyuff")
    slow = pyuff.prepare_58(
        binary=1, func_type=1, rsp_node=9, rsp_dir=1, ref_dir=1, ref_node=1, data=HISTORIES[::2, 0], x=TIMES[::2],
        abscissa_spacing=1, abscissa_inc=2 / RATE, abscissa_min=0.0, abscissa_spec_data_type=17,
        ordinate_spec_data_type=8, orddenom_spec_data_type=0, ord_data_type=4,
    )  # fmt: skip
    pyuff.UFF(str(path)).write_sets(slow, mode="add")
    assert cli.main([str(path)]) == 0
    assert sorted(file.name for file in tmp_path.glob("*.nc")) == ["two_1.nc", "two_2.nc"]


def test_what_cannot_be_read_is_said_and_nothing_is_left(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("time,a\n0,1\n")
    (tmp_path / "b.mat").write_bytes(b"MATLAB 5.0 and then nothing")
    (tmp_path / "c.npy").write_bytes(b"\x93NUMPY")
    (tmp_path / "d.wav").write_bytes(b"RIFF")
    paths = [tmp_path / name for name in ("a.csv", "b.mat", "c.npy", "d.wav", "absent.uff")]
    for path in paths:
        assert cli.main([str(path), "--sample-rate", "1"]) == 3
        assert str(path) in capsys.readouterr().err
    assert not list(tmp_path.glob("*.nc"))
    assert cli.main([str(paths[0]), "--sample-rate", "0"]) == 2
    assert cli.main([str(paths[0]), "--points", "1.5"]) == 2


def test_a_file_that_is_there_is_kept(tmp_path, capsys):
    path = tmp_path / "a.npy"
    np.save(path, HISTORIES)
    converted(path, "--sample-rate", "2048")
    assert cli.main([str(path), "--sample-rate", "2048"]) == 3
    assert "--overwrite" in capsys.readouterr().err
    assert cli.main([str(path), "--sample-rate", "2048", "--overwrite"]) == 0


def test_names_that_are_not_there_are_listed(tmp_path):
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"t": TIMES, "a": HISTORIES})
    with pytest.raises(NotARecord, match=r"called b.*there: t, a"):
        read_channels(path, Wanted(variables=["b"]))
    with pytest.raises(NotARecord, match="called x"):
        read_channels(path, Wanted(time="x"))


def records(tmp_path):
    """What the files hold that were written, by name."""
    return {file.stem: xr.load_dataset(file) for file in sorted(tmp_path.glob("*.nc"))}


@pytest.mark.parametrize("turned", [False, True])
def test_one_column_of_an_array_may_hold_the_times(tmp_path, turned):
    path = tmp_path / "a.npy"
    table = np.column_stack([HISTORIES[:, 0], 1e3 * TIMES, HISTORIES[:, 1]])
    np.save(path, table.T if turned else table)
    assert_histories(converted(path, "--time", "2", "--time-scale", "1e-3"), ["a_1", "a_3"])
    with pytest.raises(NotARecord, match="has 3 columns, and --time is 4"):
        read_channels(path, Wanted(time="4"))
    with pytest.raises(NotARecord, match=r"number of their column; there: a \("):
        read_channels(path)


@pytest.mark.parametrize("shape", ["cells", "tables"])
def test_each_row_of_cells_is_a_record_of_its_own(tmp_path, shape):
    """Repeats may even have the same times; they do not become sensors of one record."""
    path = tmp_path / "rows.mat"
    cells = np.empty((2, 2) if shape == "cells" else 2, dtype=object)
    for row, history in enumerate(HISTORIES.T):
        if shape == "cells":
            cells[row, 0], cells[row, 1] = TIMES[np.newaxis], history[:, np.newaxis]
        else:
            cells[row] = np.column_stack([TIMES, history])
    scipy.io.savemat(path, {"data": cells})
    assert cli.main([str(path)]) == 3  # nothing tells the times
    assert cli.main([str(path), "--time", "1"]) == 0
    found = records(tmp_path)
    names = ["data{1}.2", "data{2}.2"] if shape == "cells" else ["data.1", "data.2"]
    assert [list(ds.data_vars) for ds in found.values()] == [[name] for name in names]
    for ds, name, history in zip(found.values(), names, HISTORIES.T):
        assert np.abs(ds["time"] - TIMES).max() <= 1e-12
        assert np.array_equal(ds[name], history)


def test_structures_with_times_of_their_own_are_records_of_their_own(tmp_path):
    path = tmp_path / "two.mat"
    steel = {"Out": {"Time": TIMES, "Acc": HISTORIES.T}}
    scipy.io.savemat(path, {"Fe": steel, "Al": {"Out": {"Time": TIMES + 1.0, "Acc": HISTORIES.T}}, "other": TIMES})
    assert cli.main([str(path), "--points", "0.5", "1"]) == 0
    first, second = records(tmp_path).values()
    assert_histories(first, ["Fe.Out.Acc_1", "Fe.Out.Acc_2"])
    assert list(second.data_vars) == ["Al.Out.Acc_1", "Al.Out.Acc_2"]
    assert np.abs(second["time"] - TIMES - 1.0).max() <= 1e-12
    assert second["Al.Out.Acc_2"].attrs["position"] == 1.0
    with pytest.raises(NotARecord, match="none of them is that of other"):
        read_channels(path, Wanted(variables=["other"]))
    assert [one.name for one in read_channels(path, Wanted(variables=["Al.Out.Acc"]))] == list(second.data_vars)


def test_an_array_of_structures_is_a_record_each(tmp_path):
    path = tmp_path / "runs.mat"
    runs = np.array([(TIMES, history) for history in HISTORIES.T], dtype=[("t", object), ("y", object)])
    scipy.io.savemat(path, {"runs": runs})
    found = read_channels(path)
    assert [(one.name, one.record) for one in found] == [("runs{1}.y", "runs{1}"), ("runs{2}.y", "runs{2}")]
    assert all(np.array_equal(one.values, history) for one, history in zip(found, HISTORIES.T))


@pytest.mark.parametrize("kind", ["cell", "struct"])
def test_cells_and_structures_of_version_7_3(tmp_path, kind):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        held = file.create_group("#refs#")
        places = np.empty((2, 2), dtype=h5py.ref_dtype)  # as MATLAB stores its columns: (cells of a row, rows)
        for row, history in enumerate(HISTORIES.T):
            for cell, values in enumerate((TIMES, history)):
                held[f"{row}{cell}"] = values[np.newaxis]
                places[cell, row] = held[f"{row}{cell}"].ref
        if kind == "cell":
            file.create_dataset("data", data=places, dtype=h5py.ref_dtype).attrs["MATLAB_class"] = np.bytes_("cell")
        else:
            for cell, name in enumerate(("t", "y")):
                file.create_dataset(f"data/{name}", data=places[cell : cell + 1].T, dtype=h5py.ref_dtype)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(512))
    found = read_channels(path, Wanted(time="1") if kind == "cell" else None)
    assert [one.name for one in found] == [f"data{{{row}}}.{'2' if kind == 'cell' else 'y'}" for row in (1, 2)]
    for one, history in zip(found, HISTORIES.T):
        assert np.array_equal(one.times, TIMES)
        assert np.array_equal(one.values, history)


def test_units_of_time_exclude_a_rate(tmp_path, capsys):
    for words in (["--time-scale", "0"], ["--time-scale", "1e-3", "--sample-rate", "5"]):
        assert cli.main([str(tmp_path / "a.npy"), *words]) == 2
        assert "--time-scale" in capsys.readouterr().err


def test_files_of_a_mapping_are_looked_for_from_here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    path = _scene_file({"record": {"file": "a.nc", "time": 1}, "spectrum": {}}, tmp_path / "elsewhere", "scene")
    assert f"file = '{tmp_path / 'a.nc'}'" in path.read_text()
    groups = {"Design": {"FILE": "t.csv"}, "force": [{"file": "f.csv"}, {"amplitude": 1}], "identify": {"with": ["b.nml"]}}
    text = _scene_file(groups, tmp_path / "elsewhere", "scene").read_text()
    assert all(str(tmp_path / name) in text for name in ("t.csv", "f.csv", "b.nml"))


def test_the_program_reads_what_was_written(beamwave, tmp_path):
    path = tmp_path / "acc.npy"
    np.save(path, HISTORIES)
    converted(path, "--sample-rate", "2048", "--unit", "m/s^2", "--quantity", "acceleration", "--points", "0.5", "1")
    scene = tmp_path / "a.nml"
    scene.write_text("&record file = 'acc.nc' /\n&spectrum /\n")
    done = subprocess.run([beamwave, "check", str(scene)], capture_output=True, text=True, check=True)
    assert "300 samples, 2 sensors" in done.stdout
    assert "even, 2048 Hz" in done.stdout
    assert "acc_2, acceleration at xi = 1: -0.2" in done.stdout
    assert "warning" not in done.stderr


def test_a_rate_beside_another_one_of_the_file_is_refused(tmp_path):
    path = tmp_path / "a.mat"
    for told in ({"fs": 10.0}, {"dt": 0.1}):
        scipy.io.savemat(path, {**told, "a": HISTORIES[:, 0]})
        assert read_channels(path, Wanted(sample_rate=10.0))[0].times[1] == pytest.approx(0.1)
        with pytest.raises(NotARecord, match=f"has a sampling rate of its own, {next(iter(told))}, of 10 Hz"):
            read_channels(path, Wanted(sample_rate=20.0))
    scipy.io.savemat(path, {"fs": 0.0, "a": HISTORIES[:, 0]})
    assert read_channels(path, Wanted(sample_rate=20.0))[0].times[1] == pytest.approx(0.05)


def test_arrays_are_as_consistent_as_tables(tmp_path):
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"t": TIMES, "a": HISTORIES[:, 0]})
    with pytest.raises(NotARecord, match="has times of its own, t"):
        read_channels(path, Wanted(sample_rate=5.0))
    scipy.io.savemat(path, {"t": TIMES[::-1], "a": HISTORIES[:, 0]})
    with pytest.raises(NotARecord, match="row 2: the time is"):
        read_channels(path)
