"""Records that the program warns of: sensors that tell nothing, and motion that no line describes."""

import numpy as np
import pytest
import results
from ring_downs import AMPLITUDE, FREQUENCY, RATE, as_text, ring_down, text_of
from workplace import PAPER_BEAM


def test_sensors_that_are_constant_or_copies_change_nothing(here):
    time, values = ring_down(4)
    here.write("two.csv", as_text(time, values))
    here.scene("two", {"record": {"file": "two.csv", "points": [0.5, 1.0]}, "beam": PAPER_BEAM, "spectrum": {}})
    alone = here.run("two")
    dead = np.full(time.size, 5.3)
    four = np.array([values[0], dead, values[1], 2 * np.round(values[0], 7)])
    here.write("four.csv", as_text(time, four, "time [s],mid [m/s2],dead [m/s2],tip [m/s2],twice [m/s2]"))
    here.scene("four", {"record": {"file": "four.csv", "points": [0.5, 0.7, 1.0, 0.8]}, "beam": PAPER_BEAM, "spectrum": {}})
    ended = here.beamwave("run", "four.nml")
    assert ended.returncode == 0
    assert "constant: dead [m/s2] is 5.3 in all samples" in ended.stderr
    assert "copy: the samples of twice [m/s2] are a multiple of those of an earlier sensor" in ended.stderr
    result = here.result("four")
    names = "angular_frequency angular_frequency_error decay_rate decay_rate_bound wavenumber wavenumber_error"
    for name in names.split():
        np.testing.assert_array_equal(result[f"measured_{name}"], alone[f"measured_{name}"], name)
    lines = FREQUENCY.size
    amplitude, error = result["measured_amplitude"][:, :lines], result["measured_amplitude_error"][:, :lines]
    np.testing.assert_array_equal(amplitude[[0, 2]], alone["measured_amplitude"][:, :lines])
    np.testing.assert_allclose(amplitude[3], 2 * amplitude[0], rtol=1e-14)
    assert (amplitude[1] == 0).all() and results.is_fill(error[1]).all() and not results.is_fill(error[3]).any()
    np.testing.assert_allclose(result["fitted"][1], 5.3, rtol=1e-14)


@pytest.mark.parametrize("bad", ["overloaded", "dies", "stays", "soon"])
def test_lines_are_found_without_a_sensor_most_of_which_is_flawed(here, bad):
    """The record has the lines of its good sensors alone, and their amplitudes; those of the bad one are not known."""
    time, values = ring_down(4)
    here.write("two.csv", as_text(time, values))
    here.scene("two", {"record": {"file": "two.csv", "points": [0.5, 1.0]}, "beam": PAPER_BEAM, "spectrum": {}})
    alone = here.run("two")
    middle = values[0] + values[1]
    if bad == "overloaded":
        limit = np.quantile(abs(middle), 0.5)
        middle = np.clip(middle, -limit, limit)
    middle[{"overloaded": time.size, "soon": 100}.get(bad, time.size // 2) :] = middle[-1] if bad == "stays" else np.nan
    head = "time [s],mid [m/s2],bad [m/s2],tip [m/s2]"
    here.write("three.csv", as_text(time, np.array([values[0], middle, values[1]]), head))
    here.scene("three", {"record": {"file": "three.csv", "points": [0.5, 0.7, 1.0]}, "beam": PAPER_BEAM, "spectrum": {}})
    ended = here.beamwave("run", "three.nml")
    assert ended.returncode == 0
    share = "90 %" if bad == "soon" else "50 %"
    said = [line for line in ended.stderr.splitlines() if "sensors: lines are found without" in line]
    assert len(said) == 1 and said[0].endswith(f"constant: bad [m/s2] ({share})"), ended.stderr
    result = here.result("three")
    names = "angular_frequency angular_frequency_error decay_rate decay_rate_bound wavenumber wavenumber_error"
    for name in names.split():
        np.testing.assert_array_equal(result[f"measured_{name}"], alone[f"measured_{name}"], name)
    for name in "amplitude amplitude_error amplitude_bound phase".split():  # vector and scalar functions differ in the last bits
        np.testing.assert_allclose(result[f"measured_{name}"][[0, 2]], alone[f"measured_{name}"], rtol=1e-15, err_msg=name)
        assert results.is_fill(result[f"measured_{name}"][1]).all(), name
    assert results.is_fill(result["noise_deviation"]).tolist() == [False, True, False]
    assert results.is_fill(result["fitted"][1]).all()
    missing = {"dies": time.size // 2, "soon": time.size - 100}.get(bad, 0)
    assert results.is_fill(result["recorded"]).sum(axis=1).tolist() == [0, missing, 0]


def test_a_frequency_that_sweeps_is_told(here):
    time = np.arange(2000) / RATE
    sweep = np.cos(2 * np.pi * (60 + 25 * time) * time)
    noise = 0.05 * np.random.default_rng(6).standard_normal((2, 2000))
    here.write("ring.csv", as_text(time, np.array([sweep, 0.5 * sweep]) + noise))
    here.scene("ring", {"record": {"file": "ring.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "ring.nml")
    assert ended.returncode == 4
    assert "no free decay" in ended.stderr
    here.write("ring.csv", text_of(6))
    ended = here.beamwave("run", "ring.nml", "--overwrite")
    assert (ended.returncode, "no free decay" in ended.stderr) == (0, False)


def test_a_blow_is_found_behind_a_quiet_start_and_said(here):
    """The recorder kept 40 samples before the blow: the lines are those of the decay, with the amplitudes at the blow."""
    time, values = ring_down(9)
    noise = values - ring_down(9, noise=0.0)[1]
    late = np.roll(values - noise, 40, axis=1)
    late[:, :40] = 0.0
    here.write("ring.csv", as_text(time, late + noise))
    here.scene("ring", {"record": {"file": "ring.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "ring.nml")
    assert ended.returncode == 0
    assert f"blow: found at {40 / RATE:g} s" in ended.stdout
    result = here.result("ring")
    assert result["peak_count"] == FREQUENCY.size
    away = result["measured_angular_frequency"][: FREQUENCY.size] / (2 * np.pi) - FREQUENCY
    assert (abs(away) < 2 * result["measured_angular_frequency_error"][: FREQUENCY.size] / (2 * np.pi)).all()
    amplitude = result["measured_amplitude"][:, : FREQUENCY.size]
    assert (abs(amplitude - abs(AMPLITUDE)) < 2 * result["measured_amplitude_error"][:, : FREQUENCY.size]).all()


@pytest.mark.parametrize("before", ["zeros", "tones"])
def test_zeros_or_tones_before_a_blow_leave_the_blow_where_it_is(here, before):
    """A recorder whose noise is below its resolution; or hum and its third multiple, in which the record begins."""
    time, values = ring_down(9)
    late = np.roll(values, 200, axis=1)
    late[:, :200] = 0.0
    if before == "tones":
        dice = np.random.default_rng(3)
        hum = 0.3 * np.cos(2 * np.pi * 50 * time) + 0.2 * np.cos(2 * np.pi * 150 * time + 1)
        late[:, :200] = 0.02 * dice.standard_normal((2, 200))
        late += hum
    here.write("ring.csv", as_text(time, late))
    here.scene("ring", {"record": {"file": "ring.csv"}, "spectrum": {}})
    result = here.run("ring")
    count = result["peak_count"]
    assert count == FREQUENCY.size + (2 if before == "tones" else 0)
    assert abs(result["measured_blow_time"] - 0.2) < 1.5e-3
    found = result["measured_angular_frequency"][:count] / (2 * np.pi)
    places = np.abs(found[:, None] - FREQUENCY).argmin(axis=0)
    assert (np.abs(found[places] - FREQUENCY) < 2 * result["measured_angular_frequency_error"][places] / (2 * np.pi)).all()
    amplitude = result["measured_amplitude"][:, places]
    assert (abs(amplitude - abs(AMPLITUDE)) < 2 * result["measured_amplitude_error"][:, places] + 0.01 * abs(AMPLITUDE)).all()


def test_clipped_and_missing_samples_are_left_out(here):
    """One of a hundred samples is cut off, and one of a hundred rows is missing: the lines are where they were."""
    time, values = ring_down(10)
    limit = np.quantile(abs(values), 0.99, axis=1)[:, None]
    kept = np.random.default_rng(11).random(time.size) > 0.01
    kept[[0, -1]] = True
    here.write("ring.csv", as_text(time[kept], np.clip(values, -limit, limit)[:, kept]))
    here.scene("ring", {"record": {"file": "ring.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "ring.nml")
    assert f"even, {RATE:g} Hz, without {time.size - kept.sum()} samples in between" in ended.stdout
    result = here.result("ring")
    np.testing.assert_array_equal(results.is_fill(result["recorded"]), abs(values[:, kept]) >= limit)
    assert not results.is_fill(result["fitted"]).any()
    assert result["peak_count"] == FREQUENCY.size
    away = result["measured_angular_frequency"][: FREQUENCY.size] / (2 * np.pi) - FREQUENCY
    assert (abs(away) < 2 * result["measured_angular_frequency_error"][: FREQUENCY.size] / (2 * np.pi)).all()


def test_flawed_samples_at_uneven_times_are_left_out(here):
    """One sensor is cut off, another is stuck for a while: the lines and amplitudes are where they were."""
    time = ring_down(10)[0]
    time += np.random.default_rng(12).uniform(-0.2, 0.2, time.size) / RATE
    time, values = ring_down(10, times=time - time[0])
    limit = np.quantile(abs(values[0]), 0.97)
    values[0] = np.clip(values[0], -limit, limit)
    values[1, 400:600] = values[1, 400]
    here.write("ring.csv", as_text(time, values))
    here.scene("ring", {"record": {"file": "ring.csv"}, "spectrum": {}})
    result = here.run("ring")
    assert result["peak_count"] == FREQUENCY.size
    away = result["measured_angular_frequency"][: FREQUENCY.size] / (2 * np.pi) - FREQUENCY
    assert (abs(away) < 2 * result["measured_angular_frequency_error"][: FREQUENCY.size] / (2 * np.pi)).all()


def test_spikes_are_left_out(here):
    """A logger's errors, and some that are no larger than the motion: the lines are where they were."""
    time, values = ring_down(10)
    values[0, [300, 301, 700]] = 1e38, -1e37, 500 * abs(values).max()
    values[1, [250, 420, 610]] += 0.5, -1.0, 3.0
    here.write("ring.csv", as_text(time, values))
    here.scene("ring", {"record": {"file": "ring.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "ring.nml")
    assert (ended.returncode, "far from all other samples; left out: 3 samples" in ended.stderr) == (0, True)
    assert "spike: tip [m/s2] has 3 samples beside the motion before and after" in ended.stderr
    result = here.result("ring")
    assert results.is_fill(result["recorded"][0, [300, 301, 700]]).all()
    assert results.is_fill(result["recorded"][1, [250, 420, 610]]).all()
    assert result["peak_count"] == FREQUENCY.size
    away = result["measured_angular_frequency"][: FREQUENCY.size] / (2 * np.pi) - FREQUENCY
    assert (abs(away) < 2 * result["measured_angular_frequency_error"][: FREQUENCY.size] / (2 * np.pi)).all()
