"""Words, symbols and units for axes and legends."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

# Symbols of the paper where it has one; an input without a symbol is written out.
INPUT_SYMBOLS = {
    "rotation_angular_velocity": r"$\omega$",
    "impact_mass_ratio": r"$\gamma$",
    "impact_mass": r"$m_j$",
    "impact_approach_velocity": "$V$",
    "impact_restitution": "$e$",
    "modes_before": "$n$",
    "modes_after": r"$\bar n$",
    "beam_length": "$l$",
    "beam_diameter": "$D$",
    "beam_density": r"$\rho$",
    "beam_youngs_modulus": "$E$",
    "beam_area": "$A$",
    "beam_second_moment": "$I$",
}

QUANTITIES = {
    "wavenumber": "Wave number $P$",
    "angular_frequency": r"Angular frequency $\beta$",
    "phase_velocity": "Phase velocity $C_p$",
    "group_velocity": "Group velocity $C_g$",
    "velocity_jump": r"Jump in velocity $\Delta\dot{v}$",
    "displacement": "Displacement $v$",
    "velocity": r"Velocity $\dot{v}$",
    "amplitude": "Amplitude",
    "time": "Time $t$",
    "frequency": "Frequency",
    "profile_position": r"Position along the beam $\xi = x/l$",
}

PREFIXES = (("", 1.0), ("m", 1e3), ("µ", 1e6), ("n", 1e9), ("p", 1e12))


def flag_words(variable: xr.DataArray) -> dict[int, str]:
    """CF flags of a variable: value to word, as it stands in the file."""
    words = str(variable.attrs.get("flag_meanings", "")).split()
    return {int(value): word for value, word in zip(np.atleast_1d(variable.attrs.get("flag_values", [])), words)}


def units_of(variable: xr.DataArray) -> str:
    """UDUNITS text of a variable's unit; '1' where it has none."""
    return str(variable.attrs.get("units", "1"))


def unit_text(units: str) -> str:
    """UDUNITS text as set on an axis: 'rad s-1' becomes rad s⁻¹, and '1' nothing."""
    if units == "1":
        return ""
    return re.sub(r"([A-Za-zµ]+)(-?\d+)", r"\1$^{\2}$", units)


def axis_label(variable: xr.DataArray, prefix: str = "") -> str:
    """Quantity and unit (with an SI `prefix`) of a variable, for an axis."""
    words = QUANTITIES.get(str(variable.name), str(variable.attrs.get("long_name", variable.name)))
    units = unit_text(prefix + units_of(variable))
    return words + (f" ({units})" if units else "")


def si_prefix(values: np.ndarray, units: str) -> tuple[str, float]:
    """SI prefix, and the factor to it, that suits the largest finite magnitude; none for compound `units`."""
    if units not in ("m", "s"):
        return PREFIXES[0]
    finite = np.abs(values[np.isfinite(values)])
    largest = finite.max() if finite.size else 0.0
    for prefix, factor in PREFIXES:
        if largest * factor >= 0.5:
            return prefix, factor
    return PREFIXES[0]


def rough(value: float) -> str:
    """Return a positive number to one digit, as a power of ten unless plain."""
    digit, power = f"{value:.0e}".split("e")
    if -2 <= int(power) <= 1:
        return f"{float(f'{value:.0e}'):g}"
    return rf"${digit}\times10^{{{int(power)}}}$"


def input_label(variable: xr.DataArray) -> str:
    """Symbol and unit of an input, for an axis."""
    name = str(variable.name)
    words = str(variable.attrs.get("long_name", name.replace("_", " ")))
    symbol = INPUT_SYMBOLS.get(name)
    units = unit_text(units_of(variable))
    words = words[:1].upper() + words[1:]
    return words + (f" {symbol}" if symbol else "") + (f" ({units})" if units else "")


def value_text(variable: xr.DataArray) -> str:
    """One scalar input as it stands in a legend: symbol = value unit."""
    name = str(variable.name)
    symbol = INPUT_SYMBOLS.get(name, name.replace("_", " "))
    units = unit_text(units_of(variable))
    return f"{symbol} = {float(variable):g}" + (f" {units}" if units else "")
