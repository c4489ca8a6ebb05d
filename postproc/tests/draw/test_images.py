"""The moving beam over place, time, wave number and frequency: what the images hold is what was put in."""

import warnings

import numpy as np
import pytest
import synthetic
from scipy.signal import ShortTimeFFT
from scipy.signal.windows import hann

from beamwave_postproc import NothingToDraw, open_result, space_time, space_time_moment, spectrogram, spectrum, wavenumber_spectrum
from beamwave_postproc.draw.spectrogram import WINDOWS, levels, short_transform
from beamwave_postproc.draw.wavenumber import transform
from beamwave_postproc.parts.level import ROWS, decibels, highest_in_rows
from beamwave_postproc.parts.passage import arrivals, way_times

POINTS = [round(0.05 * i, 2) for i in range(1, 21)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A struck beam at 20 points, sampled finely, with 40 modes."""
    settings = synthetic.scene(
        modes={"before": 40, "after": 40},
        response={"duration": 0.05, "samples": 4096, "points": POINTS},
        spectrum={"max_peaks": 1},
    )
    with open_result(synthetic.write(tmp_path_factory.mktemp("whole") / "whole.nc", settings)) as ds:
        return ds.load()


def travelling(ds, wavenumber, frequency):
    """The result with a wave cos(βt − Px) in the place of its displacement."""
    phase = 2 * np.pi * frequency * ds["time"].values - wavenumber * ds["point_position"].values[:, None]
    return ds.assign(displacement=ds["displacement"].copy(data=np.cos(phase)))


def test_the_image_of_place_and_time_goes_through_the_points(whole):
    axes = space_time(whole).axes
    image = axes[1].images[0]
    left, right, bottom, top = image.get_extent()
    held, factor = image.get_array(), 1e3
    times = left + (np.arange(held.shape[1]) + 0.5) / held.shape[1] * (right - left)
    places = np.linspace(bottom, top, held.shape[0])
    row = int(np.abs(places - 0.5).argmin())
    expected = np.interp(times, 1e3 * whole["time"], factor * whole["displacement"].sel(point=9))
    # The place is within half a row of 0.5, where the slope takes the deflection at most a hundredth further.
    np.testing.assert_allclose(held[row], expected, atol=0.03 * np.abs(held[row]).max())
    assert (bottom, top) == (0.0, 1.0) and not np.any(held[0])


@pytest.mark.parametrize("draw", [space_time, spectrum, spectrogram, wavenumber_spectrum])
def test_what_may_be_nothing_but_error_carries_a_warning(whole, draw):
    peak = np.abs(whole["displacement"]).max("time").values
    doubtful, near = (draw(whole.assign(displacement_error=("point", share * peak))) for share in (1.3, 0.99))
    assert "Warning: the displacement may be nothing but error" in doubtful.texts[1].get_text().replace("\n", " ")
    assert not any("Warning" in text.get_text() for text in near.texts)


def test_the_first_part_stands_beside_a_long_record_alone_and_not_on_a_given_axes(whole):
    first, record = (axes for axes in space_time(whole).axes if axes.images and axes.get_xlabel())
    assert first.get_xlim()[1] < 0.2 * record.get_xlim()[1] and first.get_ylim() == record.get_ylim()
    assert first.get_ylabel() == record.get_ylabel() == r"Place $\xi$ (0 root, 1 tip)"
    assert len([axes for axes in space_time(whole.sel(time=slice(0.0, 0.004))).axes if axes.get_xlabel()]) == 1


@pytest.mark.parametrize("wavenumber", [30.0, -30.0])
def test_a_travelling_wave_has_its_amplitude_at_its_wave_number_on_its_side(whole, wavenumber):
    frequency = 100 / float(whole["time"][1] * whole.sizes["time"])  # in the middle of a bin
    wave, hertz, amplitude = transform(travelling(whole.assign(support_stiffness=1e6).assign_attrs(effects="support impact"), wavenumber, frequency))
    row, column = np.unravel_index(amplitude.argmax(), amplitude.shape)
    assert hertz[row] == pytest.approx(frequency)
    assert wave[column] == pytest.approx(wavenumber, abs=wave[1] - wave[0])
    # The peak lies between two of eight wave numbers to a bin, and a spline stands between points 1.5 rad apart.
    assert amplitude.max() == pytest.approx(2 * np.pi * frequency, rel=0.02)


def test_the_struck_beam_s_energy_lies_on_the_dispersion_curve(whole):
    wave, hertz, amplitude = transform(whole)
    for mode in (3, 5, 8):
        p = float(whole["wavenumber"].sel(mode=mode))
        row = int(np.abs(hertz - float(whole["angular_frequency"].sel(mode=mode)) / (2 * np.pi)).argmin())
        assert abs(wave[amplitude[row].argmax()]) == pytest.approx(p, abs=np.pi / 2)  # half a wave on the beam


def test_waves_arrive_in_the_spectrogram_when_the_group_velocity_says(whole):
    history = whole["displacement"].values[9]
    step, window = float(whole["time"][1]), 3e-4
    level, frequency, moments = levels(history, step, window, 2e-3, each=True)
    hertz, (straight, *_), _ = way_times(whole, 0.5, 2)
    for at in (12e3, 20e3, 30e3):
        arrival = np.interp(at, hertz, straight)
        row = level[np.abs(frequency - at).argmin()]
        first = next(
            i for i in range(1, row.size - 1) if row[i] > -6.0 and row[i] >= row[i - 1] and row[i] > row[i + 1]
        )
        # The window is as long as the arrival itself, whose peak it may shift by a fifth of its length.
        assert moments[first] == pytest.approx(arrival, abs=0.2 * window)


def test_an_image_fills_its_axes_and_arrivals_end_where_a_window_holds_no_wave(whole):
    fig = spectrogram(whole)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of a layout that fails
        fig.draw_without_rendering()
    images = [axes for axes in fig.axes if axes.images and axes.get_xlabel()]
    assert len(images) == 2
    for axes in images:
        assert axes.get_xlim()[1] == pytest.approx(axes.images[0].get_extent()[1])
    window = 1e3 * arrivals(whole) / WINDOWS  # ms
    lines = [line for line in images[0].lines if len(line.get_xdata()) > 2]
    assert len(lines) == 3 and all(line.get_ydata().min() >= 1.0 / window for line in lines)  # kHz
    labels = [axes.get_ylabel() for axes in fig.axes if axes not in images]
    assert labels == ["dB, 0 = the highest of each frequency", "dB, 0 = the highest"]


def test_amplitudes_over_the_highest_of_all_or_of_each_frequency(whole):
    history = np.sin(2 * np.pi * 5e3 * whole["time"].values) + 1e-2 * np.sin(2 * np.pi * 15e3 * whole["time"].values)
    step = float(whole["time"][1])
    for each in (True, False):
        level, frequency, _ = levels(history, step, 2e-3, 0.04, each=each)
        low, high = (level[np.abs(frequency - at).argmin()].max() for at in (5e3, 15e3))
        assert low == 0.0
        # Of the acceleration the weaker one has (15/5)² of a hundredth, which differences of 1.2 rad make sin²-like.
        expected = 20 * np.log10(1e-2 * (np.sin(np.pi * 15e3 * step) / np.sin(np.pi * 5e3 * step)) ** 2)
        assert high == pytest.approx(0.0 if each else expected, abs=0.5)


def test_rows_of_an_image_lose_no_line():
    amplitude = np.zeros((4001, 3))
    amplitude[1234] = 1.0
    frequency, rows = highest_in_rows(np.arange(4001.0), amplitude)
    assert rows.shape[0] <= ROWS and rows.max() == 1.0
    assert frequency[rows[:, 0].argmax()] <= 1234.0 < frequency[rows[:, 0].argmax() + 1]
    assert decibels(np.array([[0.1, 2.0]]), np.array([[1.0]])).tolist() == [[-20.0, 0.0]]


@pytest.mark.parametrize("picture", [space_time, wavenumber_spectrum])
def test_two_points_are_no_line_along_the_beam(full_result, picture):
    with open_result(full_result) as ds, pytest.raises(NothingToDraw, match="9 points or more"):
        picture(ds)


@pytest.mark.parametrize("picture", [spectrogram, wavenumber_spectrum])
def test_a_motion_that_grows_or_rests_has_no_spectrum(whole, picture):
    grown = whole.assign(growth_rate=whole["growth_rate"] + 200.0)
    for ds in (grown, whole.assign(displacement=0.0 * whole["displacement"]), whole.isel(time=slice(8))):
        with pytest.raises(NothingToDraw):
            picture(ds)


def test_windows_of_less_than_a_few_waves_are_no_spectrogram(whole):
    slow = whole.isel(mode=slice(1)).assign(mode_count=1)
    with pytest.raises(NothingToDraw, match="fewer than 4 waves"):
        spectrogram(slow)


def test_a_growing_motion_over_place_and_time_is_over_its_largest_so_far(whole):
    grown = whole.assign(
        growth_rate=whole["growth_rate"] + 200.0, displacement=whole["displacement"] * np.exp(200.0 * whole["time"])
    )
    image = space_time(grown).axes[1].images[0].get_array()
    assert np.abs(image).max() == pytest.approx(1.0)
    assert np.abs(image[:, -50:]).max() > 0.1


def test_the_image_of_moments_goes_through_all_points_and_has_the_stress_beside_it(whole):
    places = whole["point_position"].values
    moments = np.sin(400.0 * whole["time"].values) * (1.0 - places[:, None]) * 1e3
    ds = whole.assign(bending_moment=(("point", "time"), moments, {"units": "N m", "long_name": "bending moment"}))
    fig = space_time_moment(ds)
    image = fig.axes[1].images[0]
    bottom, top = image.get_extent()[2:]
    assert (bottom, top) == (places[0], 1.0)  # no point is added: a clamped root has a moment
    held, fine = image.get_array(), np.linspace(bottom, top, image.get_array().shape[0])
    column = np.abs(held).max(axis=0).argmax()
    np.testing.assert_allclose(held[:, column] / held[0, column], (1.0 - fine) / (1.0 - places[0]), atol=1e-12)
    bar = next(axes for axes in fig.axes if axes.get_ylabel().startswith("Bending moment"))
    (beside,) = bar.child_axes
    assert beside.get_ylabel() == "Outermost fibre's stress (MPa)"
    # M D/(2 I) = 32 M/(π D³) of a circle.
    diameter = float(ds["beam_diameter"])
    fig.draw_without_rendering()
    np.testing.assert_allclose(np.array(beside.get_ylim()), np.array(bar.get_ylim()) * 32e-6 / (np.pi * diameter**3), rtol=1e-9)


def test_a_peak_of_one_sample_is_in_the_image_of_a_long_record(whole):
    samples = 100_000
    time = np.arange(samples) * 1e-6
    moments = np.outer(1.0 - np.array(POINTS), np.sin(300.0 * time))
    moments[7, 54_321], moments[7, 98_765] = 5.0, -7.0
    ds = whole.drop_dims("time").assign_coords(time=("time", time, whole["time"].attrs))
    ds = ds.assign(bending_moment=(("point", "time"), moments, {"units": "N m", "long_name": "bending moment"}))
    fig = space_time_moment(ds)
    image = next(axes for axes in fig.axes[::-1] if axes.images).images[0]
    left, right, bottom, top = image.get_extent()
    held = image.get_array()
    # The rows next to the point are up to half a row from it, of 159 along 0.95, where its neighbours are 0.05 away.
    for peak, at in ((5.0, 0.054321), (-7.0, 0.098765)):
        row = np.abs(np.linspace(bottom, top, held.shape[0]) - POINTS[7]).argmin()
        assert held[row, int((1e3 * at - left) / (right - left) * held.shape[1])] == pytest.approx(peak, rel=0.07)
    assert any("largest magnitude" in text.get_text() for text in fig.texts)


def test_a_clamped_beam_has_its_root_in_the_image_and_an_elastic_one_its_points(whole):
    elastic = space_time(whole.assign(support_stiffness=1e6).assign_attrs(effects="support impact")).axes[1].images[0]
    assert elastic.get_extent()[2] == POINTS[0]


def test_a_lasting_contact_lets_the_image_be_seen(whole):
    ends = whole["event_end"].copy(data=[0.02, np.nan])
    kinds = whole["event_kind"].copy(data=[4, 4])
    lasting = whole.assign(event_end=ends, event_kind=kinds, event_time=whole["event_time"].copy(data=[0.0, 0.03]))
    for axes in (axes for axes in space_time(lasting).axes if axes.get_xlabel()):
        spans = [artist for artist in axes.patches if artist.get_width() > 0.0]
        assert spans and all(span.get_y() == 1.0 for span in spans)  # above it


@pytest.mark.parametrize(("samples", "hop"), [(64, 3), (65, 1), (8, 2)])
def test_the_transform_in_parts_is_that_of_scipy(samples, hop):
    values = np.random.default_rng(1).normal(size=1000)
    theirs = ShortTimeFFT(hann(samples, sym=False), hop, 1.0, mfft=2 * samples, scale_to="magnitude")
    moments = theirs.t(values.size)
    inside = (moments >= 0.0) & (moments < values.size)
    np.testing.assert_allclose(short_transform(values, samples, hop), np.abs(theirs.stft(values))[:, inside], atol=1e-14)
