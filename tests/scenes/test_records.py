"""Records: what `check` says of them, and how bad ones are refused, each with the place."""

import math

import pytest
from workplace import captured_beam, namelist

SAMPLES = 200
ROWS = [(j / 1000, math.exp(-j / 80) * math.cos(0.3 * j), 0.5 * math.sin(0.2 * j)) for j in range(SAMPLES)]


def table(rows=ROWS, head="time,acc1,acc2", form="{:.3f},{:.6f},{:.6f}"):
    return "\n".join([head, *(form.format(*row) for row in rows)]) + "\n"


def check(here, text, **names):
    """What `check` says of a record of that text."""
    here.write("data/ring.csv", text)
    here.scene("data/ring", {"record": {"file": "ring.csv", **names}, "spectrum": {}})
    return here.beamwave("check", "data/ring.nml")


def test_check_says_what_a_record_holds(here):
    ended = check(here, table(), points=[0.5, 1.0], quantity="acceleration", scale=9.80665, end=0.15)
    assert (ended.returncode, ended.stderr) == (0, "")
    said = [line.strip() for line in ended.stdout.splitlines()]
    assert "record     data/ring.csv: 151 samples of 200, 2 sensors" in said
    assert "times      0 to 0.15 s, even, 1000 Hz" in said
    assert any(line.startswith("sensor     acc1, acceleration at xi = 0.5: -") and line.endswith(" m s-2") for line in said)


@pytest.mark.parametrize(
    "form",
    ["{:.3f};{:.6f};{:.6f}", "{:.3f}\t{:.6f}\t{:.6f}", "  {:.3f}   {:.6f} {:.6f} ", "{:.3f}, {:.6e},{:.8g}"],
)
def test_layouts_are_told_by_their_content(here, form):
    ended = check(here, table(form=form, head="# by hand"), time=1)
    assert "200 samples, 2 sensors" in ended.stdout, ended.stderr
    ended = check(here, table(form=form, head="# by hand").replace("\n", "\r\n"), time=1)
    assert "200 samples, 2 sensors" in ended.stdout, ended.stderr


@pytest.mark.parametrize("word", ["nan", "", "NA", "inf"])
def test_rows_without_a_number_or_a_time_of_their_own_are_left_out(here, word):
    lines = table().splitlines()
    cells = [line.split(",") for line in lines]
    whole = check(here, "\n".join(line for i, line in enumerate(lines) if i not in (20, 21, 90, 130)) + "\n")
    cells[20][1] = cells[21][2] = cells[90][0] = word
    cells[130][0] = cells[129][0]
    ended = check(here, "\n".join(map(",".join, cells)) + "\n")
    assert "196 samples of 200" in ended.stdout, ended.stderr
    said, whole = (text.stdout.split("warning")[0] for text in (ended, whole))
    assert said.replace("196 samples of 200", "196 samples") == whole
    assert "rows: 4 of 200 are left out: a value or the time is missing, or the time is that of the row before" in ended.stderr


BAD = {  # text, names, status, what standard error begins with
    "too many gaps": (table(ROWS[:110]) + table(ROWS[110:], form="{:.3f},nan,nan").split("\n", 1)[1], {"start": 0.1}, 3,
                      "data/ring.csv: has 10 complete rows, and column acc1 lacks 90 of 100 values; accepted: 16 rows or more"),
    "a short row": (table() + "9.0,1.0\n", {}, 3, "data/ring.csv:202: has 2 of 3 columns"),
    "a word": (table() + "9.0,1.0,off\n", {}, 3, "data/ring.csv:202: column 3 (acc2): 'off' is not a finite number"),
    "a time that falls": (table() + "0.1,1.0,2.0\n", {}, 3, "data/ring.csv:202: the time 0.1 is not later than 0.199"),
    "no such column": (table(), {"columns": "acc7"}, 2, "data/ring.nml:3: record%columns: 'acc7' is no column of data/ring.csv"),
    "no time": (table(head="x,y,z"), {}, 2, "data/ring.nml: record%time: is missing"),
    "places": (table(), {"points": [0.1, 0.2, 0.3]}, 2, "data/ring.nml:3: record%points: has 3 values"),
    "nothing left": (table(), {"start": 0.19}, 2, "data/ring.nml:3: record%start: leaves 10 of 200 samples"),
    "no such file": (table(), {"file": "other.csv"}, 3, "data/other.csv: cannot be read: "),
    "a directory": (table(), {"file": "."}, 3, "data/.: "),
    "no table": ("some words\n", {}, 3, "data/ring.csv: has no rows of numbers"),
}


@pytest.mark.parametrize("case", BAD.values(), ids=BAD.keys())
def test_a_bad_record_is_refused_with_its_place(here, case):
    text, names, status, said = case
    ended = check(here, text, **names)
    assert (ended.returncode, len(ended.stderr.splitlines())) == (status, 1), ended.stderr
    assert ended.stderr.startswith(said)
    assert here.left(".") == ["data", "data/ring.csv", "data/ring.nml"]


def test_samples_that_say_nothing_and_unknown_units_are_warned_of(here):
    clipped = [(time, max(-0.4, min(0.4, one)), 0.1 if 50 < j < 90 else two) for j, (time, one, two) in enumerate(ROWS)]
    ended = check(here, table(clipped, head="time,acc [g],strain [um/m]"))
    assert ended.returncode == 0
    for kind in ["clipped: acc [g] is cut off above 3.92266", "clipped: acc [g] is cut off below -3.92266",
                 "constant: strain [um/m] stays at 1e-7 from 0.051 to 0.089 s"]:
        assert f"data/ring.nml: warning: {kind}" in ended.stderr
    assert "note: units: acc [g] is in 'g', and is converted to m s-2" in ended.stdout
    unknown = check(here, table(head="time,acc [V],strain [um/m]"))
    assert "warning: units: acc [V] is in 'V', which is not a known unit of motion; the values stay in V" in unknown.stderr


def test_a_clock_that_counts_from_long_ago_is_told_by_its_start_and_the_duration(here):
    late = [(1.7e9 + time, *values) for time, *values in ROWS]
    late[100:140] = [(time, 0.25, two) for time, _, two in late[100:140]]
    ended = check(here, table(late), quantity="acceleration", start=1.7e9 + 0.01)
    assert "  times      from 1700000000.01 s on, for 0.189 s, even, 1000 Hz" in ended.stdout.splitlines()
    assert "constant: acc1 stays at 0.25 from 1700000000.1 to 1700000000.139 s" in ended.stderr


def test_a_quantity_that_nobody_says_is_warned_of(here):
    taken = "data/ring.nml: warning: quantity: not given in the file for acc1; displacement is assumed, unless quantity = 'acceleration'"
    assert taken in check(here, table(head="time,acc1,acc2 [m/s2]")).stderr
    assert check(here, table(head="time,acc1 [m/s2],acc2 [m/s2]")).stderr == ""
    assert check(here, table(), quantity="displacement").stderr == ""


def test_a_force_without_a_unit_is_in_newtons_and_warned_of(here):
    warning = "data/ring.nml: warning: force: not given in a unit, and N is assumed"
    bare = check(here, table(head="time,acc [m/s2],hammer"), force="hammer")
    assert (bare.returncode, bare.stderr.count(warning)) == (0, 1)
    assert check(here, table(head="time,acc [m/s2],hammer [N]"), force="hammer").stderr == ""
    sensor = check(here, table(head="time,acc [m/s2],hammer [N]")).stderr
    assert "hammer [N] is in 'N', a unit of force, but is treated as displacement; force makes a column the hammer's" in sensor
    wrong = check(here, table(head="time,acc [m/s2],hammer [V]"), force="hammer")
    assert (wrong.returncode, "is in 'V', which is no unit of force" in wrong.stderr) == (2, True)


@pytest.mark.parametrize(("name", "scale"), [("micros", 1e6), ("millis", 1e3)])
def test_the_clock_of_a_microcontroller_has_its_unit(here, name, scale):
    ended = check(here, table([(scale * time, *values) for time, *values in ROWS], head=f"{name},a [m/s2],b [m/s2]"))
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "  times      0 to 0.199 s, even, 1000 Hz" in ended.stdout.splitlines()


def test_a_clock_that_repeats_most_times_is_warned_of(here):
    coarse = [(round(time / 4, 3), *values) for time, *values in ROWS]
    assert "clock: most rows are left out; if it has the same time for many samples, give sample_rate" in check(here, table(coarse)).stderr


def test_repeats_are_files_with_the_same_sensors(here):
    here.write("a.csv", table())
    here.write("b.csv", table(ROWS[:100]))
    here.write("c.csv", table(head="time,acc1", form="{:.3f},{:.6f}"))
    here.scene("two", {"record": {"file": ["a.csv", "b.csv"]}, "spectrum": {}})
    ended = here.beamwave("check", "two.nml")
    assert "a.csv: 200 samples, 2 sensors" in ended.stdout
    assert "b.csv: 100 samples, 2 sensors" in ended.stdout
    assert "2 cases: 2 of record%file" in ended.stdout
    here.scene("three", {"record": {"file": ["a.csv", "c.csv"]}, "spectrum": {}})
    ended = here.beamwave("check", "three.nml")
    assert ended.returncode == 2
    assert ended.stderr.startswith("c.csv: its sensors (displacement) are not those of a.csv (2 x displacement); accepted: ")


def test_a_result_is_a_record(here):
    here.scene("run", captured_beam(response={"duration": 0.1, "samples": 128, "points": [0.25, 1.0], "velocity": True}))
    here.run("run")
    here.scene("again", {"record": {"file": "output/run.nc"}, "spectrum": {}})
    ended = here.beamwave("check", "again.nml")
    assert ended.returncode == 0, ended.stderr
    assert "128 samples, 4 sensors" in ended.stdout
    assert "even, 1280 Hz" in ended.stdout
    assert "displacement(1), displacement at xi = 0.25" in ended.stdout
    assert "velocity(2), velocity at xi = 1" in ended.stdout


def test_a_sweep_is_no_record(here):
    scene = captured_beam(response={"duration": 0.1, "samples": 128})
    here.write("run.nml", namelist(scene, {"parameter": "impact%mass_ratio", "values": [0.1, 0.2]}))
    here.run("run")
    here.scene("again", {"record": {"file": "output/run.nc"}, "spectrum": {}})
    ended = here.beamwave("check", "again.nml")
    assert ended.returncode == 3
    assert "dimensions, as in a sweep" in ended.stderr
