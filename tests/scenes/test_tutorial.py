"""docs/tutorial.md: its reports are printed, its numbers those of the scenes of input/tutorial/, and these right by closed forms."""

import importlib.util
import math
import re

import numpy as np
import pytest
import xarray as xr
from conftest import PROJECT

TEXT = " ".join((PROJECT / "docs/tutorial.md").read_text(encoding="utf-8").split())
SCENES = {"arm_alone": 0, "arm": 0, "arm_stop": 0, "blade": 0, "clamp_rigid": 4, "clamp": 0}
EI, MASS, LENGTH = 70e9 * 0.04 * 0.02**3 / 12, 2700 * 0.04 * 0.02 * 0.8, 0.8


@pytest.fixture(scope="module")
def reports(shared):
    """What the runs print, and their results, by scene."""
    place = shared("tutorial")
    printed, results = {}, {}
    for name, status in SCENES.items():
        ended = place.beamwave("run", PROJECT / f"input/tutorial/{name}.nml", status=status)
        printed[name] = ended.stdout
        results[name] = xr.load_dataset(place.directory / f"output/{name}.nc")
    return printed, results


def says(number, digits, words):
    """The text has these words with the number rounded to so many digits behind the point in them."""
    assert words.format(f"{number:.{digits}f}") in TEXT, words.format(f"{number:.{digits}f}")


def is_printed(line, other):
    """Whether a line of a report is the same but for errors that are rounding, which compilers share out differently."""
    one, two = line.split(), other.split()
    return len(line) == len(other) and len(one) == len(two) and all(a == b or is_rounding(a, b) for a, b in zip(one, two))


def is_rounding(one, two):
    try:
        small, large = sorted(abs(float(word)) for word in (one, two))
    except ValueError:
        return False
    return large < 1e-6 and large < 2 * small


def test_what_it_shows_of_reports_is_printed(reports):
    document = (PROJECT / "docs/tutorial.md").read_text(encoding="utf-8")
    known = {line for report in reports[0].values() for line in report.splitlines()}
    shown = [line for block in re.findall(r"```text\n(.*?)```", document, re.DOTALL) for line in block.splitlines()]
    assert len(shown) > 15
    assert [line for line in shown if not any(is_printed(line, other) for other in known)] == []


def test_its_scenes_are_those_of_input(reports):
    """Each block of a scene says what the file says, but for title, comments and the folder of records."""
    document = (PROJECT / "docs/tutorial.md").read_text(encoding="utf-8")

    def bare(text):
        text = re.sub(r"!.*|&scene.*", "", text).replace("input/tutorial/", "").replace(",", " ")
        return text.split()

    files = [bare((PROJECT / f"input/tutorial/{name}.nml").read_text(encoding="utf-8")) for name in SCENES]
    blocks = re.findall(r"```fortran\n(.*?)```", document, re.DOTALL)
    assert len(blocks) == 5
    for block in blocks:
        assert bare(block) in files, block


def test_the_arm(reports):
    _, results = reports
    first = 1.8751040687119612**2 * math.sqrt(EI / (MASS / LENGTH)) / (2 * math.pi * LENGTH**2)
    assert float(results["arm_alone"]["angular_frequency"][0]) / (2 * math.pi) == pytest.approx(first, rel=1e-12)
    says(first, 2, "= {} Hz")
    stiffness, moving, ball = 3 * EI / LENGTH**3, 33 / 140 * MASS, 0.515
    reach = 2 * ball / (ball + moving) * math.sqrt((ball + moving) / stiffness)
    says(stiffness / 1e3, 1, "3EI/l³ = {} kN/m")
    says(moving, 3, "its mass, {} kg")
    says(1e3 * reach, 1, "would deflect by {} mm")
    moment = stiffness * reach * LENGTH
    says(moment, 0, "root would be {} N m")
    says(moment * 0.01 / (EI / 70e9) / 1e6, 0, "a stress of {} MPa")
    arm, stop = results["arm"], results["arm_stop"]
    says(1e3 * float(np.abs(arm["displacement"]).max()), 1, "moves by {} mm")
    largest = float(np.abs(arm["bending_moment"]).max())
    says(largest, 0, "reaches {} N m")
    says(largest * 0.01 / (EI / 70e9) / 1e6, 1, "M c/I = {} MPa")
    assert float(np.abs(arm["bending_stress"]).max()) == pytest.approx(largest * 0.01 / (EI / 70e9), rel=1e-12)
    says(float(np.abs(stop["bending_moment"]).max()), 0, "is still {} N m")
    assert float(arm["event_force"][0]) / float(stop["event_force"][0]) == pytest.approx(5, rel=0.05)  # a factor of five


def test_the_blade(reports):
    blade = reports[1]["blade"]
    frequency = blade["angular_frequency"].values[:, 0] / (2 * math.pi)
    speed = blade["rotation_angular_velocity"].values
    says(frequency[0], 2, "from {} Hz at rest")
    says(frequency[-1], 2, "to {} Hz at 382 rpm")
    south = (frequency[-1] ** 2 - frequency[0] ** 2) / (speed[-1] / (2 * math.pi)) ** 2
    says(south, 2, "with S = {}")
    fit = np.sqrt(frequency[0] ** 2 + south * (speed / (2 * math.pi)) ** 2)
    says(100 * np.max(1 - fit / frequency), 1, "up to {} % low")
    assert 1.0 < south < 2.0  # 1: a rigid blade that flaps about its root on the axis; the hub's radius and bending add to it
    for mode, order, words in ((0, 3, "Mode 1 crosses 3P at {} rpm"), (1, 3, "mode 2 at {} rpm")):
        gap = blade["angular_frequency"].values[:, mode] - order * speed
        i = int(np.argmax(gap < 0))
        met = speed[i - 1] + (speed[i] - speed[i - 1]) * gap[i - 1] / (gap[i - 1] - gap[i])
        stated = float(re.search(words.replace("{}", r"(\d+)"), TEXT)[1])
        assert met * 30 / math.pi == pytest.approx(stated, abs=1.5), words  # straight between speeds 19 rpm apart, rounded
    assert (blade["angular_frequency"].values[1:, 0] > speed[1:]).all()  # no mode crosses 1P


def test_the_clamp_is_the_one_that_the_records_were_made_with(reports):
    spec = importlib.util.spec_from_file_location("make_taps", PROJECT / "input/tutorial/make_taps.py")
    taps = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(taps)
    clamp, rigid = reports[1]["clamp"], reports[1]["clamp_rigid"]
    for name, true in (("beam%youngs_modulus", taps.MODULUS), ("support%rotational_stiffness", taps.CLAMP)):
        i = [str(text) for text in clamp["identified_parameter"].astype(str).values].index(name)
        assert float(clamp["identified_low"][i]) <= true <= float(clamp["identified_high"][i]), name
    measured = np.sort(clamp["measured_angular_frequency"].values[0, :5])
    np.testing.assert_allclose(measured, taps.modes()[0] * math.sqrt(1 - taps.DAMPING**2), rtol=5e-5)  # ten times +/- of line 2
    says(float(clamp["misfit"].values.flat[0]), 1, "χ² = {}")
    says(-float(clamp["identified_correlation"][0, 1]), 3, "(−{})")
    modelled = rigid["modelled_angular_frequency"].values[0]
    off = 100 * (1 - rigid["measured_angular_frequency"].values[0] / modelled)
    order = np.argsort(modelled)
    says(off[order[0]], 1, "is {} % below")
    says(off[order[4]], 1, "fifth only {} %")


def test_the_records_are_those_of_their_script(tmp_path):
    spec = importlib.util.spec_from_file_location("make_taps", PROJECT / "input/tutorial/make_taps.py")
    taps = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(taps)
    taps.__file__ = str(tmp_path / "make_taps.py")
    taps.main()
    for name in ("tap_1.csv", "tap_2.csv"):
        assert (tmp_path / name).read_text() == (PROJECT / "input/tutorial" / name).read_text()
