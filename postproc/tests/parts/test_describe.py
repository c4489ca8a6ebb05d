"""Every picture says which scene, which effects and which inputs."""

import netCDF4
import numpy as np
import pytest
import synthetic
import xarray as xr

from beamwave_postproc import dispersion, displacement, open_result
from beamwave_postproc.parts.describe import description_of, title_of, turns_out_of_plane
from beamwave_postproc.parts.labels import plain
from beamwave_postproc.parts.scene import groups_of


def read(text):
    """Text as it is seen, in one line."""
    return plain(text).replace("\u00a0", " ").replace("\n", " ")


def test_the_label_of_a_picture_names_scene_effects_inputs_and_file(full_result):
    with open_result(full_result) as ds:
        texts = read(dispersion(ds).get_label())
    for word in ("synthetic", "l = 1 m", "D = 37 mm", "ρ = 7870 kg/m³", "E = 200 GPa", "rotation ω = 50 rad/s"):
        assert word in texts
    assert "impact γ = 0.2, V = 1 m/s" in texts and "capture; 40 modes before, 40 after; response" in texts
    assert "response duration = 1 s, samples = 16384, velocity; spectrum max peaks = 10; struck.nc" in texts
    assert "e = 0" not in texts and "rotary" not in texts  # what is left at nothing is not told


def test_the_head_has_two_lines_of_the_scene_its_file_and_beam_first(full_result):
    with open_result(full_result) as ds:
        title, scene, *_ = (read(text.get_text()) for text in dispersion(ds).texts)
    assert title == "synthetic" and scene.endswith("max peaks = 10; …")
    assert scene.startswith("struck.nc; beam l = 1 m") and "rotation ω = 50 rad/s; impact γ = 0.2, V = 1 m/s; capture" in scene


def test_forces_and_times_of_events_are_no_inputs(full_result):
    with open_result(full_result) as ds:
        found = ds.assign(impact_force_error=("event", np.ones(ds.sizes["event"]), {"units": "N"}))
        assert "force error" not in description_of(found)


def test_the_turn_of_a_hub_is_no_input(full_result):
    with open_result(full_result) as ds:
        turned = ds.assign_attrs(effects=f"hub {ds.attrs['effects']}").assign(
            hub_angle=("time", np.ones(ds.sizes["time"]), {"units": "rad"}), hub_radius=((), 0.3, {"units": "m"})
        )
        assert "radius" in description_of(turned) and "angle" not in description_of(turned)


def test_a_swept_input_is_told_by_its_values_or_their_range(paper_results, grid_result):
    with open_result(paper_results / "fig6.nc") as ds:
        assert "rotation ω = 0, 50, 100 rad/s;" in read(description_of(ds))
    with open_result(grid_result) as ds:
        assert "ω from 0 to 150 rad/s (16 values)" in read(description_of(ds))


def test_a_scene_without_a_title_is_called_by_its_file(tmp_path):
    path = synthetic.write(tmp_path / "untitled.nc", synthetic.scene(), title="")
    with open_result(path) as ds:
        assert title_of(ds) == "untitled"
        assert title_of(ds.assign_attrs(title="  ")) == "untitled"


def test_dollars_of_a_title_begin_no_formula(full_result):
    with open_result(full_result) as ds:
        for title in ("costs $5", r"from $\frac to $6", "a_b^c"):
            fig = dispersion(ds.assign_attrs(title=title))
            fig.draw_without_rendering()
            assert fig.texts[0].get_text() == title


@pytest.mark.parametrize("plane", ["out", "in"])
def test_the_plane_of_rotation_is_told(tmp_path, plane):
    path = synthetic.write(tmp_path / "plane.nc", synthetic.scene(rotation={"angular_velocity": 5.0}))
    with netCDF4.Dataset(path, "a") as file:
        file.scene = f"&rotation\n  PLANE = '{plane}'\n/\n"
    with open_result(path) as ds:
        assert turns_out_of_plane(ds) == (plane == "out")
        assert ("out of plane" if plane == "out" else "in plane") in description_of(ds)


def test_axes_of_the_caller_get_no_head(full_result):
    from matplotlib.figure import Figure

    fig = Figure()
    with open_result(full_result) as ds:
        assert displacement(ds, 1.0, ax=fig.subplots()) is fig
    assert not fig.texts and not fig.legends


def attached(ds, **inputs):
    """The result with bodies, whose inputs are lists."""
    units = {"mass": "kg", "stiffness": "N m-1"}
    variables = {
        f"body_{name}": ("body", list(values), {"units": units.get(name, "1")}) for name, values in inputs.items()
    }
    return ds.assign(variables).assign_attrs(effects=f"body {ds.attrs['effects']}")


def test_each_of_few_bodies_is_told_with_what_it_has(full_result):
    with open_result(full_result) as ds:
        two = attached(
            ds,
            position=[0.0, 0.75],
            mass=[0.2, float("nan")],
            mass_ratio=[float("nan"), 0.05],
            stiffness=[0.0, 10000.0],
            rotary_inertia=[0.0, 0.0],
        )
        many = attached(ds, position=[0.1 * i for i in range(1, 8)], mass=[0.1] * 7)
        texts = [read(description_of(both)) for both in (two, many)]
    assert "; body ξ = 0, mass = 0.2 kg; body ξ = 0.75, mass ratio = 0.05, stiffness = 10000 N/m; rotation" in texts[0]
    assert "nan" not in texts[0] and "inertia" not in texts[0]
    assert "; 7 bodies ξ = 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, mass = 0.1 kg;" in texts[1]


def test_the_pieces_of_a_beam_are_told_in_their_order(full_result):
    with open_result(full_result) as ds:
        pieces = ds.assign(beam_length=("piece", [0.7, 0.3], {"units": "m"}))
        assert "beam l = 0.7, 0.3 m, D = 37 mm" in read(description_of(pieces))
        alike = ds.assign(beam_length=("piece", [0.5, 0.5], {"units": "m"}))
        assert "beam l = 0.5, 0.5 m, D = 37 mm" in read(description_of(alike))


SCENE = """&scene
  title = 'it''s / a &title = 1'
/
&beam
  length = 1
/
&shear
  poisson_ratio = 0.3
  shear_coefficient = 0.9
/
&impact
  position = 1
  restitution = 0
  profile_points = 101
/
&modes
  before = 5
/
&response
  points = 0.1, 0.2,
    0.3
  velocity = .true.
  bending_moment = .false.
/
&record
  file = 'some/where/a.csv',
    'it''s.csv'
  scale = 2
/
&spectrum
  window = 'hann'
/
&identify
  parameter = 'beam%length'
  first = 1
/
&identify
  parameter = 'shear%poisson_ratio'
  first = 2
/
"""
TOLD = {
    "beam%length": "beam l = 1 m;", "shear%poisson_ratio": "poisson ratio = 0.3", "impact%position": "ξ₀ = 1",
    "shear%shear_coefficient": "shear coefficient = 0.9", "impact%restitution": "e = 0", "modes%before": "5 modes",
    "impact%profile_points": "profile points = 101", "response%points": "response ξ = 0.1, 0.2, 0.3",
    "response%velocity": ", velocity", "response%bending_moment": "no bending moment", "record%scale": "scale = 2",
    "record%file": "file a.csv, it's.csv", "spectrum%window": "spectrum window hann",
    "identify%parameter": "identify parameter beam%length, first = 1; identify parameter shear%poisson_ratio, first",
}  # fmt: skip
ALWAYS = {"beam%length", "shear%poisson_ratio", "modes%before"}  # by what they are


def resolved(given):
    """A result of `SCENE`, of which so much was given; the rest are defaults."""
    numbers = {"beam_length": 1.0, "shear_poisson_ratio": 0.3, "shear_shear_coefficient": 0.9, "impact_position": 1.0}
    numbers |= {"impact_restitution": 0.0, "impact_profile_points": 101, "modes_before": 5}
    ds = xr.Dataset(numbers, attrs={"scene": SCENE, "effects": "shear impact", "given": " ".join(given)})
    ds["beam_length"].attrs["units"] = "m"
    return ds.assign(identify_first=("unknown", [1.0, 2.0]), record_file=("case", [1, 2]))


@pytest.mark.parametrize("name", TOLD)
def test_nothing_that_was_given_is_left_out(name):
    text = read(description_of(resolved([*TOLD, "identify%first", "scene%title"])))
    assert TOLD[name] in text and "title" not in text
    without = read(description_of(resolved([one for one in TOLD if one != name])))
    assert (TOLD[name].rstrip(";") in without) == (name in ALWAYS)


@pytest.mark.parametrize("count", [8, 9, 200])
def test_the_middle_of_a_long_list_is_left_out_and_its_values_are_counted(count):
    lengths = xr.Dataset({"beam_length": ("piece", 0.1 * np.arange(1, count + 1), {"units": "m"})})
    text = read(description_of(lengths))
    whole = "beam l = 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8 m"
    assert text == (whole if count == 8 else f"{whole[:-12]}, …, {0.1 * count:.4g} m ({count} values)")


@pytest.mark.parametrize(
    "scene", ["", "&", "&beam", "a = 1", "&beam\n length = 'x", "&beam a = /", "&beam length = 1e999 '"]
)
def test_a_scene_that_is_none_is_told_as_far_as_it_goes(scene):
    ds = xr.Dataset(attrs={"scene": scene, "given": "beam%length beam%a", "effects": "impact"})
    assert [group.name for group in groups_of(ds)] == (["beam"] if "beam" in scene else [])
    assert "impact" in description_of(ds)
