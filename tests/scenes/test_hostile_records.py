"""Records whose content is hostile in one thing each: one line says why, soon and with little memory, and nothing is left."""

import io
import os
import struct
import subprocess
import time
import wave
import zipfile

import h5py
import netCDF4
import numpy as np
import pytest
import pyuff
import scipy.io
from workplace import SECONDS, namelist

N = 200
TIME = np.arange(N) / 1000
RING = np.exp(-TIME / 0.1) * np.cos(300 * TIME)
MOST_MEGABYTES = 4000  # the library takes half a GB a second from a circle of groups


def netcdf(path, change=None, form="NETCDF4", values=RING, dimensions=("time",), **attributes):
    """A good file but for what `change` does to it, or an attribute."""
    with netCDF4.Dataset(path, "w", format=form) as file:
        file.createDimension("time", N)
        file.createDimension("point", 3)
        file.createVariable("time", "f8", ("time",))[:] = TIME
        ring = file.createVariable("acceleration", "f8", dimensions)
        ring[:] = values
        ring.setncatts({"units": "m s-2", **attributes})
        if change:
            change(file)


def unwritten(path, dimensions):
    """A file of few bytes that says that it holds much."""
    with netCDF4.Dataset(path, "w") as file:
        for name, length in dimensions.items():
            file.createDimension(name, length)
        chunks = [min(length, 1000) for length in dimensions.values()]
        file.createVariable("time", "f8", tuple(dimensions)[:1], chunksizes=chunks[:1])
        file.createVariable("a", "f8", tuple(dimensions), chunksizes=chunks)


def changed(path, change, form="NETCDF3_CLASSIC"):
    """A good file whose bytes are changed."""
    netcdf(path, form=form)
    path.write_bytes(change(path.read_bytes()))


def longer(content):
    """A classic file that says that it holds 2²⁷ samples."""
    at = content.index(struct.pack(">4sI", b"time", N))
    return content[: at + 4] + struct.pack(">I", 2**27) + content[at + 8 :]


def circle(path):
    with h5py.File(path, "w") as file:
        group = file.create_group("group")
        group["again"] = group
        file["time"] = TIME


def hdf5(path, **datasets):
    with h5py.File(path, "w") as file:
        for name, values in datasets.items():
            file[name] = values


def compound(path):
    hdf5(path, time=TIME, pairs=np.zeros(N, dtype=[("a", "f8"), ("b", "i4")]))


def csv(path, text, encoding="utf-8"):
    path.write_bytes(text.encode(encoding))


def table(head="time,a", rows=N):
    return head + "\n" + "".join(f"{j / 1000},{ring}\n" for j, ring in enumerate(RING[:rows]))


def lvm(path):
    """A measurement of LabVIEW, whose units stand in its head."""
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\n"
    own = f"Channels\t1\t\nSamples\t{N}\t\nX0\t0.0\t\nDelta_X\t0.001\t\n***End_of_Header***\t\t\nX_Value\ta\tComment\n"
    csv(path, head + own + table("", N)[1:].replace(",", "\t"))


def wav(path):
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, 8000, 0, "NONE", ""))
        file.writeframes((RING * 1000).astype("<i2").tobytes())


def uff(path):
    pyuff.UFF(str(path)).write_sets({"type": 58, "binary": 0, "func_type": 1, "data": RING, "x": TIME, "id1": "x", "rsp_dir": 1,
                                     "rsp_node": 1, "ref_dir": 1, "ref_node": 1, "abscissa_spacing": 1, "ordinate_spec_data_type": 12,
                                     "orddenom_spec_data_type": 0})


def zipped(path):
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("ring.csv", table())


def npy(path):
    content = io.BytesIO()
    np.save(content, RING)
    path.write_bytes(content.getvalue())


HOSTILE = {  # what makes the file, status, what is said of it
    "two factors": (lambda path: netcdf(path, scale_factor=np.array([1.0, 2.0])), 3, "scale_factor is not a single number"),
    "a thousand offsets": (lambda path: netcdf(path, add_offset=np.zeros(1000)), 3, "add_offset is not a single number"),
    "a factor in letters": (lambda path: netcdf(path, scale_factor="2"), 3, "scale_factor is not a single number"),
    "a factor in strings": (lambda path: netcdf(path, scale_factor=["2", "3"]), 3, "scale_factor is not a single number"),
    "a factor that is none": (lambda path: netcdf(path, scale_factor=np.nan), 3, "not a finite number"),
    "many missing values": (lambda path: netcdf(path, missing_value=np.arange(50.0)), 3, "missing_value is not a single number"),
    "numbers too large": (lambda path: netcdf(path, scale_factor=1e307), 3, "numbers that are too large"),
    "2^33 samples": (lambda path: unwritten(path, {"time": 2**33}), 3, "not enough memory"),
    "2^62 samples": (lambda path: unwritten(path, {"time": 2**62}), 3, "not enough memory"),
    "2^40 columns": (lambda path: unwritten(path, {"time": N, "point": 2**40}), 3, "columns and more; accepted"),
    "a million columns": (lambda path: unwritten(path, {"time": N, "point": 10**6 - 1}), 2, "columns of numbers besides the time"),
    "samples that are not there": (lambda path: unwritten(path, {"time": 10**7}), 3, "has 0 samples"),
    "a classic file that says too much": (lambda path: changed(path, longer), 3, "cannot be read: "),
    "a classic file cut off": (lambda path: changed(path, lambda content: content[:-500]), 3, "is cut off: it has"),
    "a head cut off": (lambda path: changed(path, lambda content: content[:90]), 3, "cannot be read: "),
    "HDF5 cut off": (lambda path: changed(path, lambda content: content[:-500], "NETCDF4"), 3, "cannot be read: "),
    "HDF5 of ones": (lambda path: changed(path, lambda content: content[:48] + b"\xff" * 400 + content[448:], "NETCDF4"), 3, "cannot"),
    "a circle of groups": (circle, 3, "cannot be read: "),
    "three dimensions": (lambda path: unwritten(path, {"time": N, "point": 2, "case": 2}), 3, "3 dimensions, as in a sweep"),
    "no samples": (lambda path: hdf5(path, time=np.zeros(0)), 3, "has no samples"),
    "no numbers": (lambda path: hdf5(path, time=np.array([b"a", b"b"])), 3, "no variable along the dimension"),
    "pairs": (compound, 2, "has no column of numbers besides the time"),
    "a line of 10 MB": (lambda path: csv(path, "1," * 5_000_000), 3, "the line is longer than"),
    "200 000 columns": (lambda path: csv(path, ("1," * 200_000 + "1\n") * 20), 2, "record%time: is missing"),
    "quotes without end": (lambda path: csv(path, 'time,"a\n' + '"' * 100_000), 3, "has no rows of numbers"),
    "a gap": (lambda path: csv(path, table() + "1e7,1\n"), 2, "no samples between 0.199 and 10000000 s"),
    "a longer gap": (lambda path: csv(path, table() + "9e10,1\n"), 2, "no samples between 0.199 and 90000000000 s"),
    "two marks": (lambda path: csv(path, table().replace("\n0.1,", '\n"0,1",')), 3, "one decimal mark"),
    "UTF-16": (lambda path: csv(path, table(), "utf-16"), 3, "is text in UTF-16"),
    "NUL": (lambda path: csv(path, table() + "\0"), 3, "beamwave-record"),
    "LabVIEW": (lvm, 3, "beamwave-record"),
    "MATLAB 5": (lambda path: scipy.io.savemat(path, {"a": RING}, appendmat=False), 3, "beamwave-record"),
    "NumPy": (npy, 3, "beamwave-record"),
    "WAV": (wav, 3, "beamwave-record"),
    "UFF 58": (uff, 3, "beamwave-record"),
    "zip": (zipped, 3, "beamwave-record"),
}


def check(here, **names):
    """What `check` of the record says, and how much memory and processor time that took."""
    (here.directory / "ring.nml").write_text(namelist({"record": {"file": "data/ring", **names}, "spectrum": {}}))
    began = time.monotonic()
    with open(here.directory / "said", "w+") as said, subprocess.Popen(
        here.command(["check", "ring.nml"]), cwd=here.directory, stdout=subprocess.DEVNULL, stderr=said
    ) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read()
    (here.directory / "said").unlink()
    assert time.monotonic() - began < SECONDS
    assert used.ru_maxrss < 1000 * MOST_MEGABYTES
    assert used.ru_utime + used.ru_stime < 20  # half of it page faults, which a virtual machine serves slowly
    return process.returncode, text


@pytest.mark.parametrize("case", HOSTILE.values(), ids=HOSTILE.keys())
def test_a_hostile_record_is_refused_in_one_line(here, case):
    make, status, said = case
    (here.directory / "data").mkdir()
    make(here.directory / "data/ring")
    ended, text = check(here)
    assert (ended, text.count("\n")) == (status, 1), text
    assert said in text and text.startswith(("data/ring", "ring.nml")), text
    assert here.left(".") == ["data", "data/ring", "ring.nml"]


def test_a_missing_value_is_left_out(here):
    (here.directory / "data").mkdir()
    netcdf(here.directory / "data/ring", missing_value=RING[7])
    ended, text = check(here)
    assert ended == 0 and f"rows: 1 of {N} are left out: a value or the time is missing" in text


def test_damaged_bytes_are_read_or_told_in_one_line(here):
    (here.directory / "data").mkdir()
    path = here.directory / "data/ring"
    netcdf(path, form="NETCDF4")
    whole = path.read_bytes()
    random = np.random.default_rng(20020917)
    for _ in range(40):
        damaged = bytearray(whole)
        for place in random.integers(0, len(whole), random.integers(1, 4)):
            damaged[place : place + random.integers(1, 24)] = random.bytes(random.integers(1, 24))
        path.write_bytes(damaged)
        ended, text = check(here)
        assert ended in (0, 2, 3), text
        assert text.count("\n") == (ended > 0) and (ended == 0 or text.startswith(("data/ring", "ring.nml"))), text


@pytest.mark.parametrize("what", ["a pipe", "/dev/zero", "a directory"])
def test_what_is_no_file_is_no_record(here, what):
    (here.directory / "data").mkdir()
    path = here.directory / "data/ring"
    if what == "a pipe":
        os.mkfifo(path)
    elif what == "a directory":
        path.mkdir()
    else:
        path.symlink_to(what)
    ended, text = check(here)
    assert (ended, text.count("\n")) == (3, 1), text
    assert text.startswith("data/ring: is a ")


def test_attributes_that_say_little_are_told_and_left(here):
    (here.directory / "data").mkdir()
    path = here.directory / "data/ring"
    for odd in [{"position": [0.5, 1.0]}, {"position": "left"}, {"position": 1.5}, {"position": np.nan}]:
        netcdf(path, **odd)
        ended, text = check(here)
        assert (ended, text) == (0, "ring.nml: warning: position: the value that the file gives for acceleration is "
                                    "not a number from 0 to 1, and is ignored\n")
    for odd in [{"units": 3}, {"units": ["m", "s"]}, {"quantity": np.zeros(9)}, {"position": 0.5}, {"scale_factor": []}]:
        netcdf(path, **odd)
        assert check(here) == (0, "")


@pytest.mark.parametrize("kind", ["letters", "strings", "fixed strings"])
def test_attributes_of_every_type_of_text_are_read(here, kind):
    """h5py, netCDF4 and beamwave-record write strings, others letters."""
    (here.directory / "data").mkdir()
    path = here.directory / "data/ring"
    texts = {"time": {"units": "ms"}, "y": {"units": "mg", "quantity": "acceleration"}, "z": {"units": "mm"}}
    if kind == "fixed strings":
        with h5py.File(path, "w") as file:
            for name, values in {"time": 1000 * TIME, "y": RING, "z": RING}.items():
                file[name] = values
                file[name].attrs.update({key: np.bytes_(text) for key, text in texts[name].items()})
            file["time"].make_scale("time")
            for name in ["y", "z"]:
                file[name].dims[0].attach_scale(file["time"])
    else:
        with netCDF4.Dataset(path, "w") as file:
            file.createDimension("time", N)
            for name, values in {"time": 1000 * TIME, "y": RING, "z": RING}.items():
                file.createVariable(name, "f8", ("time",))[:] = values
                for key, text in texts[name].items():
                    put = file[name].setncattr_string if kind == "strings" else file[name].setncattr
                    put(key, text)
    here.scene("ring", {"record": {"file": "data/ring"}, "spectrum": {}})
    ended = here.beamwave("check", "ring.nml")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "even, 1000 Hz" in ended.stdout
    assert "sensor     y, acceleration: -0.0" in ended.stdout and " to 0.00980665 m s-2" in ended.stdout
    assert "sensor     z, displacement: -" in ended.stdout and " to 0.001 m" in ended.stdout
