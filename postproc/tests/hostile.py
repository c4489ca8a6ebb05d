"""Files that do harm to what reads them: each is a good one but for one thing, and is written by a function."""

import io
import os
import struct
import zlib
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pyuff
import scipy.io
import scipy.io.wavfile
import synthetic

TIMES = np.arange(300) / 2048.0
VALUES = np.cos(300.0 * TIMES)
BOMB = 10**10  # numbers that nobody has
USER_BLOCK = b"MATLAB 7.3 MAT-file".ljust(512)


def matlab(path, **arrays):
    """A good .mat file of version 5."""
    scipy.io.savemat(path, {"t": TIMES, "a": VALUES, **arrays})


def new_matlab(path, spoil):
    """A .mat file of version 7.3, of which `spoil` makes what it is."""
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"], file["a"] = TIMES, VALUES
        spoil(file)
    with path.open("r+b") as file:
        file.write(USER_BLOCK)


def another(path):
    """A good HDF5 file beside `path`, whose numbers are none of its business."""
    other = path.with_name("secret.h5")
    with h5py.File(other, "w") as file:
        file["a"] = VALUES
    return other


def mat_cut(path):
    matlab(path)
    path.write_bytes(path.read_bytes()[:-100])


def mat_of_absurd_size(path):
    """An array of 2³¹ − 1 × 2³¹ − 1 numbers, packed."""
    name = struct.pack("<II4s4x", 1, 1, b"a")
    array = struct.pack("<IIIIIIii", 6, 8, 6, 0, 5, 8, 2**31 - 1, 2**31 - 1) + name + struct.pack("<II", 9, 2**31 - 8)
    packed = zlib.compress(struct.pack("<II", 14, len(array)) + array)
    path.write_bytes(b"MATLAB 5.0".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(packed)) + packed)


def mat_of_nested_cells(path):
    """Cells within cells, 20 000 deep."""
    body = b""
    for _ in range(20_000):
        body = struct.pack("<IIIIIIiiII", 6, 8, 1, 0, 5, 8, 1, 1, 1, 0) + body
        body = struct.pack("<II", 14, len(body)) + body
    path.write_bytes(b"MATLAB 5.0".ljust(124) + b"\x00\x01IM" + body)


def mat_linked_elsewhere(path):
    new_matlab(path, lambda file: file.update(b=h5py.ExternalLink(str(another(path)), "/a")))


def mat_linked_to_a_pipe(path):
    os.mkfifo(path.with_name("pipe"))
    new_matlab(path, lambda file: file.update(b=h5py.ExternalLink("pipe", "/a")))


def mat_linked_softly(path):
    new_matlab(path, lambda file: file.update(b=h5py.SoftLink("/a")))


def mat_in_circles(path):
    new_matlab(path, lambda file: file.create_group("s").update(again=file))


def mat_stored_elsewhere(path):
    another(path)
    stored = {"shape": (300,), "dtype": "f8", "external": [("secret.h5", 0, 2400)]}
    new_matlab(path, lambda file: file.create_dataset("b", **stored))


def mat_put_together_elsewhere(path):
    def spoil(file):
        layout = h5py.VirtualLayout(shape=(300,), dtype="f8")
        layout[:] = h5py.VirtualSource(str(another(path)), "a", shape=(300,))
        file.create_virtual_dataset("b", layout)

    new_matlab(path, spoil)


def mat_of_numbers_never_written(path):
    new_matlab(path, lambda file: file.create_dataset("b", shape=(BOMB,), dtype="f8", chunks=(10**6,)))


def mat_cut_inside(path):
    new_matlab(path, lambda file: None)
    path.write_bytes(path.read_bytes()[:1500])


def universal(path, **changes):
    """A good universal file, or with other lines in its header."""
    dataset = pyuff.prepare_58(
        binary=0, func_type=1, rsp_node=9, rsp_dir=1, ref_dir=1, ref_node=1, data=VALUES, x=TIMES, abscissa_spacing=1,
        abscissa_inc=1 / 2048, abscissa_min=0.0, abscissa_spec_data_type=17, ordinate_spec_data_type=8,
        orddenom_spec_data_type=0, ord_data_type=4,
    )  # fmt: skip
    path.unlink(missing_ok=True)
    pyuff.UFF(str(path)).write_sets(dataset, mode="add")
    text = path.read_text()
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)


def uff_of_absurd_count(path):
    universal(path, count=("       300", "2000000000"))


def uff_of_no_samples(path):
    universal(path, count=("       300", "         0"))


def uff_without_an_interval(path):
    universal(path, interval=("4.88281e-04", "0.00000e+00"))


def uff_of_endless_time(path):
    universal(path, interval=("4.88281e-04", "        inf"))


def uff_cut(path):
    universal(path)
    text = path.read_text()
    path.write_text(text[: len(text) // 2] + "\n    -1\n")


def npy_of_objects(path):
    """What reads it runs the code in it: makes a file, if it does."""

    class Harm:
        def __reduce__(self):
            return Path.touch, (path.with_name("harm"),)

    np.save(path, np.array([Harm()], dtype=object), allow_pickle=True)


def npy_header(path, text):
    header = text.encode().ljust(118) + b"\n"
    path.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + bytes(2400))


def npy_of_absurd_size(path):
    npy_header(path, f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({BOMB},), }}")


def npy_of_negative_size(path):
    npy_header(path, "{'descr': '<f8', 'fortran_order': False, 'shape': (-300,), }")


def npy_of_nested_brackets(path):
    text = "(" * 9000
    path.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode())


def npy_of_wide_numbers(path):
    """One number, as wide as 2³⁰ bytes."""
    npy_header(path, f"{{'descr': '|V{2**30}', 'fortran_order': False, 'shape': (300,), }}")


def sound(path, place, form, value):
    """A sound file with another number at a place of its header."""
    file = io.BytesIO()
    scipy.io.wavfile.write(file, 2048, (1000 * VALUES).astype(np.int16))
    data = bytearray(file.getvalue())
    struct.pack_into(form, data, place, value)
    path.write_bytes(data)


def wav_longer_than_it_is(path):
    sound(path, 40, "<I", 2**31)


def wav_without_a_rate(path):
    sound(path, 24, "<I", 0)


def wav_without_channels(path):
    sound(path, 22, "<H", 0)


def wav_of_many_channels(path):
    sound(path, 22, "<H", 65535)


def wav_of_odd_numbers(path):
    sound(path, 34, "<H", 60000)


def wav_in_a_form_that_is_none(path):
    sound(path, 20, "<H", 0xABC)


def csv_of_one_long_line(path):
    path.write_text("," * 10**6)


def lvm_of_too_many_columns(path):
    path.write_text(
        f"LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tMulti\nChannels\t{BOMB}\n***End_of_Header***\n0\t1\n"
    )


def hdf5_that_is_no_matlab(path):
    with h5py.File(path, "w") as file:
        file["a"] = VALUES


RECORDS = {
    function: end
    for function, end in [
        *((one, ".mat") for one in (mat_cut, mat_of_absurd_size, mat_of_nested_cells, mat_linked_elsewhere)),
        *((one, ".mat") for one in (mat_linked_to_a_pipe, mat_linked_softly, mat_in_circles, mat_stored_elsewhere)),
        *((one, ".mat") for one in (mat_put_together_elsewhere, mat_of_numbers_never_written, mat_cut_inside)),
        *((one, ".uff") for one in (uff_of_absurd_count, uff_of_no_samples, uff_without_an_interval)),
        *((one, ".uff") for one in (uff_of_endless_time, uff_cut)),
        *((one, ".npy") for one in (npy_of_objects, npy_of_absurd_size, npy_of_negative_size)),
        *((one, ".npy") for one in (npy_of_nested_brackets, npy_of_wide_numbers)),
        *((one, ".wav") for one in (wav_longer_than_it_is, wav_without_a_rate, wav_without_channels)),
        *((one, ".wav") for one in (wav_of_many_channels, wav_of_odd_numbers, wav_in_a_form_that_is_none)),
        *((one, ".txt") for one in (csv_of_one_long_line, hdf5_that_is_no_matlab)),
        (lvm_of_too_many_columns, ".lvm"),
    ]
}


def result(path, spoil, version=2):
    """A result, of which `spoil` makes what it is."""
    synthetic.write(path, synthetic.scene(response={"duration": 0.1, "samples": 64}), version=version)
    with netCDF4.Dataset(path, "a") as file:
        spoil(file)


def version_of_two_numbers(path):
    result(path, lambda file: file.setncattr("format_version", np.array([1, 1], dtype="i4")))


def source_of_numbers(path):
    result(path, lambda file: file.setncattr("source", np.arange(9)))


def factor_of_two_numbers(path):
    result(path, lambda file: file["displacement"].setncattr("scale_factor", [1.0, 2.0]))


def time_of_another_calendar(path):
    result(path, lambda file: file["time"].setncattr("units", "seconds since 10000000-13-45"))


def modes_never_written(path):
    def spoil(file):
        file.createDimension("many", BOMB)
        file.renameVariable("wavenumber", "old")
        file.createVariable("wavenumber", "f8", ("many",), chunksizes=(10**6,))

    result(path, spoil, version=1)


def result_cut(path):
    result(path, lambda file: None)
    path.write_bytes(path.read_bytes()[:5000])


def result_of_zeros(path):
    result(path, lambda file: None)
    data = path.read_bytes()
    path.write_bytes(data[:2000] + bytes(len(data) - 2000))


RESULTS = [
    version_of_two_numbers, source_of_numbers, factor_of_two_numbers, time_of_another_calendar, modes_never_written,
    result_cut, result_of_zeros,
]  # fmt: skip
