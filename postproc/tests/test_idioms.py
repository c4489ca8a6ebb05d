"""What the documents show of xarray works: on synthetic results, and on real ones with --results DIR."""

import re
from pathlib import Path

import numpy as np
import pytest
import synthetic
import xarray as xr

from beamwave_postproc import open_result, swept_inputs, to_grid
from beamwave_postproc.run import find_program

README = Path(__file__).parents[1] / "README.md"


def first_with(results, holds, what):
    """Return the first result, opened, for which `holds(dataset)`; a directory without one fails the test."""
    for path in results:
        ds = xr.open_dataset(path)
        if holds(ds):
            return ds
        ds.close()
    pytest.fail(f"none of the results is {what}")


def test_a_result_opens_as_it_is(results):
    for path in results:
        with xr.open_dataset(path) as ds:
            assert ds.attrs["format_version"] == 2
            for name, variable in ds.variables.items():
                assert "units" in variable.attrs, f"{path.name}: {name}"
                assert "long_name" in variable.attrs, f"{path.name}: {name}"
            for name, coordinate in ds.coords.items():
                assert coordinate.notnull().all(), f"{path.name}: {name}"


def test_every_engine_reads_the_same(results):
    for path in results:
        with xr.open_dataset(path, engine="netcdf4") as one, xr.open_dataset(path, engine="scipy") as other:
            xr.testing.assert_identical(one, other)


def test_results_of_the_former_format_are_read(tmp_path, results):
    settings = synthetic.scene(modes={"before": 6, "after": 6})
    former, now = (synthetic.write(tmp_path / f"{version}.nc", settings, version=version) for version in (1, 2))
    with open_result(former) as one, open_result(now) as other:
        xr.testing.assert_equal(one, other)


def test_no_number_in_a_file_is_nan_or_infinite(results):
    for path in results:
        with xr.open_dataset(path, mask_and_scale=False) as ds:
            for name, variable in ds.variables.items():
                if variable.dtype.kind in "iuf":
                    assert np.isfinite(variable.values).all(), f"{path.name}: {name}"


def test_selecting_by_mode_counts_from_one(results):
    ds = first_with(results, lambda ds: "angular_frequency" in ds, "with modes")
    xr.testing.assert_equal(ds["angular_frequency"].sel(mode=1), ds["angular_frequency"].isel(mode=0))
    assert ds["mode"].values.tolist() == list(range(1, ds.sizes["mode"] + 1))


def test_selecting_by_swept_value_gives_its_case(results):
    ds = first_with(results, lambda ds: len(swept_inputs(ds)) == 1, "a sweep of one input")
    (name,) = swept_inputs(ds)
    for case, value in enumerate(ds[name].values):
        chosen = ds.swap_dims(case=name)["wavenumber"].sel({name: value}, method="nearest")
        np.testing.assert_array_equal(chosen, ds["wavenumber"].isel(case=case))


def test_unstacking_a_sweep_gives_a_grid(results):
    ds = first_with(results, lambda ds: len(swept_inputs(ds)) == 2, "a sweep of two inputs")
    names = swept_inputs(ds)
    grid = ds.set_index(case=names).unstack("case")
    assert grid.sizes[names[0]] * grid.sizes[names[1]] == ds.sizes["case"]
    for case in range(ds.sizes["case"]):
        point = {name: ds[name].values[case] for name in names}
        np.testing.assert_array_equal(grid["wavenumber"].sel(point), ds["wavenumber"].isel(case=case))
    xr.testing.assert_equal(grid["wavenumber"], to_grid(ds)["wavenumber"])


def test_concatenating_files_keeps_every_mode_under_its_number(results):
    runs = []
    for path in results:
        with xr.open_dataset(path) as ds:
            first = ds.isel(case=0) if "case" in ds.dims else ds
            runs.append(first[["wavenumber"]].reset_coords(drop=True).load())
    assert len({run.sizes["mode"] for run in runs}) > 1, "the results all have one number of modes"
    together = xr.concat(runs, dim="scene", join="outer")
    assert together.sizes["mode"] == max(run.sizes["mode"] for run in runs)
    for scene, run in enumerate(runs):
        kept = together["wavenumber"].isel(scene=scene).sel(mode=run["mode"])
        np.testing.assert_array_equal(kept, run["wavenumber"])


def program_is_there():
    """Whether the program is built, which README's blocks with `run` need."""
    try:
        return bool(find_program())
    except FileNotFoundError:
        return False


def test_the_readme_says_what_runs(tmp_path, monkeypatch, paper_results, grid_result):
    (tmp_path / "output").mkdir()
    (tmp_path / "input").symlink_to(README.parents[1] / "input")
    (tmp_path / "output/paper").symlink_to(paper_results)
    (tmp_path / "output/critical_speed.nc").symlink_to(grid_result)
    for name, modes in (("moving_beam", 4), ("spectrum", 9), ("waves", 6)):
        settings = synthetic.scene(modes={"before": modes, "after": modes})
        synthetic.write(tmp_path / f"output/{name}.nc", settings)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = {}
    for block in re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL):
        if " run(" not in block or program_is_there():
            exec(block, names)
    assert (tmp_path / "fig2.pdf").stat().st_size > 0 and (tmp_path / "tip_and_middle.png").stat().st_size > 0
    assert not program_is_there() or names["caught"].sizes["mode"] == 5
    assert names["fundamental"].dims == ("case",)
    assert float(names["at_50"].rotation_angular_velocity) == 50.0
    assert set(names["lowest"].dims) == {"rotation_angular_velocity"}
    assert names["runs"].sizes == {"scene": 3, "mode": 9}
    assert names["runs"]["wavenumber"].sel(scene="moving_beam").count() == 4


def test_every_result_that_the_readme_opens_is_one_that_its_commands_make():
    text = README.read_text(encoding="utf-8")
    scenes = README.parents[1] / "input"
    made = {path.stem for path in scenes.glob("**/*.nml") if f"input/{path.relative_to(scenes)}" in text}
    made |= {f"paper/{path.stem}" for path in scenes.glob("paper/*.nml")}  # by ./run.sh
    opened = set(re.findall(r"output/([\w/*]+)\.nc", text))
    assert opened and opened <= made
