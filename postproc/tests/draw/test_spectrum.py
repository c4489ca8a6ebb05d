"""Spectra with their peaks, and measured quantities beside computed ones."""

import numpy as np
import pytest
import synthetic
import xarray as xr

from beamwave_postproc import NothingToDraw, displacement, measured, open_result, spectrogram, spectrum
from beamwave_postproc.draw.measured import QUANTITIES
from beamwave_postproc.parts.tail import spectrum_after_events


def drawn_lines(fig):
    return [line for line in fig.axes[0].lines if len(line.get_xdata())]


def says(fig, words):
    return any(words in text.get_text().replace("\n", " ") for text in fig.texts)


def test_lines_folded_back_are_marked_and_the_head_says_so(full_result):
    with open_result(full_result) as ds:
        ds.load()
    frequency, rate = ds["angular_frequency"].values / (2 * np.pi), 2.0**14
    above = frequency[frequency > rate / 2]
    fig = spectrum(ds)
    (marked,) = (line for line in drawn_lines(fig) if line.get_marker() == "x")
    remainder = above % rate
    # The remainder is of numbers up to 1e5.
    np.testing.assert_allclose(marked.get_xdata(), np.sort(np.minimum(remainder, rate - remainder)), atol=1e-9)
    assert says(fig, "above half the sampling rate (8.192\u00a0kHz) are aliased; × marks them")
    assert says(spectrogram(ds), "are aliased; a triangle at the right marks them")
    few = ds.isel(mode=frequency < rate / 2)
    few = few.assign(mode_count=few.sizes["mode"])
    assert not any(line.get_marker() == "x" for line in drawn_lines(spectrum(few)))
    assert not any(says(picture(few), "aliased") for picture in (spectrum, spectrogram))
    # The file may hold fewer modes than were summed: the notes tell.
    more = few.assign(mode_count=40).assign_attrs(notes="remark: left out: modes 9 to 40, aliased from above")
    assert all(says(picture(more), "aliased") for picture in (spectrum, spectrogram))
    assert says(spectrum(ds.assign(mode_count=60)), "aliased; × marks those of the 40 modes in the file")


def test_a_marker_stands_on_each_measured_peak(full_result):
    with open_result(full_result) as ds:
        row, peaks = (line for line in drawn_lines(spectrum(ds)) if line.get_marker() != "x")
        expected = ds["measured_angular_frequency"].values / (2 * np.pi)
    np.testing.assert_array_equal(peaks.get_xdata(), expected)
    assert np.isin(peaks.get_ydata(), row.get_ydata()).all()
    assert row.get_xdata()[0] > 0.0


def test_a_marker_is_drawn_whole_or_where_it_would_be_of_rounding_not_at_all(full_result):
    with open_result(full_result) as ds:
        ds.load()
    frequency = ds["frequency"].values
    measured = ds["measured_angular_frequency"].values / (2 * np.pi)
    first, second, third = (int(np.abs(frequency - one).argmin()) for one in np.sort(measured)[:3])
    ds["amplitude"][..., :] = 1e-14
    for place, height in ((first, 1.0), (second, 1e-9), (third, 0.9e-9)):
        ds["amplitude"][..., place] = height
    fig = spectrum(ds.drop_vars(["angular_frequency"]))
    fig.draw_without_rendering()
    (peaks,) = (line for line in drawn_lines(fig) if line.get_marker() == "o")
    assert list(peaks.get_ydata()) == [1.0, 1e-9]
    axes = fig.axes[0]
    lowest = axes.transData.transform((peaks.get_xdata()[1], 1e-9))[1] - axes.get_window_extent().y0
    assert lowest > 0.5 * (peaks.get_markersize() + peaks.get_markeredgewidth()) * fig.dpi / 72.0


def test_a_spectrum_without_peaks_is_drawn_alone(full_result):
    with open_result(full_result) as ds:
        fig = spectrum(ds.drop_vars("measured_angular_frequency"))
    drawn = [line for line in drawn_lines(fig) if line.get_marker() != "x"]
    assert len(drawn) == 1 and not any("measured peaks" in text.get_text() for text in fig.texts)


@pytest.mark.parametrize("name", QUANTITIES)
def test_each_peak_is_compared_with_its_own_mode(full_result, name):
    with open_result(full_result) as ds:
        right = measured(ds, name).axes[1]
        bound, difference = (line for line in right.lines)
        expected = np.abs(ds[f"measured_{name}"].values / ds[name].values[:10] - 1)
    np.testing.assert_array_equal(difference.get_xdata(), np.arange(1, 11))
    # The quotient is rounded in another order here: two units in the last place of 1.
    np.testing.assert_allclose(difference.get_ydata(), expected, atol=5e-16)
    assert (difference.get_ydata() <= bound.get_ydata()).all()


def test_a_peak_without_a_wavenumber_is_left_out(full_result):
    with open_result(full_result) as ds:
        holed = ds.assign(measured_wavenumber=ds["measured_wavenumber"].where(ds["peak"] != 3))
        difference = measured(holed, "wavenumber").axes[1].lines[1]
        with pytest.raises(NothingToDraw):
            measured(ds.assign(measured_wavenumber=np.nan * ds["measured_wavenumber"]), "wavenumber")
    assert difference.get_xdata().tolist() == [1, 2, 4, 5, 6, 7, 8, 9, 10]


def test_exact_agreement_has_a_place_on_the_logarithmic_axis(full_result):
    with open_result(full_result) as ds:
        exact = ds.assign(measured_wavenumber=("peak", ds["wavenumber"].values[:10]))
        fig = measured(exact, "wavenumber")
        assert (fig.axes[1].lines[1].get_ydata() == 1e-17).all()
        assert any("at 10⁻¹⁷ stands for zero" in text.get_text() for text in fig.texts)
        other = measured(ds.assign(measured_wavenumber=1.001 * exact["measured_wavenumber"]), "wavenumber")
        assert not any("stands for zero" in text.get_text() for text in other.texts)


def test_a_record_of_two_samples_has_no_spectrum_to_draw(tmp_path):
    settings = synthetic.scene(response={"duration": 1.0, "samples": 2}, spectrum={"max_peaks": 1})
    with open_result(synthetic.write(tmp_path / "short.nc", settings)) as ds, pytest.raises(NothingToDraw):
        spectrum(ds)


def test_a_beam_at_rest_is_drawn(full_result):
    with open_result(full_result) as ds:
        still = ds.assign({name: xr.zeros_like(ds[name]) for name in ("amplitude", "displacement")})
        assert "(m)" in displacement(still).axes[0].get_ylabel()
        axes = spectrum(still).axes[0]
        assert (axes.lines[0].get_ydata() == 0.0).all() and "zero" in [text.get_text() for text in axes.texts]


def test_measured_frequencies_are_in_hertz(full_result):
    with open_result(full_result) as ds:
        left = measured(ds, "angular_frequency").axes[0]
        expected = ds["measured_angular_frequency"].values / (2 * np.pi)
    assert left.get_xlabel() == "Computed frequency (Hz)"
    # One division, and one multiplication by the inverse of it.
    np.testing.assert_allclose(left.lines[1].get_ydata(), expected, rtol=1e-15)


def test_a_quantity_that_is_not_measured_is_refused(full_result):
    with open_result(full_result) as ds, pytest.raises(ValueError, match="wavenumber"):
        measured(ds, "alpha")


@pytest.fixture
def growing_sweep(tmp_path):
    """Two masses (panels) by three speeds: the heavier beam grows at the second, both at the third."""
    settings = synthetic.scene(
        modes={"before": 3, "after": 3}, response={"duration": 0.5, "samples": 512}, spectrum={"max_peaks": 3}
    )
    sweep = {"rotation_angular_velocity": [0.0, 110.0, 150.0], "impact_mass_ratio": [0.2, 0.5]}
    with open_result(synthetic.write(tmp_path / "grows.nc", settings, sweep)) as ds:
        return ds.load()


def test_cases_that_grow_have_no_spectrum_and_no_say_in_the_scale(growing_sweep):
    fig = spectrum(growing_sweep)
    row = fig.axes[:3]
    assert says(fig, "3 of these grow and have no spectrum")
    assert [text.get_text() for text in row[2].texts] == ["all grow"]
    for axes, count in zip(row, (2, 1, 0)):
        drawn = [line for line in axes.lines if len(line.get_xdata()) > 20]
        assert len(drawn) == count
        bottom, top = axes.get_ylim()
        assert all(bottom < line.get_ydata().max() < top < 1.0 for line in drawn)
    with pytest.raises(NothingToDraw, match="grows"):
        spectrum(growing_sweep.isel(case=slice(4, None)))


def test_panels_far_apart_have_their_own_scales(growing_sweep):
    still = growing_sweep.isel(case=slice(2))
    both = xr.concat([still, still.assign(amplitude=1e12 * still["amplitude"])], dim="case", data_vars="all")
    both = both.assign_coords(case=[1, 2, 3, 4], rotation_angular_velocity=("case", [0.0, 0.0, 1.0, 1.0]))
    left, right = spectrum(both, points=1.0).axes
    assert right.get_ylim()[0] == pytest.approx(1e12 * left.get_ylim()[0])


def test_markers_stand_on_no_line_that_is_zero(full_result):
    with open_result(full_result) as ds:
        resting = ds.assign(amplitude=ds["amplitude"].where(ds["point_position"] > 0.6, 0.0))
        fig = spectrum(resting)
        chosen = spectrum(resting, points=0.5)
    assert len(fig.axes) == 1 and says(fig, "zero throughout at ξ = 0.5")
    assert [text.get_text() for text in chosen.axes[0].texts] == ["zero"]
    assert all(line.get_marker() in ("", "None") for line in drawn_lines(chosen))


def test_after_an_event_the_spectrum_is_that_of_the_samples_behind_it(full_result):
    with open_result(full_result) as ds:
        ds.load()
    time, last = ds["time"].values, 0.25
    before, after = 40.0, 100.0  # Hz, whole numbers of periods in the three quarters that follow
    tone = np.where(time <= last, np.sin(2 * np.pi * before * time), 0.5 * np.sin(2 * np.pi * after * time))
    kind = ds["event_kind"].copy(data=[1, 3][: ds.sizes["event"]])
    sounding = ds.assign(
        displacement=ds["displacement"].copy(data=np.tile(tone, (ds.sizes["point"], 1))),
        event_time=ds["event_time"].copy(data=[0.0, last]), event_end=ds["event_end"].copy(data=[0.0, last]), event_kind=kind,
    )  # fmt: skip
    frequency, amplitude, words = spectrum_after_events(sounding)
    assert amplitude[0][np.abs(frequency - after).argmin()] == pytest.approx(0.5, rel=2e-3)
    assert amplitude[0][np.abs(frequency - before) < 5.0].max() < 1e-5  # Hann's window falls by the cube of the distance
    assert says(spectrum(sounding), "of the samples after the last event, at 250\u00a0ms") and "last event" in words
    assert not spectrum_after_events(ds)[2]  # what happens at t = 0 leaves the whole record
