"""Units as they are read: quotients, prefixes, numbers in words."""

import numpy as np
import pytest

from beamwave_postproc.parts.units import number_text, si_prefix, unit_text, with_unit


@pytest.mark.parametrize(
    "udunits, read",
    [
        ("1", ""),
        ("m", "m"),
        ("rad s-1", "rad/s"),
        ("kg m-3", "kg/m³"),
        ("m-1", "1/m"),
        ("N m rad-1", "N m/rad"),
        ("m2 s-1", "m²/s"),
        ("J kg-1 K-1", "J/(kg K)"),
        ("N m-1.5", "N/m¹·⁵"),
    ],
)
def test_units_are_quotients(udunits, read):
    assert unit_text(udunits) == read


def test_a_prefix_suits_the_largest_number_of_a_unit_that_takes_one():
    assert si_prefix(np.array([1e-4, -0.03, np.nan]), "m") == ("m", 1e3)
    assert si_prefix(np.array([2e11]), "Pa")[0] == "G"
    assert [si_prefix(np.array([size]), "Hz")[0] for size in (549.0, 1000.0)] == ["", "k"]
    assert [si_prefix(np.array([size]), "m")[0] for size in (0.49, 0.5, 600.0)] == ["m", "", ""]
    assert si_prefix(np.array([0.03]), "m s-1") == ("", 1.0)
    assert si_prefix(np.array([]), "m") == ("", 1.0)


def test_numbers_in_words_do_not_break_and_have_no_power_of_ten_where_none_is_needed():
    assert with_unit(0.037, "m") == "37\u00a0mm"
    assert with_unit(7870.0, "kg m-3") == "7870\u00a0kg/m³"
    assert with_unit(3.1e-4, "s", 2) == "310\u00a0µs"
    assert with_unit(0.2, "1") == "0.2"
    assert with_unit(17420.0, "Hz") == "17.42\u00a0kHz"
    assert with_unit(9e-5, "m2") == "9e-5\u00a0m²"


def test_powers_of_ten_are_as_in_the_report():
    numbers = {
        9e-5: "9e-5",
        1e-10: "1e-10",
        -2.345678e-7: "-2.346e-7",
        1.23456e20: "1.235e20",
        123456.0: "123500",
        2e6: "2e6",
    }
    for number, text in numbers.items():
        assert number_text(number) == text and float(text) == pytest.approx(number, rel=1e-3)
    assert number_text(np.nan) == "–"
