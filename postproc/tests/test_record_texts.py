"""`beamwave-record` and the texts of loggers: headers, clocks, commas, several tables; all numbers come through."""

import numpy as np
import pytest

from beamwave_postproc.record import NotARecord, Wanted, cli, read_channels

COUNT = 20
SAMPLES = np.round(np.cos(0.7 * np.arange(COUNT)), 3)


def rows(form, count=COUNT):
    return "".join(form(number, sample) + "\n" for number, sample in enumerate(SAMPLES[:count]))


def read(path, text, wanted=None, encoding="utf-8"):
    path.write_bytes(text.encode(encoding))
    return read_channels(path, wanted)


def comma(value):
    return str(value).replace(".", ",")


def midnight(number):
    return (
        f"23:59:{59.0 + number / 4:06.3f}"
        if number < 4
        else f"00:{(number - 4) // 240:02d}:{(number - 4) % 240 / 4:06.3f}"
    )


TEXTS = {  # text, names and units, interval of the times
    "phyphox": (
        '"Time (s)","Acceleration x (m/s^2)"\n' + rows(lambda n, y: f"{n / 4:.9E},{y:.9E}"),
        [("Acceleration x", "m/s^2")],
    ),
    "Picoscope": ("Time  A\n(ms) (mV)\n\n" + rows(lambda n, y: f"{250 * n} {y}"), [("A", "mV")]),
    "rows that end in a separator": ("t;a;\n" + rows(lambda n, y: f"{n / 4};{y};"), [("a", "")]),
    "decimal commas": ("Zeit [s]\ta [g]\n" + rows(lambda n, y: f"{comma(n / 4)}\t{comma(y)}"), [("a", "g")]),
    "dates and clocks": (
        "Logger 7\nSerial;12\n\nDatum;Zeit;a [g]\n"
        + rows(lambda n, y: f"1.2.2024;12:00:{comma(f'{n / 4:05.2f}')};{comma(y)}"),
        [("a", "g")],
    ),
    "ISO times": ("timestamp,acc\n" + rows(lambda n, y: f"2024-02-01T23:59:{40 + n / 4:05.2f}Z,{y}"), [("acc", "")]),
    "across midnight": ("clock\tacc\n" + rows(lambda n, y: f"{midnight(n)}\t{y}"), [("acc", "")]),
    "names in a comment": ("# t a\n# s mm\n" + rows(lambda n, y: f"{n / 4} {y}"), [("a", "mm")]),
    "names between commas above blanks": (
        "time(s), x acceleration(g), y\n" + rows(lambda n, y: f"{n / 4} {y} {y}"),
        [("x acceleration", "g"), ("y", "")],
    ),
    "commas and blanks above blanks": ("time(s), a(g)\n" + rows(lambda n, y: f"{n / 4} {y}"), [("a", "g")]),
    "units behind blanks": ("# time [s]  a [g]\n" + rows(lambda n, y: f"{n / 4} {y}"), [("a", "g")]),
    "Fortran": ("time a\n" + rows(lambda n, y: f"{n / 4:.3f}D+00 {y}D0"), [("a", "")]),
}


@pytest.mark.parametrize("case", TEXTS.values(), ids=TEXTS.keys())
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_numbers_times_names_and_units_come_through(tmp_path, case, encoding):
    text, names = case
    found = read(tmp_path / "a.csv", text, encoding=encoding)
    assert [(channel.name, channel.unit) for channel in found] == names
    np.testing.assert_array_equal(found[0].values, SAMPLES)
    np.testing.assert_allclose(found[0].times, np.arange(COUNT) / 4, atol=1e-12)


@pytest.mark.parametrize("cell", ["", "NaN", "N/A", "#N/A", "NULL", "--"])
def test_a_cell_that_is_empty_or_says_so_is_a_sample_that_is_missing(tmp_path, cell):
    (channel,) = read(tmp_path / "a.csv", "t;a\n" + rows(lambda n, y: f"{n};{cell if n == 7 else y}"))
    assert np.flatnonzero(np.isnan(channel.values)).tolist() == [7]


def test_several_tables_are_records_of_their_own(tmp_path, capsys):
    table = "t,a\n" + rows(lambda n, y: f"{n},{y}")
    (tmp_path / "a.csv").write_text(f"Run 1\n{table}\nRun 2\n{table}")
    assert cli.main([str(tmp_path / "a.csv")]) == 0
    assert capsys.readouterr().out.count(f"{COUNT} samples") == 2
    assert sorted(path.name for path in tmp_path.glob("*.nc")) == ["a_1.nc", "a_2.nc"]


def test_the_column_of_the_times_may_be_told(tmp_path):
    text = rows(lambda n, y: f"{y},{250 * n}")
    with pytest.raises(NotARecord, match="no column of times among column 1, column 2"):
        read(tmp_path / "a.csv", text)
    (channel,) = read(tmp_path / "a.csv", text, Wanted(time="2", time_scale=1e-3))
    np.testing.assert_allclose(channel.times, np.arange(COUNT) / 4)
    rate = read(tmp_path / "a.csv", text, Wanted(sample_rate=4.0))
    assert [one.name for one in rate] == ["column_1", "column_2"]
    with pytest.raises(NotARecord, match="no column called when"):
        read(tmp_path / "a.csv", text, Wanted(time="when"))


@pytest.mark.parametrize(
    "content", [b"", b"words\n", b"1,2\n" * 3, b"a\0b" * 300], ids=["nothing", "words", "short", "binary"]
)
def test_what_holds_no_table_is_refused(tmp_path, content):
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(NotARecord):
        read_channels(tmp_path / "a.csv")


def labview(x_columns, parts=1, separator="\t", decimal="."):
    """Two channels as LabVIEW writes them."""
    head = ["LabVIEW Measurement", "Writer_Version\t2", f"Separator\t{'Tab' if separator == chr(9) else 'Comma'}"]
    head += [f"Decimal_Separator\t{decimal}", f"X_Columns\t{x_columns}", "***End_of_Header***", ""]
    lines = [line.replace("\t", separator) for line in head]
    for part in range(parts):
        said = {
            "Channels": "2",
            "Samples": COUNT,
            "Y_Unit_Label": "g N",
            "X0": f"{part} {part}",
            "Delta_X": "0.25 0.25",
        }
        apart = separator * (2 if x_columns == "Multi" else 1)
        lines += [key + separator + str(words).replace(" ", apart) for key, words in said.items()]
        lines.append("***End_of_Header***")
        names = ["X_Value", "acc", "X_Value", "force"] if x_columns == "Multi" else ["X_Value", "acc", "force"]
        lines.append(separator.join([*names, "Comment"]))
        for number, sample in enumerate(SAMPLES):
            x = "" if x_columns == "No" else f"{part + number / 4}"
            cells = [x, f"{sample}", x, f"{2 * sample}"] if x_columns == "Multi" else [x, f"{sample}", f"{2 * sample}"]
            lines.append(separator.join(cells))
        lines.append("")
    return "\r\n".join(line.replace(".", decimal) if line[:1] in "-0123456789" + separator else line for line in lines)


@pytest.mark.parametrize("x_columns", ["No", "One", "Multi"])
@pytest.mark.parametrize("parts", [1, 2])
@pytest.mark.parametrize(("separator", "decimal"), [("\t", "."), ("\t", ","), (",", ".")])
def test_a_labview_measurement(tmp_path, x_columns, parts, separator, decimal):
    text = labview(x_columns, parts, separator, decimal).replace("0.25", f"0{decimal}25")
    found = read(tmp_path / "a.lvm", text)
    assert [(one.name, one.unit) for one in found] == [("acc", "g"), ("force", "N")] * parts
    for number, channel in enumerate(found):
        np.testing.assert_array_equal(channel.values, SAMPLES * (1 + number % 2))
        np.testing.assert_allclose(channel.times, number // 2 + np.arange(COUNT) / 4)


def test_labviews_rounded_times_are_those_of_the_interval(tmp_path):
    text = labview("One").replace("0.25", "1.953125E-5")
    rows = [f"{number / 51200:.6f}\t{sample}\t0" for number, sample in enumerate(SAMPLES)]
    found = read(tmp_path / "a.lvm", text[: text.index("0.0\t")] + "\r\n".join(rows))
    np.testing.assert_allclose(found[0].times, np.arange(COUNT) / 51200, rtol=1e-15)


def test_labviews_uneven_times_are_kept(tmp_path):
    uneven = np.arange(COUNT) / 4 + np.where(np.arange(COUNT) % 2, 0.02, 0.0)
    text = labview("One")
    rows = [f"{time:.6f}\t{sample}\t0" for time, sample in zip(uneven, SAMPLES, strict=True)]
    found = read(tmp_path / "a.lvm", text[: text.index("0.0\t")] + "\r\n".join(rows))
    np.testing.assert_allclose(found[0].times, uneven)


def portioned(start, heads):
    """Two portions, the second from `start` samples on, with a head of its own or without."""
    text = labview("One").rstrip()
    head = text[text.index("Channels") : text.index("X_Value")].replace("X0\t0\t0", f"X0\t{start / 4}\t{start / 4}")
    names, *samples = text[text.index("X_Value") :].splitlines()
    later = [f"{float(row.split(chr(9))[0]) + start / 4}\t" + row.split("\t", 1)[1] for row in samples]
    return "\r\n".join([text, "", *([head + names] if heads else []), *later, ""])


@pytest.mark.parametrize("heads", [True, False])
def test_portions_of_labview_that_go_on_are_one_record(tmp_path, heads):
    found = read(tmp_path / "a.lvm", portioned(COUNT, heads))
    assert [(one.name, one.unit, one.record) for one in found] == [("acc", "g", ""), ("force", "N", "")]
    np.testing.assert_array_equal(found[0].values, np.tile(SAMPLES, 2))
    np.testing.assert_allclose(found[0].times, np.arange(2 * COUNT) / 4)


def test_portions_of_labview_that_begin_anew_are_records_or_take_a_sampling_rate(tmp_path):
    assert [one.record for one in read(tmp_path / "a.lvm", portioned(0, True))] == ["1", "1", "2", "2"]
    with pytest.raises(NotARecord, match="row 21: the time is 0 s after 4.75 s; accepted: times that rise, or --sample"):
        read(tmp_path / "a.lvm", portioned(0, False))
    assert read(tmp_path / "a.lvm", portioned(0, False), Wanted(sample_rate=4.0))[0].times[-1] == (2 * COUNT - 1) / 4


def test_a_spectrum_of_labview_is_no_record(tmp_path):
    with pytest.raises(NotARecord, match="its samples are over frequency; accepted: histories in time"):
        read(tmp_path / "a.lvm", labview("One").replace("X0\t", "X_Dimension\tFrequency\tFrequency\r\nX0\t"))


def test_a_labview_measurement_that_is_cut_off_is_refused(tmp_path):
    for cut in (40, 150):
        with pytest.raises(NotARecord):
            read(tmp_path / "a.lvm", labview("No")[:cut])


def dated(first, last, count=COUNT):
    """A record across midnight, a sample in a second."""
    half = count // 2
    return "t,acc\n" + rows(
        lambda n, y: f"{first} 23:59:{60 - half + n:02d},{y}" if n < half else f"{last} 00:00:{n - half:02d},{y}"
    )


@pytest.mark.parametrize(
    ("first", "last", "order"),
    [
        ("31/01/2024", "01/02/2024", None),
        ("01/31/2024", "02/01/2024", None),
        ("1.2.2024", "2.2.2024", None),
        ("01-02-24", "02-02-24", "day"),
        ("02/01/2024", "02/02/2024", "month"),
        ("2024-01-31", "2024-02-01", None),
    ],
)
def test_a_record_past_midnight_goes_on_by_seconds(tmp_path, first, last, order):
    (channel,) = read(tmp_path / "record.csv", dated(first, last), Wanted(date_order=order))
    np.testing.assert_allclose(channel.times, np.arange(COUNT))


def test_clocks_by_milliseconds_are_even_to_the_last_bit_past_midnight(tmp_path):
    clocks = "t,acc\n" + rows(lambda n, y: (f"23:59:59.{990 + n}" if n < 10 else f"00:00:00.{n - 10:03d}") + f",{y}")
    (channel,) = read(tmp_path / "record.csv", clocks)
    np.testing.assert_array_equal(channel.times, np.round(np.arange(COUNT) / 1000, 3))


def test_dates_that_may_be_read_either_way_are_refused(tmp_path):
    with pytest.raises(NotARecord, match="02/02/2024, whose day or month may be first; accepted: --date-order day or"):
        read(tmp_path / "record.csv", dated("01/02/2024", "02/02/2024"))
    with pytest.raises(NotARecord, match="cannot be told"):
        read(tmp_path / "record.csv", dated("31/01/2024", "01/02/2024"), Wanted(date_order="month"))


def test_a_single_date_need_not_be_told(tmp_path):
    (channel,) = read(tmp_path / "record.csv", "t,acc\n" + rows(lambda n, y: f"01/02/2024 12:00:{n:02d},{y}"))
    np.testing.assert_allclose(channel.times, np.arange(COUNT))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("1.0,", "0.75,"), "line 6: the time is 0.75 s after 0.75 s"),
        (("1.0,", "0.5,"), "line 6: the time is 0.5 s after 0.75 s"),
        (("1.0,", ","), "line 6: the time is nan s after 0.75 s"),
        (("1.0,-0.942", "1.0,inf"), "line 6: a is infinite"),
        (("1.0,-0.942", "1.0,OVR"), "line 6: 'OVR' stands among numbers"),
        (("0.0,1.0", "0.0,OVR"), "line 2: 'OVR' stands among numbers"),
    ],
)
def test_inconsistent_rows_are_refused_with_their_line(tmp_path, change, said):
    text = "time,a\n" + rows(lambda n, y: f"{n / 4},{y}")
    assert change[0] in text
    with pytest.raises(NotARecord) as failure:
        read(tmp_path / "a.csv", text.replace(*change, 1))
    assert str(failure.value).startswith(said)


@pytest.mark.parametrize("clock", [lambda n: n / 4, lambda n: n // 4])
def test_a_sampling_rate_is_for_files_whose_times_do_not_rise(tmp_path, clock):
    text = "time,a\n" + rows(lambda n, y: f"{clock(n)},{y}")
    if clock(1):
        with pytest.raises(NotARecord, match="has times of its own, column time"):
            read(tmp_path / "a.csv", text, Wanted(sample_rate=5.0))
    else:
        assert read(tmp_path / "a.csv", text, Wanted(sample_rate=5.0))[0].times[1] == 0.2
