"""Inputs are named so that one cannot be taken for another."""

import pytest
import xarray as xr

from beamwave_postproc.parts.labels import value_text


@pytest.mark.parametrize(
    "name, read",
    [
        ("frequency_response_position", "position of the force = 0.2"),
        ("damping_ratio", "damping ratio = 0.2"),
        ("force_position", "force position = 0.2"),
        ("tip_support_stiffness", "stiffness of the tip's support = 0.2"),
        ("support_stiffness", "stiffness of the root = 0.2"),
        ("impact_mass_ratio", r"$\gamma$ = 0.2"),
        ("body_position_2", r"$\xi_2$ = 0.2"),
        ("body_mass_2", "body mass 2 = 0.2"),
    ],
)
def test_a_legend_names_an_input_by_its_symbol_or_with_its_group(name, read):
    assert value_text(xr.DataArray(0.2, name=name)) == read.replace(" = ", "\u00a0=\u00a0")
