"""NetCDF files as the program writes them, with numbers from `model`."""

import itertools

import model
import netCDF4
import numpy as np

FILL = 9.969209968386869e36  # NetCDF's own for doubles
PAPER_BEAM = {"length": 1.0, "diameter": 0.037, "density": 7870.0, "youngs_modulus": 2e11}
PAPER = {
    "beam": PAPER_BEAM,
    "rotation": {"angular_velocity": 0.0},
    "impact": {"mass_ratio": 0.2, "approach_velocity": 1.0, "restitution": 0.0, "profile_points": 201},
    "capture": {"rotary_inertia": 0.0},
    "modes": {"before": 20, "after": 20},
}
DEFAULTS = {"approach_velocity": 1.0, "restitution": 0.0, "profile_points": 201, "rotary_inertia": 0.0}
UNITS = {
    "length": "m",
    "diameter": "m",
    "density": "kg m-3",
    "youngs_modulus": "Pa",
    "angular_velocity": "rad s-1",
    "approach_velocity": "m s-1",
    "duration": "s",
    "response_duration": "s",
    "wavenumber": "m-1",
    "angular_frequency": "rad s-1",
    "growth_rate": "s-1",
    "phase_velocity": "m s-1",
    "group_velocity": "m s-1",
    "velocity_jump": "m s-1",
    "modal_velocity": "m s-1",
    "modal_mass": "kg",
    "displacement": "m",
    "bending_moment": "N m",
    "event_end": "s",
    "event_impulse": "N s",
    "critical_angular_velocity": "rad s-1",
    "velocity": "m s-1",
    "amplitude": "m",
    "time": "s",
    "frequency": "Hz",
    "event_time": "s",
}


def scene(**groups):
    """Return the paper's scene with `groups` (dicts) merged in; a group given as None is left out."""
    merged = {name: dict(values) for name, values in PAPER.items()}
    if groups.get("impact", {}) is None:
        groups["capture"] = None
    for name, values in groups.items():
        if values is None:
            merged.pop(name, None)
        else:
            merged.setdefault(name, {}).update(values)
    return merged


FORMATS = {1: "NETCDF4", 2: "NETCDF3_64BIT_OFFSET"}  # by format_version


def write(path, settings, sweep=None, title="synthetic", version=2):
    """Write the result of `settings` at `path`; `sweep` maps 'group_name' to values, the first varying slowest."""
    sweep = sweep or {}
    cases = []
    for values in itertools.product(*sweep.values()):
        cases.append({name: dict(group) for name, group in settings.items()})
        for name, value in zip(sweep, values):
            group, _, item = name.partition("_")
            cases[-1][group][item] = value
    axes = _axes(settings)
    solved = [_solve(case, axes) for case in cases]
    with netCDF4.Dataset(path, "w", format=FORMATS[version]) as file:
        file.format_version = np.int32(version)
        _write_attributes(file, settings, title)
        _write_axes(file, axes, solved, len(cases) if sweep else 0)
        _write_inputs(file, cases, list(sweep))
        _write_data(file, solved, list(sweep))
    return path


def _axes(settings):
    """Coordinates that the scene sets: profile, and with a response points, time and frequency."""
    axes = {"profile": np.linspace(0, 1, settings["impact"]["profile_points"])} if "impact" in settings else {}
    if "response" in settings:
        response = settings["response"]
        count = response["samples"]
        axes["point"] = np.atleast_1d(np.array(response.get("points", [0.5, 1.0]), dtype=float))
        axes["time"] = np.arange(count) * response["duration"] / count
        if "spectrum" in settings:
            axes["frequency"] = np.arange(count // 2 + 1) / response["duration"]
    return axes


def _solve(case, axes):
    """All variables of one case: name to (dimensions, array)."""
    count, omega = case["modes"]["after"], case["rotation"]["angular_velocity"]
    struck = "impact" in case
    gamma = case["impact"]["mass_ratio"] if struck else 0.0
    found = {name: (("mode",), v) for name, v in model.modes(count, gamma, omega, case["beam"]).items()}
    found["mode_count"] = ((), count)
    if not struck:
        return found
    before = case["modes"]["before"]
    jump = model.impact(before, gamma, case["impact"]["restitution"], case["impact"]["approach_velocity"])
    start, mass = model.capture(found["alpha"][1], jump, gamma)
    for name, values in model.modes(before, 0.0, omega, case["beam"]).items():
        found[f"{name}_before"] = (("mode_before",), values)
    found["modal_velocity_before"] = (("mode_before",), jump)
    found["modal_velocity"] = (("mode",), start)
    beam = case["beam"]
    beam_mass = beam["density"] * np.pi / 4 * beam["diameter"] ** 2 * beam["length"]
    found["modal_mass"] = (("mode",), mass * beam_mass)
    found["velocity_jump"] = (("profile",), jump @ model.shapes(model.roots(before, 0.0), axes["profile"]))
    found["mode_shape"] = (("mode", "profile"), model.shapes(found["alpha"][1], axes["profile"]))
    elastic = model.bending_constant(beam) * (found["alpha"][1] / beam["length"]) ** 2
    found["critical_angular_velocity"] = ((), elastic[0])
    for name, values in (("time", [0.0, 0.0]), ("end", [0.0, 0.0]), ("impulse", [jump[0], 0.0])):
        found[f"event_{name}"] = (("event",), np.array(values))
    found["event_kind"] = (("event",), np.array([1, 2]))
    if "time" in axes:
        found.update(_respond(case, axes, found["alpha"][1], start))
    if "frequency" in axes:
        found.update(_measure(case, axes, found))
    return found


def _respond(case, axes, alpha, start):
    """Histories at the points."""
    h, omega = model.bending_constant(case["beam"]), case["rotation"]["angular_velocity"]
    beta2 = (h * (alpha / case["beam"]["length"]) ** 2) ** 2 - omega**2
    displacement, velocity, curvature = model.histories(alpha, beta2, start, axes["point"], axes["time"])
    found = {"displacement": (("point", "time"), displacement)}
    if case["response"].get("velocity"):
        found["velocity"] = (("point", "time"), velocity)
    if case["response"].get("bending_moment"):
        beam = case["beam"]
        stiffness = beam["youngs_modulus"] * np.pi / 64 * beam["diameter"] ** 4
        found["bending_moment"] = (("point", "time"), stiffness / beam["length"] ** 2 * curvature)
    return found


def _measure(case, axes, found):
    """Spectrum (Hann) of the displacement, and measured quantities: the computed ones off by less than their bounds."""
    history = found["displacement"][1]
    window = np.hanning(history.shape[1] + 1)[:-1]
    amplitude = 2 * np.abs(np.fft.rfft(history * window)) / window.sum()
    measured = {"amplitude": (("point", "frequency"), amplitude)}
    peaks = min(case["spectrum"]["max_peaks"], case["modes"]["after"])
    slip = np.cos(np.arange(peaks))  # stands for the error of a measurement
    for name, size in (
        ("angular_frequency", 1e-12),
        ("wavenumber", 1e-10),
        ("phase_velocity", 1e-10),
        ("group_velocity", 1e-8),
    ):
        exact = found[name][1][:peaks]
        measured[f"measured_{name}"] = (("peak",), exact * (1 + size * slip))
        measured[f"measured_{name}_error"] = (("peak",), 3 * size * exact)
    measured["peak_count"] = ((), peaks)
    return measured


def _write_attributes(file, settings, title):
    file.Conventions = "CF-1.11"
    file.title = title
    file.source = "beamwave (synthetic)"
    file.method = "closed form"
    file.effects = " ".join(name for name in settings if name not in ("beam", "modes", "response", "spectrum"))
    file.given = " ".join(
        f"{group}%{name}"
        for group, values in settings.items()
        for name, value in values.items()
        if np.any(value != DEFAULTS.get(name))
    )
    file.scene = "".join(
        f"&{group}\n" + "".join(f"  {name} = {_value(v)}\n" for name, v in values.items()) + "/\n"
        for group, values in settings.items()
    )


def _value(value):
    """Numbers, or a logical value, as the program writes them."""
    return f".{value}.".lower() if isinstance(value, bool) else ", ".join(map(str, np.atleast_1d(value).tolist()))


def _write_axes(file, axes, solved, cases):
    """Dimensions and coordinate variables; those of a count (mode, peak, …) run from 1."""
    counted = {}
    for found in solved:
        for dims, values in found.values():
            for dim, size in zip(dims, np.shape(values)):
                counted[dim] = max(size, counted.get(dim, 0))
    if cases:
        counted["case"] = cases
    for dim in counted:
        file.createDimension(dim, axes[dim].size if dim in axes else counted[dim])
        if dim in axes:
            name = f"{dim}_position" if dim in ("point", "profile") else dim
            values, kind = axes[dim], "f8"
        else:
            name, values, kind = dim, np.arange(1, counted[dim] + 1), "i4"
        _variable(file, name, kind, (dim,))[:] = values


def _write_inputs(file, cases, swept):
    """Every numeric input of the scene: (case) where swept, else a scalar."""
    for group, values in cases[0].items():
        for item in values:
            name = f"{group}_{item}"
            if np.ndim(values[item]) or isinstance(values[item], (str, bool)):
                continue
            kind = "i4" if isinstance(values[item], int) else "f8"
            variable = _variable(file, name, kind, ("case",) if name in swept else ())
            variable[...] = [case[group][item] for case in cases] if name in swept else values[item]


def _write_data(file, solved, swept):
    """Data variables: the cases stacked, shorter ones filled up."""
    for name, (dims, first) in solved[0].items():
        whole = np.issubdtype(np.asarray(first).dtype, np.integer)
        shape = tuple(file.dimensions[dim].size for dim in dims)
        fill = -2147483647 if whole else FILL
        stacked = np.full((len(solved), *shape), fill, dtype="i4" if whole else "f8")
        for case, found in enumerate(solved):
            values = np.asarray(found[name][1])
            stacked[(case, *map(slice, values.shape))] = np.where(np.isnan(values), fill, values)
        variable = _variable(file, name, stacked.dtype, (("case", *dims) if swept else dims), fill)
        auxiliary = [*swept, *(f"{dim}_position" for dim in dims if dim in ("point", "profile"))]
        if auxiliary:
            variable.coordinates = " ".join(auxiliary)
        variable[...] = stacked if swept else stacked[0]


def _variable(file, name, kind, dims, fill=None):
    variable = file.createVariable(name, kind, dims, fill_value=fill)
    item = name.split("_", 1)[-1] if name.split("_")[0] in PAPER else name
    plain = item.removesuffix("_error").removesuffix("_before").removeprefix("measured_")
    variable.units = UNITS.get(plain, "1")
    variable.long_name = name.replace("_", " ")
    if name == "event_kind":
        variable.flag_values = np.array([0, 1, 2, 3, 4], dtype="i4")
        variable.flag_meanings = "none impact capture release contact"
    return variable
