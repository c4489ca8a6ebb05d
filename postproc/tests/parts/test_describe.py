"""Every picture says which scene, which effects and which inputs."""

import netCDF4
import pytest
import synthetic

from beamwave_postproc import dispersion, displacement, open_result
from beamwave_postproc.parts.describe import description_of, title_of, turns_out_of_plane
from beamwave_postproc.parts.labels import plain


def read(text):
    """Text as it is seen, in one line."""
    return plain(text).replace("\u00a0", " ").replace("\n", " ")


def test_the_head_names_scene_effects_inputs_and_file(full_result):
    with open_result(full_result) as ds:
        texts = read(" ".join(text.get_text() for text in dispersion(ds).texts))
    for word in ("synthetic", "l = 1 m", "D = 37 mm", "ρ = 7870 kg/m³", "E = 200 GPa", "rotation ω = 50 rad/s"):
        assert word in texts
    assert "impact γ = 0.2, V = 1 m/s" in texts and "capture; 40 modes before, 40 after; struck.nc" in texts
    assert "e = 0" not in texts and "rotary" not in texts  # what is left at nothing is not told


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
    assert "nan" not in texts[0] and "inertia" not in texts[0] and "; 7 bodies;" in texts[1]


def test_the_pieces_of_a_beam_are_told_in_their_order(full_result):
    with open_result(full_result) as ds:
        pieces = ds.assign(beam_length=("piece", [0.7, 0.3], {"units": "m"}))
        assert "beam l = 0.7, 0.3 m, D = 37 mm" in read(description_of(pieces))
        alike = ds.assign(beam_length=("piece", [0.5, 0.5], {"units": "m"}))
        assert "beam l = 0.5, 0.5 m, D = 37 mm" in read(description_of(alike))
