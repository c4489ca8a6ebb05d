"""Which modes move in the samples: after a release those of the beam alone."""

import numpy as np
import pytest
import synthetic

from beamwave_postproc import NothingToDraw, measured, open_result, spectrogram, wavenumber_spectrum
from beamwave_postproc.draw.measured import QUANTITIES
from beamwave_postproc.parts.moving import last_modes, sampled_frequencies
from beamwave_postproc.parts.passage import highest_frequency

RELEASE = 3.0


def with_release(ds, time=0.05):
    """The result with a release, and with peaks that are the modes of the beam alone, exactly."""
    attributes = {**ds["event_kind"].attrs}
    if "flag_meanings" in attributes and "release" not in attributes["flag_meanings"]:
        attributes.update(flag_values=[0, 1, 2, 3], flag_meanings="none impact capture release")
    events = {
        "event_time": ("event", [0.0, 0.0, time]),
        "event_end": ("event", [0.0, 0.0, time]),
        "event_kind": ("event", [1.0, 2.0, RELEASE], attributes),
    }
    names = [name for name in QUANTITIES if f"measured_{name}" in ds]
    peaks = {f"measured_{name}": ("peak", ds[f"{name}_before"].values[:10]) for name in names}
    return ds.drop_vars(["event", *events, "event_impulse"], errors="ignore").assign({**events, **peaks})


def without_alone(ds):
    """As with a tolerance: the file holds the modes with the mass only."""
    return ds.drop_vars([name for name in ds.variables if str(name).endswith("_before")])


@pytest.mark.parametrize("name", QUANTITIES)
def test_peaks_after_a_release_are_compared_with_the_modes_of_the_beam_alone(full_result, name):
    with open_result(full_result) as ds:
        fig = measured(with_release(ds), name)
        bound, difference = fig.axes[1].lines
    np.testing.assert_array_equal(difference.get_xdata(), np.arange(1, 11))
    # A frequency goes through Hz, in one product on both sides: what is left is the place that stands for zero.
    assert difference.get_ydata().max() < 1e-15 and (difference.get_ydata() <= bound.get_ydata()).all()
    assert any("after the release, computed for the beam alone" in text.get_text() for text in fig.texts)


def test_peaks_after_a_release_without_the_modes_of_the_beam_alone_are_refused(full_result):
    with open_result(full_result) as ds:
        released = without_alone(with_release(ds))
        for name in QUANTITIES:
            with pytest.raises(NothingToDraw, match="after the release"):
                measured(released, name)
        measured(without_alone(ds), "wavenumber")


def test_a_release_that_the_record_does_not_reach_changes_nothing(full_result):
    with open_result(full_result) as ds:
        last = last_modes(with_release(ds, np.nan))
        np.testing.assert_array_equal(last["angular_frequency"], ds["angular_frequency"])


def test_the_highest_frequency_is_of_all_modes_that_move(full_result):
    with open_result(full_result) as ds:
        few = with_release(ds.isel(mode=slice(5), mode_before=slice(10))).assign(mode_count=5)
        alone = few["angular_frequency_before"].values / (2 * np.pi)
        assert highest_frequency(few) == sampled_frequencies(few)[-1] == alone[-1]
        assert sampled_frequencies(few).size == 15
        assert highest_frequency(few.assign(event_kind=few["event_kind"].where(few["event"] < 2))) < alone[-1]


def test_images_of_a_released_beam_have_the_modes_of_both_parts(tmp_path):
    points = [round(0.05 * i, 2) for i in range(1, 21)]
    settings = synthetic.scene(response={"duration": 0.05, "samples": 4096, "points": points})
    with open_result(synthetic.write(tmp_path / "whole.nc", settings)) as ds:
        axes = wavenumber_spectrum(with_release(ds, 0.01)).axes[0]
        labels = {line.get_label(): line for line in axes.lines}
        left, right = axes.images[0].get_extent()[:2]
        assert left <= axes.get_xlim()[0] and axes.get_xlim()[1] <= right
        np.testing.assert_array_equal(labels["modes with the mass"].get_xdata(), ds["wavenumber"])
        np.testing.assert_array_equal(labels["modes after the release"].get_xdata(), ds["wavenumber_before"])
        assert spectrogram(with_release(ds, 0.01)).axes
