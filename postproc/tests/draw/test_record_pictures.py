"""Pictures of a record: fit, spectrum, parts, shapes and dispersion of its lines."""

import numpy as np
import pytest
import xarray as xr

from beamwave_postproc import (
    NothingToDraw,
    record_response,
    record_dispersion,
    record_envelopes,
    record_fit,
    record_repeats,
    record_shapes,
    record_spectrum,
    record_windows,
    spectrum,
)

HERTZ = np.array([10.0, 60.0])
STATUS = {"flag_masks": [1, 2, 4, 8, 16], "flag_meanings": "line close_pair harmonic drifting at_edge"}
TIME = np.arange(1000) / 500.0
ROOT = 8.0


@pytest.fixture
def record():
    """Two lines at two sensors, the second a drifting harmonic; a third place in the file is empty."""
    fitted = np.array([np.cos(2 * np.pi * 10 * TIME) * np.exp(-TIME), 0.5 * np.cos(2 * np.pi * 60 * TIME)])
    recorded = fitted + 0.01 * np.cos(37.0 * np.arange(1000.0) ** 2)
    frequency = np.arange(501) / 2.0
    beta = np.append(2 * np.pi * HERTZ, np.nan)
    wave = np.append(np.sqrt(2 * np.pi * HERTZ / ROOT), np.nan)
    windows = np.full((3, 6), np.nan)
    windows[0] = beta[0] + 0.01 * np.arange(6)
    amplitude = 1e-3 + np.where(np.isin(frequency, HERTZ), 0.5, 0.0) * np.ones((2, 1))
    return xr.Dataset(
        {
            "measured_angular_frequency": ("peak", beta, {"units": "rad s-1"}),
            "measured_angular_frequency_error": ("peak", [0.1, 0.2, np.nan]),
            "measured_decay_rate": ("peak", [1.0, 0.5, np.nan], {"units": "s-1"}),
            "measured_decay_rate_error": ("peak", [0.1, 0.2, np.nan]),
            "measured_amplitude": (("point", "peak"), [[1.0, 0.1, np.nan], [0.5, 0.2, np.nan]], {"units": "m s-2"}),
            "measured_amplitude_error": (("point", "peak"), np.full((2, 3), 0.01)),
            "measured_phase": (("point", "peak"), [[0.3, 1.0, np.nan], [0.3 + np.pi, 1.0, np.nan]]),
            "measured_phase_error": (("point", "peak"), np.full((2, 3), 0.01)),
            "measured_wavenumber": ("peak", wave, {"units": "m-1"}),
            "measured_wavenumber_error": ("peak", [0.01, 0.02, np.nan]),
            "measured_stiffness_root": ((), ROOT),
            "measured_stiffness_root_error": ((), 0.1),
            "peak_status": ("peak", [1, 12, 0], STATUS),
            "peak_count": ((), 2),
            "window_angular_frequency": (("peak", "window"), windows),
            "window_angular_frequency_bound": (("peak", "window"), np.full((3, 6), 0.005)),
            "window_decay_rate": (("peak", "window"), np.where(np.isfinite(windows), 1.0, np.nan)),
            "window_decay_rate_bound": (("peak", "window"), np.full((3, 6), 0.02)),
            "window_start": ("window", [0.0, 0.5, 0.0, 0.25, 0.5, 0.75]),
            "window_end": ("window", [0.5, 1.0, 0.25, 0.5, 0.75, 1.0]),
            "candidate_angular_frequency": ("candidate", [2 * np.pi * 100.0, np.nan]),
            "candidate_reason": ("candidate", [2, 0], {"flag_values": [1, 2], "flag_meanings": "not_needed too_broad"}),
            "candidate_count": ((), 1),
            "recorded": (("point", "time"), recorded, {"units": "m s-2"}),
            "fitted": (("point", "time"), fitted, {"units": "m s-2"}),
            "amplitude": (("point", "frequency"), amplitude, {"units": "m s-2"}),
            "noise_level": (("point", "frequency"), np.full((2, 501), 2e-3), {"units": "m s-2"}),
            "sensor_name": ("point", ["mid [m/s2]", "tip [m/s2]"]),
            "sensor_quantity": (
                "point",
                [3, 3],
                {"flag_values": [1, 2, 3, 4], "flag_meanings": "displacement velocity acceleration strain"},
            ),
        },
        {
            "peak": [1, 2, 3],
            "time": TIME,
            "frequency": ("frequency", frequency, {"units": "Hz"}),
            "point_position": ("point", [0.5, 1.0], {"units": "1"}),
        },
        {"title": "A ring-down", "effects": "", "method": "record"},
    )


def words_of(fig):
    return " ".join(text.get_text() for text in fig.texts).replace("\n", " ")


def test_a_sensor_in_a_unit_of_no_motion_is_shown_in_it_alone(record):
    units = {"sensor_unit": ("point", ["V/1000", "m s-2 "])}
    axes = record_fit(record.assign(units)).axes
    assert axes[0].get_ylabel() == "mid, $\\xi$ = 0.5\n(V/1000)"
    assert axes[4].get_ylabel().endswith("Acceleration (m/s²)") and axes[6].get_ylabel() == "Residual\n(m/s²)"


def test_a_fit_has_a_row_for_each_sensor_and_its_beginning_beside_it(record):
    fig = record_fit(record)
    whole, near, left = fig.axes[:3]
    assert len(fig.axes) == 8  # record and residual of two sensors, whole and from near
    residual = record["recorded"].values[0] - record["fitted"].values[0]
    assert left.get_ylim()[1] == pytest.approx(1.15 * np.abs(residual).max()) and left.get_ylabel() == "Residual\n(m/s²)"
    assert near.get_xlim()[1] < 0.5 * whole.get_xlim()[1]
    assert whole.get_ylabel().startswith("mid") and whole.get_ylabel().endswith("Acceleration (m/s²)")
    assert {text.get_text() for text in fig.legends[0].get_texts()} == {"record", "fit: sum of its lines", "residual: record − fit"}


@pytest.mark.parametrize("draw", [record_fit, record_spectrum, record_envelopes])
def test_a_sensor_that_was_left_out_is_not_drawn(record, draw):
    record = record.assign(measured_blow_time=0.0)
    alone = draw(record.isel(point=[0]))
    broken = record.assign(noise_deviation=("point", [0.01, np.nan]))
    for name in ("measured_amplitude", "measured_amplitude_error", "measured_phase", "fitted", "amplitude", "noise_level"):
        broken[name][1] = np.nan
    broken["recorded"][1, 500:] = np.nan
    assert len(draw(broken).axes) == len(alone.axes)


def test_from_near_the_fit_is_drawn_between_the_samples_where_the_lines_make_it(record):
    exact = record.assign(
        measured_phase=(("point", "peak"), np.zeros((2, 3))),
        measured_amplitude=(("point", "peak"), [[1.0, 0.0, np.nan], [0.0, 0.5, np.nan]]),
        measured_decay_rate=("peak", [1.0, 0.0, np.nan]),
    )
    fine, coarse = (record_fit(ds).axes[1].lines[1] for ds in (exact, record))
    np.testing.assert_allclose(fine.get_ydata(), np.cos(2 * np.pi * 10 * fine.get_xdata()) * np.exp(-fine.get_xdata()), atol=1e-12)
    assert len(fine.get_xdata()) > 5 * len(coarse.get_xdata())


def test_a_thinned_record_is_a_band(record):
    pairs = record.isel(time=slice(0, 1000)).copy(deep=True)
    for name in ("recorded", "fitted"):
        values = pairs[name].values
        low, high = np.minimum(values[:, ::2], values[:, 1::2]), np.maximum(values[:, ::2], values[:, 1::2])
        pairs[name].values[:, ::2], pairs[name].values[:, 1::2] = low, high
    fig = record_fit(pairs)
    assert len(fig.axes) == 2 and not fig.axes[0].lines
    assert "least to largest" in words_of(fig)


def test_a_spectrum_marks_lines_by_what_they_are_and_rejected_places(record):
    fig = record_spectrum(record)
    axes = fig.axes[0]
    by_label = {line.get_label(): line for line in axes.lines}
    np.testing.assert_allclose(by_label["line"].get_xdata(), [10.0])
    np.testing.assert_allclose(by_label["harmonic, drifting"].get_xdata(), [60.0])
    np.testing.assert_allclose(by_label["line"].get_ydata(), [0.501])
    np.testing.assert_allclose(by_label["rejected candidate"].get_xdata(), [100.0])
    assert "1 too broad" in words_of(fig)
    with pytest.raises(NothingToDraw, match="record_spectrum"):
        spectrum(record)


def test_parts_are_bars_as_long_as_they_are(record):
    fig = record_windows(record)
    frequency, _ = fig.axes
    halves, quarters = frequency.containers
    np.testing.assert_allclose(halves.lines[0].get_xdata(), [0.25, 0.75])
    np.testing.assert_allclose(quarters.lines[0].get_ydata(), 1e3 * 0.01 * np.arange(2, 6) / (2 * np.pi))
    across, along = (bar.get_segments()[0] for bar in quarters.lines[2])
    assert np.ptp(across[:, 0]) == pytest.approx(0.25)
    assert np.ptp(along[:, 1]) == pytest.approx(2 * 2 * 1e3 * 0.005 / (2 * np.pi))
    assert "1 of 2 lines" in words_of(fig)


def test_shapes_have_signs_by_their_phase(record):
    axes = record_shapes(record).axes[0]
    first, second = (box.lines[0].get_ydata() for box in axes.containers)
    assert first[0] > 0.0 > first[1] and first[1] == pytest.approx(-0.5 * first[0])
    assert (second > 1.0).all()


def test_shapes_leave_out_a_sensor_that_tells_nothing(record):
    record["measured_amplitude_error"].values[1] = np.nan
    axes = record_shapes(record).axes[0]
    assert [box.lines[0].get_ydata().size for box in axes.containers] == [1, 1]


def test_a_dispersion_shows_lines_and_the_curve_through_them(record):
    fig = record_dispersion(record)
    axes = fig.axes[0]
    curve, wave = axes.lines[0], axes.containers[0].lines[0]
    np.testing.assert_allclose(wave.get_ydata(), HERTZ)
    np.testing.assert_allclose(np.interp(wave.get_xdata(), *curve.get_data()), HERTZ, rtol=1e-3)
    assert "8 ± 0.1 m²/s" in words_of(fig)
    off, _, bars = fig.axes[1].containers[0].lines
    np.testing.assert_allclose(off.get_ydata(), 0.0, atol=1e-12)
    wavenumber = record["measured_wavenumber"].values[0]
    assert np.ptp(bars[0].get_segments()[0][:, 1]) == pytest.approx(100 * 2 * 0.01 / wavenumber)


def test_the_shape_of_a_wave_number_goes_through_the_amplitudes(record):
    alpha = np.array([1.8751040687119611, 4.694091132974174])  # of a clamped and free beam, whose ratios are table values
    known = record.assign(
        beam_length=((), 0.5),
        measured_wavenumber=("peak", np.append(alpha / 0.5, np.nan)),
        measured_amplitude=(("point", "peak"), [[0.339523, 0.713666, np.nan], [1.0, 1.0, np.nan]]),
        measured_phase=(("point", "peak"), [[0.0, np.pi, np.nan], [0.0, 0.0, np.nan]]),
    )
    assert len(record_shapes(known).axes[0].lines) == len(record_shapes(record).axes[0].lines)  # its ends are not known
    axes = record_shapes(known.assign_attrs(scene="&spectrum\n  ends = 'tip'\n/")).axes[0]
    shapes = [line for line in axes.lines if line.get_label() == "shape of its wave number"]
    assert len(shapes) == 2
    for row, (shape, middle) in enumerate(zip(shapes, [0.339523, -0.713666])):
        along, height = shape.get_data()
        tip = height[-1] - row
        assert height[0] == row and (height[along == 0.5][0] - row) / tip == pytest.approx(middle, abs=1e-5)


def test_a_shape_that_is_largest_between_the_sensors_stays_on_its_own_line(record):
    """Sensors near the nodes: at ξ = 0.5 and 1 the shape has a fiftieth of what it has between them."""
    xi = np.linspace(0.0, 1.0, 101)
    shape = np.tile(np.sin(2.0 * np.pi * xi) + 0.02, (record.sizes["peak"], 1))
    known = record.assign(modelled_shape=(("peak", "profile"), shape)).assign_coords(profile_position=("profile", xi))
    axes = record_shapes(known).axes[0]
    shapes = [line.get_ydata() for line in axes.lines if line.get_label() == "shape of the model's mode"]
    assert len(shapes) == 2 and all(np.abs(height - row).max() < 0.5 for row, height in enumerate(shapes))


def test_a_place_rejected_at_a_line_is_not_marked(record):
    record["candidate_angular_frequency"].values[:] = 2 * np.pi * (HERTZ + 0.2)
    labels = [line.get_label() for line in record_spectrum(record).axes[0].lines]
    assert "rejected candidate" not in labels and "line" in labels


def test_of_a_sweep_the_first_case_with_lines_is_drawn(record):
    empty = record.assign(peak_count=((), 0), measured_angular_frequency=record.measured_angular_frequency * np.nan)
    swept = xr.concat([empty, record], dim="case", data_vars="all", coords="minimal")
    swept = swept.assign({name: record[name] for name in ("window_start", "window_end", "sensor_name", "sensor_quantity")})
    assert "case 2 of 2" in words_of(record_spectrum(swept))


def test_repeats_stand_side_by_side_with_the_bands_of_all_of_them(record):
    """Two repeats, of which the second lacks the first line: one line is shared, as the second pooled one of a longer list."""
    lost = record.copy(deep=True)
    lost["measured_angular_frequency"].values[:] = [record.measured_angular_frequency[1] + 0.4, np.nan, np.nan]
    both = xr.concat([record, lost], dim="case", data_vars="all", coords="minimal")
    hertz = 2 * np.pi
    for name, numbers in [("pooled_angular_frequency", [60.03, 0.05, 0.09]), ("pooled_decay_rate", [0.5, 0.1, 0.2])]:
        for part, number in zip(["", "_error", "_next"], numbers):
            unit = hertz if "angular" in name else 1.0
            both[name + part] = ("pooled", unit * np.array([number, np.nan, np.nan]))
    both["pooled_count"] = ("pooled", [2, 0, 0])
    both["pooled_line"] = (("case", "peak"), [[0, 1, 0], [1, 0, 0]])
    fig = record_repeats(both)
    frequency, decay = fig.axes
    points = frequency.containers[0].lines[0]
    np.testing.assert_allclose(points.get_xdata(), [1, 2])
    np.testing.assert_allclose(points.get_ydata(), [-30.0, 1e3 * 0.4 / hertz - 30.0], rtol=1e-6)
    assert frequency.get_ylabel() == "$f$ − 60.03 Hz (mHz)"
    np.testing.assert_allclose(decay.containers[0].lines[0].get_ydata(), [0.5, 1.0])
    with pytest.raises(NothingToDraw, match="share no line"):
        record_repeats(both.assign(pooled_count=("pooled", [0, 0, 0])))


def test_no_line_is_drawn_across_what_was_not_recorded_or_is_left_out(record):
    some = record.isel(time=np.flatnonzero((TIME < 0.8) | (TIME > 1.0))).copy(deep=True)
    some["recorded"].values[1, 60:70] = np.nan
    fig = record_fit(some)
    mid, tip, residual = (axes.lines[0] for axes in (fig.axes[0], fig.axes[4], fig.axes[6]))
    for line in (mid, tip, residual):
        gap = np.isnan(line.get_ydata()) & (line.get_xdata() > 0.8)
        assert gap.sum() == 1 and line.get_xdata()[gap] == pytest.approx(0.9, abs=2e-3)
    out = TIME[60:70]
    assert np.isnan(tip.get_ydata()[np.isin(tip.get_xdata(), out)]).all()
    assert np.isfinite(mid.get_ydata()[np.isin(mid.get_xdata(), out)]).all()
    assert "gaps: samples that are missing or left out" in words_of(fig)


def test_the_near_view_of_a_fit_begins_with_the_blow(record):
    late = record.assign(measured_blow_time=((), 0.4))
    near = record_fit(late).axes[1]
    assert near.get_xlim()[0] == pytest.approx(0.4)


def test_an_envelope_is_straight_and_the_record_lies_on_it(record):
    fig = record_envelopes(record.assign(measured_blow_time=((), 0.0)))
    axes = fig.axes[0]
    by_label = {line.get_label(): line for line in axes.lines}
    line = by_label[r"line, $A\,\mathrm{e}^{-\delta t}$"]
    np.testing.assert_allclose(line.get_ydata(), np.exp(-TIME), rtol=1e-12)
    seen = by_label["record about the line"]
    np.testing.assert_allclose(seen.get_ydata(), np.exp(-seen.get_xdata()), rtol=0.03)
    assert axes.get_yscale() == "log" and axes.get_title(loc="left").startswith("line 1")


def test_the_lines_take_the_place_of_samples_that_are_left_out_of_an_envelope(record):
    clipped = record.assign(measured_blow_time=((), 0.0)).copy(deep=True)
    clipped["recorded"].values[0, np.abs(clipped["recorded"].values[0]) > 0.5] = np.nan
    seen = {line.get_label(): line for line in record_envelopes(clipped).axes[0].lines}["record about the line"]
    np.testing.assert_allclose(seen.get_ydata(), np.exp(-seen.get_xdata()), rtol=0.03)


def test_the_models_shape_goes_through_the_dots(record):
    xi = np.linspace(0, 1, 11)
    shape = np.array([xi**2, -(xi**3), np.full(11, np.nan)])
    known = record.assign(modelled_shape=(("peak", "profile"), shape)).assign_coords(profile_position=("profile", xi))
    axes = record_shapes(known).axes[0]
    drawn = [line for line in axes.lines if line.get_label() == "shape of the model's mode"]
    assert len(drawn) == 2
    rise = drawn[0].get_ydata() - drawn[0].get_ydata()[0]
    np.testing.assert_allclose(rise / rise[-1], xi**2, atol=1e-12)


def test_a_frequency_response_stands_beside_the_sum_of_its_modal_constants(record):
    beta, decay = 2 * np.pi * HERTZ, np.array([1.0, 0.5])
    constant = np.array([[2.0, 1.0, np.nan], [-1.0, 0.5, np.nan]])
    at = 2j * np.pi * record["frequency"].values[:, None]
    response = ((at**2 / ((at + decay) ** 2 + beta**2)) @ constant[:, :2].T).T
    parts = {
        "measured_modal_constant_real": (("point", "peak"), constant),
        "measured_modal_constant_imag": (("point", "peak"), 0 * constant),
        "frequency_response_real": (("point", "frequency"), response.real),
        "frequency_response_imag": (("point", "frequency"), response.imag),
    }
    axes = record_response(record.assign(parts)).axes
    assert len(axes) == 2
    for one in axes:
        by_label = {line.get_label(): line for line in one.lines}
        measured, summed = by_label["response over force"], by_label["modal constants"]
        np.testing.assert_allclose(summed.get_ydata(), measured.get_ydata(), rtol=1e-9)
        assert one.get_xlim()[1] == pytest.approx(90.0, abs=1.0)
    for name in ("h1", "h2"):
        for part in ("real", "imag"):
            parts[f"pooled_response_{name}_{part}"] = parts[f"frequency_response_{part}"]
    parts["pooled_coherence"] = (("point", "frequency"), np.ones(response.shape))
    assert len(record_response(record.assign(parts)).axes) == 4


RECORD_PICTURES = [
    record_fit,
    record_repeats,
    record_spectrum,
    record_windows,
    record_shapes,
    record_dispersion,
    record_envelopes,
    record_response,
]


@pytest.mark.parametrize("draw", RECORD_PICTURES)
def test_what_is_no_record_is_refused(draw):
    with pytest.raises(NothingToDraw):
        draw(xr.Dataset(attrs={"method": "closed form"}))
