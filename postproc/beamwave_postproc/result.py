"""A result file as an xarray dataset: opened, checked, and asked what it holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from .classic import needed_length
from .terminal import Refusal, reason

NOT_RUN = -1  # of `case_status`
RAN = "cases_that_ran"  # attribute of a draft
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
    if why := _why_cut_short(Path(path)):
        raise NotAResult(f"{path}: {why}")
    try:
        ds = xr.open_dataset(netcdf_path(Path(path)), engine="netcdf4")
    except Exception as failure:  # whatever xarray stumbles over
        raise NotAResult(f"{path}: not readable as NetCDF ({reason(failure)})") from failure
    why = _why_not_a_result(ds)
    if why:
        ds.close()
        raise NotAResult(f"{path}: {why}")
    return _of_cases_that_ran(_with_contact_unit(ds), str(path))


def _why_cut_short(path: Path) -> str:
    """That a file ends before what its header tells of; empty where it does not, or its library has to tell."""
    length = path.stat().st_size
    try:
        needed = needed_length(path) or 0
    except EOFError:
        return f"damaged, cut short: its header does not end within {length} bytes"
    except (OSError, KeyError, IndexError):
        return ""
    return f"damaged, cut short: {length} of {needed} bytes" if length < needed else ""


def _of_cases_that_ran(ds: xr.Dataset, path: str) -> xr.Dataset:
    """The draft of a sweep without the cases that have not run, which have no numbers yet; `RAN` says how many have."""
    if "case_status" not in ds or ds["case_status"].dims != ("case",):
        return ds
    ran = np.flatnonzero(ds["case_status"].values != NOT_RUN)
    if ran.size == ds.sizes["case"]:
        return ds
    if not ran.size:
        ds.close()
        raise NotAResult(f"{path}: none of its {ds.sizes['case']} cases has run yet")
    gapless = ran[-1] - ran[0] + 1 == ran.size
    some = ds.isel(case=slice(ran[0], ran[-1] + 1) if gapless else ran)
    some.set_close(ds.close)
    return some.assign_attrs({RAN: f"{ran.size} of {ds.sizes['case']} cases have run"})


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
        raise Refusal("NetCDF reads a backslash as a slash; accepted: a path without backslashes")
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
