"""A result file holds what is promised: names, units, sources, sizes, fill where nothing exists, nothing unasked."""

import re
import subprocess
import sys
import time

import netCDF4
import numpy as np
import pytest
import results
from conftest import PROJECT
from drafts import drafts_in
from scipy.integrate import simpson
from workplace import PAPER_BEAM, SECONDS, captured_beam, group_text, namelist

MODAL = [
    "alpha",
    "wavenumber",
    "angular_frequency",
    "growth_rate",
    "modal_mass",
    "modal_velocity",
    "phase_velocity",
    "group_velocity",
]
EVENTS = ["event_time", "event_end", "event_kind", "event_impulse"]
EVENTS += [f"{what}_{when}" for what in ["energy", "momentum"] for when in ["before", "after"]]
MEASURED = [f"measured_{name}" for name in ["angular_frequency", "wavenumber", "phase_velocity", "group_velocity"]]
DIMENSIONS = {
    **{name: ("mode",) for name in MODAL},
    **{f"{name}_before": ("mode_before",) for name in MODAL},
    **{name: ("event",) for name in EVENTS},
    **{name + end: ("peak",) for name in MEASURED for end in ["", "_error"]},
    **dict.fromkeys(["impulse", "mass_velocity", "tip_velocity"], ()),
    **dict.fromkeys(["critical_angular_velocity", "critical_angular_velocity_before"], ()),
    **dict.fromkeys(["mode_count", "peak_count", "case_status"], ()),
    "velocity_jump": ("profile",),
    "mode_shape": ("mode", "profile"),
    **dict.fromkeys(["largest_displacement", "largest_displacement_time"], ("point",)),
    **dict.fromkeys(["displacement_error", "displacement_bound", "velocity_error"], ("point",)),
    "displacement": ("point", "time"),
    "velocity": ("point", "time"),
    "amplitude": ("point", "frequency"),
    "stage_seconds": ("stage",),
    **{name: ("mode",) for name in ["modal_stiffness", "modal_damping", "participation", "turn_participation", "initial_modal_displacement",
                                  "initial_modal_velocity"]},
    **{f"{what}_at_points": ("mode", "point") for what in ["shape", "slope", "moment", "shear"]},
    **{f"residual_{what}": ("point_too", "point") for what in ["flexibility", "moment", "shear"]},
    **{f"residual_{what}of_base": ("point",) for what in ["", "moment_", "shear_"]},
    "moving_mass": (),
}
COORDINATES = {name: (name,) for name in ["mode", "mode_before", "peak", "event", "stage", "time", "frequency"]}
COORDINATES |= {"point_position": ("point",), "profile_position": ("profile",)}
INPUTS = {
    "beam_length": 1.0,
    "beam_diameter": 0.037,
    "beam_density": 7870.0,
    "beam_youngs_modulus": 2e11,
    "rotation_angular_velocity": 50.0,
    "impact_mass_ratio": 0.2,
    "impact_position": 1.0,
    "impact_approach_velocity": 1.0,
    "impact_restitution": 0.0,
    "capture_rotary_inertia": 0.0,
    "impact_profile_points": 201,
    "modes_before": 12,
    "modes_after": 10,
    "response_duration": 1.0,
    "response_samples": 4096,
    "spectrum_max_peaks": 20,
    "spectrum_confidence": 0.95,
    "spectrum_false_alarm": 0.01,
}
OF_THE_PAPER = [*MODAL, *(f"{name}_before" for name in MODAL), "velocity_jump", "displacement"]
FULL = captured_beam(
    scene={"title": "all of it"},
    response={"duration": 1.0, "samples": 4096, "velocity": True},
    modes={"modal_model": True},
    spectrum={},
)


@pytest.fixture(scope="module")
def place(shared):
    """Results of every kind: one case, sweeps of one and two inputs, different numbers of modes."""
    place = shared("results")
    speeds = {"parameter": "rotation%angular_velocity", "values": [0.0, 50.0, 100.0, 150.0]}
    ratios = {"parameter": "impact%mass_ratio", "values": [0.2, 1.0]}
    counts = {"parameter": "modes%after", "values": [3, 7]}
    place.scene("full", FULL)
    place.scene("one", captured_beam(modes={"before": 6, "after": 6}), speeds)
    place.scene("two", captured_beam(), ratios, speeds)
    place.scene("counts", captured_beam(), counts)
    place.scene("rebound", captured_beam(capture=None, modes={"before": 5, "after": 5}))
    place.scene("plain", {"beam": captured_beam()["beam"]})
    place.beamwave("run", ".", "--quiet", status=0)
    return place


@pytest.fixture(scope="module")
def full(place):
    return place.result("full")


SWEPT = {"rotation_angular_velocity", "impact_mass_ratio", "modes_after"}
NAMES = ["full", "one", "two", "counts", "rebound", "plain"]


@pytest.mark.parametrize("name", NAMES)
def test_every_variable_has_units_and_a_name(place, name):
    for variable, (_, _, attributes) in place.result(name).variables.items():
        assert attributes["units"].strip(), variable
        assert attributes["long_name"].strip(), variable


@pytest.mark.parametrize("name", NAMES)
def test_no_number_is_nan_or_infinite_and_no_coordinate_is_fill(place, name):
    result = place.result(name)
    coordinates = {*COORDINATES, "case", *INPUTS}
    for variable, (_, values, attributes) in result.variables.items():
        if values.dtype.kind in "SU":
            continue  # letters
        assert np.isfinite(values).all(), variable
        assert ("_FillValue" in attributes) == (values.dtype == np.float64 and variable not in coordinates), variable
        if variable in coordinates:
            assert not results.is_fill(values).any(), variable
            assert np.all(values != -2147483647), variable  # NetCDF's fill of integers


def test_every_promised_variable_has_its_dimensions(full):
    for name, dimensions in {**DIMENSIONS, **COORDINATES}.items():
        assert full.variables[name].dimensions == dimensions, name
    for name in OF_THE_PAPER:
        assert re.search(r"(Eq\.|Eqs|Fig\.) \d", full.variables[name].attributes["references"]), name


def test_no_variable_is_there_that_was_not_promised(place):
    """Each has its row in docs/result.md, where `_before` and `_error` are said of several together, or is an input of the scene."""
    document = (PROJECT / "docs/result.md").read_text(encoding="utf-8")
    promised = {name for line in document.splitlines() if line.startswith("|") for name in re.findall(r"`(\w+)`", line)}
    for name in NAMES:
        result = place.result(name)
        inputs = {known.replace("%", "_") for known in names_in(result.attributes["scene"])}
        others = {name for name in result.variables if re.sub("_(before|error)$", "", name) not in promised and name not in promised}
        assert others <= inputs | SWEPT, name


def test_fill_stands_only_where_nothing_exists(full):
    for name in DIMENSIONS:
        filled = results.is_fill(full[name])
        if DIMENSIONS[name] == ("peak",):
            assert not filled[: full["peak_count"]].any() or "group" in name
            assert filled[full["peak_count"] :].all()
        else:
            assert not filled.any(), name


def test_every_number_of_the_scene_is_a_variable(full):
    for name, value in INPUTS.items():
        assert full.variables[name].dimensions == ()
        assert full[name] == value, name


STEPPED = {"length": [0.3, 0.7], "density": 7870.0, "youngs_modulus": [2e11, 2e10], "diameter": [0.04, 0.03]}
BODIES = ("body", {"position": 0.8, "mass_ratio": 0.2}), ("body", {"position": 1.0, "mass": 2.0})
ALONG_PIECES_AND_BODIES = {
    "beam_length": (("piece",), [0.3, 0.7]),
    "beam_density": ((), 7870.0),
    "body_position": (("body",), [0.8, 1.0]),
    "body_mass": (("body",), [results.FILL, 2.0]),
    "body_mass_ratio": (("body",), [0.2, results.FILL]),
    "piece": (("piece",), [1, 2]),
    "body": (("body",), [1, 2]),
}
WITH_A_ROW_FOR_EACH_CASE = {
    "beam_length": (("case", "piece"), [[0.5, 0.7], [0.6, 0.7], [0.7, 0.7]] * 2),
    "beam_length_1": (("case",), [0.5, 0.6, 0.7] * 2),
    "body_position": (("body",), [0.8, 1.0]),
    "body_mass": (("case", "body"), [[results.FILL, 1.0]] * 3 + [[results.FILL, 3.0]] * 3),
    "body_mass_2": (("case",), [1.0] * 3 + [3.0] * 3),
}


def test_inputs_lie_along_pieces_and_bodies_and_swept_ones_along_the_cases(here):
    """What a body does not say is fill, and what is the same of all pieces one number."""
    text = "".join(group_text(*group) for group in (("beam", STEPPED), *BODIES, ("modes", {"before": 2})))
    here.write("one.nml", text)
    sweeps = {"parameter": "body(2)%mass", "values": [1.0, 3.0]}, {"parameter": "beam%length(1)", "values": [0.5, 0.6, 0.7]}
    here.write("swept.nml", text + namelist({}, *sweeps))
    one, swept = here.run("one"), here.run("swept")
    for result, expected in ((one, ALONG_PIECES_AND_BODIES), (swept, WITH_A_ROW_FOR_EACH_CASE)):
        for name, (dimensions, values) in expected.items():
            assert (result.variables[name].dimensions, result[name].tolist()) == (dimensions, values), name
    assert one.variables["body_mass"].attributes["_FillValue"] == results.FILL
    assert "_FillValue" not in one.variables["body_position"].attributes
    assert "beam_length_2" not in swept.variables
    assert swept.variables["angular_frequency"].attributes["coordinates"] == "beam_length_1 body_mass_2"


def test_a_long_sweep_of_inputs_is_written_in_parts(here):
    """160 000 rows of two, more than are in memory at a time; they are there before the first case."""
    lengths = ({"parameter": f"beam%length({i})", "first": 1.0, "last": 400.0, "count": 400} for i in (1, 2))
    running = here.start("run", here.scene("a", {"beam": STEPPED, "modes": {"before": 1}}, *lengths))
    while not drafts_in(here.directory / "output/a.partial"):
        assert running.poll() is None
        time.sleep(0.01)
    running.terminate()
    running.communicate(timeout=SECONDS)
    with netCDF4.Dataset(here.directory / "output/a.partial/draft.nc") as draft:
        np.testing.assert_array_equal(draft["beam_length"], 1 + np.transpose(np.divmod(np.arange(160_000), 400)))


@pytest.mark.parametrize(("exponent", "swept", "unit"), [(1.0, [], "N m-1"), (2.0, [], "N m-2"), (1.5, [], "N"), (1.0, [1.0, 2.0], "N")])
def test_the_unit_of_a_contacts_stiffness_follows_its_exponent(here, exponent, swept, unit):
    """UDUNITS has no power of 1.5: the number is the force at 1 m."""
    scene = {"beam": PAPER_BEAM, "impact": {"mass": 1.0}, "contact": {"stiffness": 1e6, "exponent": exponent}, "modes": {"before": 2}}
    scene["response"] = {"duration": 1e-3, "samples": 2}
    sweeps = [{"parameter": "contact%exponent", "values": swept}] if swept else []
    assert here.simulate("a", scene, *sweeps).variables["contact_stiffness"].attributes["units"] == unit


def test_the_history_is_the_command_with_its_options(here):
    here.scene("set/a", captured_beam())
    here.beamwave("run", "set/a.nml", "--output", "it's here", "--overwrite", "--max-seconds=600", status=0)
    said = here.result("a", "it's here").attributes["history"].split(": ", 1)[1]
    assert said == "beamwave run set/a.nml --output 'it'\\''s here' --overwrite --max-seconds=600"
    here.beamwave("run", "set")
    assert here.result("a").attributes["history"].endswith(": beamwave run set (set/a.nml)")


def names_in(scene):
    """Every name of a resolved scene, as `group%name`."""
    names, group = set(), ""
    for line in scene.splitlines():
        group = line[1:] if line.startswith("&") else group
        names |= {f"{group}%{line.split('=')[0].strip()}"} if "=" in line else set()
    return names


def test_the_attributes_say_what_made_the_file(full):
    attributes = full.attributes
    assert attributes["Conventions"] == "CF-1.11"
    assert attributes["format_version"] == 2
    assert attributes["title"] == "all of it"
    assert attributes["effects"] == "rotation impact capture"
    assert attributes["method"] == "closed form"
    assert attributes["source"].startswith("beamwave ")
    assert "beamwave run" in attributes["history"]
    assert attributes["scene"].startswith("&scene")
    given = attributes["given"].split()
    assert len(set(given)) == len(given) and set(given) < names_in(attributes["scene"])
    assert {"scene%title", "beam%length", "response%velocity"} <= set(given)
    assert not {"impact%profile_points", "impact%restitution", "spectrum%window"} & set(given)
    for name in ["created", "notes", "compiler", "libraries"]:
        assert attributes[name].strip(), name


def test_flags_have_words(full):
    for name, word in {"case_status": "done", "event_kind": "impact", "stage": "modes"}.items():
        variable = full.variables[name]
        numbers = np.atleast_1d(variable.attributes["flag_values"]).tolist()
        words = variable.attributes["flag_meanings"].split()
        assert len(numbers) == len(words)
        assert words[numbers.index(np.atleast_1d(variable.values)[0])] == word


def test_the_axes_are_exact(full):
    samples = int(full["response_samples"])
    np.testing.assert_array_equal(full["time"], np.arange(samples) / samples)  # powers of two: exact
    np.testing.assert_array_equal(full["frequency"], np.arange(samples // 2 + 1))
    np.testing.assert_array_equal(full["point_position"], [0.5, 1.0])
    np.testing.assert_array_equal(full["profile_position"], np.arange(201) / 200)
    for name in ["mode", "mode_before", "peak", "event", "stage"]:
        np.testing.assert_array_equal(full[name], np.arange(1, full.sizes[name] + 1))


def test_wave_quantities_agree_with_each_other(full):
    beta, number = full["angular_frequency"], full["wavenumber"]
    # a quotient and a product of correctly rounded numbers are two roundings from each other
    np.testing.assert_allclose(full["phase_velocity"], beta / number, rtol=4e-16)
    np.testing.assert_allclose(full["alpha"], number * full["beam_length"], rtol=4e-16)
    np.testing.assert_array_equal(full["growth_rate"], 0.0)


def test_mode_shapes_are_orthogonal_over_beam_and_mass(full):
    shape, position = full["mode_shape"], full["profile_position"]
    products = simpson(shape[:, None] * shape, x=position) + full["impact_mass_ratio"] * np.outer(shape[:, -1], shape[:, -1])
    # Simpson's rule errs by about (2αh)⁴/180 of the highest mode, α = 29 and h = 1/200
    mass = full["beam_density"] * np.pi / 4 * full["beam_diameter"] ** 2 * full["beam_length"]
    np.testing.assert_allclose(products, np.diag(full["modal_mass"] / mass), atol=1e-4)


def test_mode_shapes_that_would_be_too_many_are_left_out(here):
    here.scene("few", {"beam": captured_beam()["beam"], "modes": {"before": 995}})
    here.scene("many", {"beam": captured_beam()["beam"], "modes": {"before": 996}})
    assert here.run("few")["mode_shape"].shape == (995, 201)
    assert not {"mode_shape", "profile_position"} & set(here.run("many").variables)


def test_what_was_not_asked_for_is_not_in_the_file(place):
    plain, rebound, one = (set(place.result(name).variables) for name in ["plain", "rebound", "one"])
    of_an_impact = ["velocity_jump", "impulse", "mass_velocity", "tip_velocity", "modal_velocity"]
    for name in [*EVENTS, *of_an_impact]:
        assert name not in plain
        assert name in rebound
    for name in [*(f"{name}_before" for name in MODAL), "mode_before", "critical_angular_velocity_before"]:
        assert name not in rebound
        assert name in one
    of_a_history = [
        "displacement",
        "velocity",
        "amplitude",
        "time",
        "frequency",
        "point_position",
        "peak",
        "peak_count",
    ]
    assert not {*of_a_history, *MEASURED} & one


def test_a_history_without_velocity_or_spectrum_has_neither(here):
    variables = set(here.simulate("a", captured_beam(response={"duration": 1.0, "samples": 64})).variables)
    assert "displacement" in variables
    assert not {"velocity", "amplitude", "frequency", "peak", "peak_count", *MEASURED} & variables


def test_waves_are_not_measured_without_both_points_and_the_notes_say_so(here):
    result = here.simulate("a", captured_beam(response={"duration": 1.0, "samples": 64, "points": [0.25, 1.0]}, spectrum={}))
    assert "amplitude" in result.variables
    assert not {"peak", "peak_count", *MEASURED} & set(result.variables)
    assert "0.5 and 1.0" in result.attributes["notes"]


def test_a_critical_speed_exists_where_a_mode_can_grow(here):
    for name, groups in [("out", {"rotation": {"plane": "out"}}), ("tension", {"stiffening": {}})]:
        result = here.simulate(name, captured_beam(**groups))
        assert results.is_fill(result["critical_angular_velocity"])
        assert results.is_fill(result["critical_angular_velocity_before"])
    assert "out of plane changes nothing" in here.result("out").attributes["notes"]


@pytest.mark.parametrize("name", NAMES)
def test_check_says_how_large_the_file_will_be(place, name):
    said = re.search(r"result +([\d.]+) ([kM])B", place.beamwave("check", f"{name}.nml").stdout)
    size = (place.directory / f"output/{name}.nc").stat().st_size
    # of names and attributes, which are most of a small file, variables are counted and not letters
    assert float(said[1]) * {"k": 1e3, "M": 1e6}[said[2]] == pytest.approx(size, rel=0.1)


def test_the_documented_xarray_idioms_work_on_real_results(place, tmp_path):
    idioms = [sys.executable, "-m", "pytest", "--quiet", "-k", "not readme", PROJECT / "postproc/tests/test_idioms.py"]
    ended = subprocess.run(
        [*idioms, "--results", place.directory / "output"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout
    assert "skipped" not in ended.stdout
