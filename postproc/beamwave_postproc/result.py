"""A result file as an xarray dataset: opened, checked, and asked what it holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from .terminal import Refusal, reason

FORMAT_VERSIONS = (1, 2)  # NetCDF-4; classic NetCDF
DIMENSIONS = {
    *("case", "mode", "mode_before", "peak", "event", "stage", "time", "frequency", "point", "profile", "piece"),
    *("response_frequency", "junction", "body", "rung", "effect", "unknown", "unknown_too", "point_too"),
    *("contact_sample", "window", "candidate", "pooled", "quantile", "letter", "note_letter", "parameter_letter"),
}


class NotAResult(Refusal):
    """The file cannot be read, or was not written by beamwave."""


class NothingToDraw(Refusal):
    """The result does not hold what a picture needs."""


def open_result(path: str | Path) -> xr.Dataset:
    """Open the result at `path`, lazily; use it in a `with`, or close it.

    Raises `NotAResult`, naming the file and the reason.
    """
    if not Path(path).is_file():
        raise NotAResult(f"{path}: no such file")
    try:
        ds = xr.open_dataset(netcdf_path(Path(path)), engine="netcdf4")
    except Exception as failure:  # whatever xarray stumbles over
        raise NotAResult(f"{path}: not readable as NetCDF ({reason(failure)})") from failure
    why = _why_not_a_result(ds)
    if why:
        ds.close()
        raise NotAResult(f"{path}: {why}")
    return _with_contact_unit(ds)


def _with_contact_unit(ds: xr.Dataset) -> xr.Dataset:
    """K of F = Kδᵖ in N/mᵖ, where p is known: the file has the force at 1 m."""
    if "contact_stiffness" in ds and "contact_exponent" in ds:
        exponents = np.unique(ds["contact_exponent"].values)
        if exponents.size == 1 and np.isfinite(exponents[0]) and ds["contact_stiffness"].attrs.get("units") == "N":
            ds["contact_stiffness"].attrs["units"] = f"N m-{exponents[0]:g}"
    return ds


def netcdf_path(path: Path) -> str:
    """A path that NetCDF takes for what it is, and not for a place in the net; raises `Refusal` where it cannot."""
    if "\\" in str(path.absolute()):
        raise Refusal("NetCDF takes a backslash for a slash; accepted: a path without")
    return str(path.absolute())


def _why_not_a_result(ds: xr.Dataset) -> str:
    """Why `ds` is no result of beamwave that this package reads; empty when it is one."""
    if "format_version" not in ds.attrs or not str(ds.attrs.get("source", "")).startswith("beamwave"):
        return "not a beamwave result (no 'format_version', or 'source' is not beamwave)"
    if not any(np.array_equal(ds.attrs["format_version"], version) for version in FORMAT_VERSIONS):
        return f"format_version is {ds.attrs['format_version']}; this package reads {FORMAT_VERSIONS[0]} to {FORMAT_VERSIONS[-1]}"
    return ""


def require(ds: xr.Dataset, *names: str) -> None:
    """Raise `NothingToDraw` unless `ds` has every variable in `names`, along dimensions of a result."""
    absent = [name for name in names if name not in ds]
    if absent:
        raise NothingToDraw(f"the result holds no {', '.join(absent)}")
    for name in names:
        strange = [str(dim) for dim in ds[name].dims if dim not in DIMENSIONS]
        if strange:
            raise NothingToDraw(f"{name} has a dimension {strange[0]}: choose one of it first, with isel or sel")


def require_numbers(values: np.ndarray, name: str) -> None:
    """Raise `NothingToDraw` unless something in `values` is not fill (NaN once read)."""
    if not np.isfinite(values).any():
        raise NothingToDraw(f"{name} holds nothing but fill")


def swept_inputs(ds: xr.Dataset) -> list[str]:
    """Names of the inputs that a sweep varies, the slowest first; empty without a sweep."""
    names = [str(name) for name, values in ds.coords.items() if values.dims == ("case",) and name != "case"]
    return sorted(names, key=lambda name: np.count_nonzero(np.diff(ds[name].values)))


def to_grid(ds: xr.Dataset) -> xr.Dataset:
    """Replace `case` by one dimension per swept input, each with its values as coordinate."""
    names = swept_inputs(ds)
    if len(names) == 1:
        return ds.swap_dims(case=names[0]).drop_vars("case")
    return ds.set_index(case=names).unstack("case")
