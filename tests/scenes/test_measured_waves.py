"""Waves measured in two histories alone meet the closed form within the bounds that the result gives."""

import re

import numpy as np
import pytest
import results
from closed_form import CapturedBeam
from conftest import PROJECT

MODES = 10
ACCURACY = {"angular_frequency": 1e-10, "wavenumber": 1e-8, "phase_velocity": 1e-8, "group_velocity": 1e-6}


@pytest.fixture(scope="module")
def measured(shared):
    """The result of the spectrum scene."""
    place = shared("measured")
    place.beamwave("run", PROJECT / "input/spectrum.nml", status=0)
    return place.result("spectrum")


@pytest.fixture(scope="module")
def true():
    """Eqs 19, 30, 32 and 33 at the paper's data."""
    beam = CapturedBeam(0.2, 50.0, before=40, after=40)
    return {
        "angular_frequency": beam.frequency(beam.alpha),
        "wavenumber": beam.alpha,
        "phase_velocity": beam.phase_velocity(beam.alpha),
        "group_velocity": beam.group_velocity(beam.alpha),
    }


@pytest.mark.parametrize("name", ACCURACY)
def test_the_first_ten_modes_are_measured(measured, true, name):
    np.testing.assert_allclose(measured[f"measured_{name}"][:MODES], true[name][:MODES], rtol=ACCURACY[name])


@pytest.mark.parametrize("name", ACCURACY)
def test_no_bound_is_below_its_true_error(measured, true, name):
    count = int(measured["peak_count"])
    value, bound = measured[f"measured_{name}"][:count], measured[f"measured_{name}_error"][:count]
    there = ~results.is_fill(value)
    assert there[:MODES].all()
    np.testing.assert_array_equal(results.is_fill(bound), ~there)
    rounding = 4e-15 * true[name][:count]  # of the reference, in doubles
    assert (np.abs(value - true[name][:count]) <= bound + rounding)[there].all()
    assert (bound[there] < 1e-3 * value[there]).all()  # and each says something


def test_no_folded_line_is_taken_for_a_mode(measured, true):
    count = int(measured["peak_count"])
    assert MODES <= count <= 21  # from mode 22 on they are above half the sampling rate
    found, modes = measured["measured_angular_frequency"][:count], true["angular_frequency"][:count]
    np.testing.assert_allclose(found, modes, rtol=1e-9)


def test_the_notes_list_the_folded_modes(measured):
    notes = measured.attributes["notes"]
    listed = re.search(r"left out of the measured peaks: modes ([\d, to.]+).*, aliased from above half the sampling", notes)[1]
    folded = [int(number) for number in re.findall(r"\d+", listed)]
    assert min(folded) == 22
    assert set(folded) <= set(range(22, 41))


def test_the_spectrum_peaks_where_the_modes_are(measured, true):
    amplitude = measured["amplitude"][1]
    for beta in true["angular_frequency"][:5]:
        line = round(beta / (2 * np.pi))  # 1 Hz apart
        assert amplitude[line - 1 : line + 2].max() == amplitude[line - 10 : line + 11].max()
