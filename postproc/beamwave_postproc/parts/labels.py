"""Words and symbols for axes and legends."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

from .units import unit_text, units_of, with_unit

# Symbols of the paper where it has one; an input without a symbol is written out.
INPUT_SYMBOLS = {
    "rotation_angular_velocity": r"$\omega$",
    "impact_mass_ratio": r"$\gamma$",
    "impact_mass": "$m_j$",
    "impact_approach_velocity": "$V$",
    "impact_restitution": "$e$",
    "impact_position": r"$\xi_0$",
    "modes_before": "$n$",
    "modes_after": r"$\bar{n}$",
    "body_position": r"$\xi$",
    "response_points": r"$\xi$",
    "record_points": r"$\xi$",
    "beam_length": "$l$",
    "beam_diameter": "$D$",
    "beam_density": r"$\rho$",
    "beam_youngs_modulus": "$E$",
    "beam_area": "$A$",
    "beam_second_moment": "$I$",
    "contact_stiffness": "$K$",
    "contact_exponent": "$p$",
}
INPUT_WORDS = {
    "rotation_angular_velocity": "Angular velocity",
    "impact_mass_ratio": "Mass ratio",
    "impact_mass": "Mass that strikes",
    "beam_diameter": "Diameter",
    "impact_approach_velocity": "Approach velocity",
    "impact_position": "Place of the blow",
    "contact_stiffness": "Contact stiffness",
    "contact_exponent": "Exponent of the contact",
    "contact_damping": "Damping of the contact",
    "beam_length": "Length",
    "beam_youngs_modulus": "Young's modulus",
    "beam_density": "Density",
    "support_stiffness": "Stiffness of the root",
    "support_rotational_stiffness": "Rotational stiffness of the root",
    "tip_support_stiffness": "Stiffness of the tip's support",
    "tip_support_rotational_stiffness": "Rotational stiffness of the tip's support",
    "body_position": "Place",
    "body_stiffness": "Spring's stiffness",
    "body_rotational_stiffness": "Rotational spring's stiffness",
    "frequency_response_position": "Position of the force",
}
OWN = re.compile(r"(?:tip_support|frequency_response|[^_]+)_")  # the group before an input's own name
NUMBERED = re.compile(r"(.+)_(\d+)")  # a swept value of a list, or that of one of the bodies
QUANTITIES = {
    "wavenumber": "Wave number $P$",
    "angular_frequency": r"Angular frequency $\beta$",
    "phase_velocity": "Phase velocity $C_p$",
    "group_velocity": "Group velocity $C_g$",
    "growth_rate": "Growth rate",
    "velocity_jump": r"Jump in velocity $\Delta\dot{v}$",
    "displacement": "Displacement $v$",
    "velocity": r"Velocity $\dot{v}$",
    "acceleration": r"Acceleration $\ddot{v}$",
    "shear_force": "Shear force",
    "bending_moment": "Bending moment",
    "hub_angle": r"Turn of the hub $\theta$",
    "amplitude": "Amplitude",
    "event_impulse": "Impulse on the beam",
    "largest_displacement": "Largest displacement",
    "largest_stress": "Largest bending stress",
    "largest_contact_force": "Largest contact force",
    "largest_indentation": "Largest indentation",
    "restitution": "Restitution of the first contact",
    "final_mass_velocity": "Last velocity of the mass",
    "impulse": "Impulse on the beam",
    "critical_angular_velocity": "Critical angular velocity",
    "time": "Time $t$",
    "frequency": "Frequency",
    "response_frequency": "Frequency",
    "point_position": r"Position along the beam $\xi = x/l$",
    "profile_position": r"Position along the beam $\xi = x/l$",
}
MATHEMATICS = {r"\omega": "ω", r"\gamma": "γ", r"\xi": "ξ", r"\rho": "ρ", r"\bar{n}": "n̄", "_j": "ⱼ"}
MATHEMATICS |= {f"_{digit}": below for digit, below in zip("0123456789", "₀₁₂₃₄₅₆₇₈₉")}


def flag_words(variable: xr.DataArray) -> dict[int, str]:
    """CF flags of a variable: value to word, as it stands in the file."""
    words = str(variable.attrs.get("flag_meanings", "")).split()
    return {int(value): word for value, word in zip(np.atleast_1d(variable.attrs.get("flag_values", [])), words)}


def how_it_ended(case: xr.Dataset) -> str:
    """How a case ended, in brackets, where that was not well."""
    if "case_status" not in case:
        return ""
    word = flag_words(case["case_status"]).get(int(case["case_status"]), "done").replace("_", " ")
    return "" if word == "done" else f" ({word})"


def axis_label(variable: xr.DataArray, prefix: str = "") -> str:
    """Quantity and unit (with an SI `prefix`) of a variable, for an axis."""
    return quantity(variable) + in_units(variable, prefix)


def quantity(variable: xr.DataArray) -> str:
    """What a variable is, in words and with its symbol."""
    return QUANTITIES.get(str(variable.name), str(variable.attrs.get("long_name", variable.name)))


def in_units(variable: xr.DataArray, prefix: str = "") -> str:
    """Unit of a variable (with an SI `prefix`) in brackets after a blank; empty where it has none."""
    units = unit_text(prefix + units_of(variable))
    return f" ({units})" if units else ""


def symbol_of(name: str) -> str:
    """Symbol of an input, or its own name behind that of its group, in words; with its number where it is one of several."""
    one = NUMBERED.fullmatch(name)
    if one and one[1] in INPUT_SYMBOLS and int(one[2]) < 10:
        return INPUT_SYMBOLS[one[1]].rstrip("$") + f"_{one[2]}$"
    return INPUT_SYMBOLS.get(name, OWN.sub("", name, count=1).replace("_", " "))


def input_name(name: str) -> str:
    """Symbol of an input, or what it is in words, where its group is not named."""
    symbol = symbol_of(name)
    words = INPUT_WORDS.get(name, name.replace("_", " "))
    return symbol if "$" in symbol else words[:1].lower() + words[1:]


def input_label(variable: xr.DataArray, prefix: str = "") -> str:
    """Words, symbol and unit (with an SI `prefix`) of an input, for an axis."""
    name = str(variable.name)
    meaning, _, which = str(variable.attrs.get("long_name", name.replace("_", " "))).partition("; ")
    words = INPUT_WORDS.get(NUMBERED.sub(r"\1", name), meaning)
    symbol = symbol_of(name)
    parts = [words[:1].upper() + words[1:], f"of {which}" if which else "", symbol if "$" in symbol else ""]
    return " ".join(filter(None, parts)) + in_units(variable, prefix)


def input_words(name: str) -> str:
    """What an input is in few words, with its symbol."""
    words, symbol = INPUT_WORDS.get(name, name.replace("_", " ")), symbol_of(name)
    return words[:1].upper() + words[1:] + (f" {symbol}" if "$" in symbol else "")


def value_text(variable: xr.DataArray, digits: int = 4, name: str = "", among: np.ndarray | None = None) -> str:
    """One scalar input as it stands in a legend: symbol, words or `name` = value unit, without a blank before or after the sign.

    The SI prefix is the one that suits all values `among` which it stands.
    """
    value = with_unit(float(variable), units_of(variable), digits, among)
    return f"{name or input_name(str(variable.name))}\u00a0=\u00a0{value}"


def plain(text: str) -> str:
    """Text with its formulas in letters, for where none are set: heads of figures, HTML."""
    return re.sub(r"\$([^$]*)\$", lambda formula: _letters(formula.group(1)), text)


def _letters(formula: str) -> str:
    for markup, letter in MATHEMATICS.items():
        formula = formula.replace(markup, letter)
    return formula
