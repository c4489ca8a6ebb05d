"""Records through the program: lines inside their intervals, repeats and sweeps as cases, and what makes a result another."""

import itertools
import re
import signal
import time

import numpy as np
import pytest
import results
from ring_downs import AMPLITUDE, DECAY, FREQUENCY, NOISE, PHASE, RATE, SAMPLES, as_text, ring_down, text_of
from scipy.signal import butter, lfilter
from workplace import captured_beam, namelist

ASKED = {"record": {"file": "ring.csv"}, "spectrum": {}}
WIDE = 2.0  # intervals of 95 %, four standard deviations: with 40 numbers one in 400 draws leaves one, and the seeds are fixed


@pytest.fixture(scope="module")
def ringing(shared):
    """A record with known lines, run."""
    here = shared("ringing")
    here.write("ring.csv", text_of(1))
    here.scene("ring", {**ASKED, "record": {"file": "ring.csv", "points": [0.5, 1.0]}})
    return here, here.run("ring")


def lines_of(result, name, case=...):
    """The numbers of a variable that exist, lines last."""
    values = result[name][case]
    return values[..., : FREQUENCY.size]


def test_known_lines_are_inside_their_intervals(ringing):
    _, result = ringing
    assert result["peak_count"] == FREQUENCY.size
    phase = PHASE + np.pi * (AMPLITUDE < 0)
    for name, true in [("angular_frequency", 2 * np.pi * FREQUENCY), ("decay_rate", DECAY),
                       ("amplitude", abs(AMPLITUDE)), ("phase", phase)]:
        found, error, bound = (lines_of(result, f"measured_{name}{part}") for part in ("", "_error", "_bound"))
        away = found - true
        if name == "phase":
            away = np.angle(np.exp(1j * away))
        assert (abs(away) < WIDE * error).all(), name
        assert (bound > 0).all() and (error > 1.9 * bound).all() and (error < 3 * bound).all(), name
        assert results.is_fill(result[f"measured_{name}"][..., FREQUENCY.size :]).all()
    assert (lines_of(result, "peak_status") == 1).all()
    np.testing.assert_allclose(result["noise_deviation"], NOISE, rtol=0.1)  # 1024 samples: 2 %, and what was fitted


def test_a_driven_resonance_is_no_free_decay(here):
    """Noise of one broad resonance: an autoregression of second order, with poles 1.5 % inside the circle."""
    draws = np.random.default_rng(30)
    noise = [0.0, 0.0]
    while len(noise) < 514:
        noise.append(2 * 0.985 * np.cos(0.6) * noise[-1] - 0.985**2 * noise[-2] + draws.standard_normal())
    here.write("noise.csv", "time,a [m/s]\n" + "".join(f"{j / 1000:.3f},{value:.6f}\n" for j, value in enumerate(noise[2:])))
    here.scene("noise", {"record": {"file": "noise.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "noise.nml")
    assert "Rejected candidates" in ended.stdout
    assert abs(here.result("noise")["candidate_angular_frequency"][0] - 600.0) < 10.0  # rad/s: the resonance, whose half-width is 15
    assert ended.returncode == 4
    assert "no free decay: the beam seems to be driven continuously" in ended.stderr
    assert "operational modal analysis, which this program does not do" in ended.stderr
    result = here.result("noise")
    assert (result["peak_count"], result["case_status"]) == (0, 5)
    assert results.is_fill(result["measured_angular_frequency"]).all()


@pytest.mark.parametrize("seed", [4, 8, 12, 20])
def test_a_beam_that_is_shaken_for_few_periods_of_its_first_mode_is_no_free_decay(here, seed):
    """Seven periods of the first of three modes under a white force: an autoregression of moderate order hardly represents them."""
    draws = np.random.default_rng(seed)
    force, rate = draws.standard_normal(6500).astype(complex), 500.0
    steps = {frequency: np.exp((-0.008 + 1j) * 2 * np.pi * frequency / rate) for frequency in (1.4, 8.8, 24.6)}
    motion = sum(lfilter([1 / frequency], [1, -step], force).imag for frequency, step in steps.items())[4000:]
    values = motion / motion.std() + 0.01 * draws.standard_normal(motion.size)
    here.write("shaken.csv", as_text(np.arange(values.size) / rate, values[None], "time [s],tip [m/s]"))
    here.scene("shaken", {"record": {"file": "shaken.csv"}, "spectrum": {}})
    assert here.beamwave("run", "shaken.nml").returncode == 4


def test_decays_in_noise_of_a_steep_band_are_found(here):
    """The noise needs a high order beside the lines, as it does alone: 2 modes, decays by 0.3 and 0.5 in the record."""
    draws = np.random.default_rng(5)
    time = np.arange(8000) / 1000.0
    noise = lfilter(*butter(4, [0.1, 0.3], "band"), draws.standard_normal(8500))[500:]
    values = sum(a * np.exp(-d * time / 8) * np.sin(2 * np.pi * f * time) for a, d, f in ((1, 0.3, 72.0), (0.8, 0.5, 86.0)))
    values += 0.03 * noise / noise.std() + 1e-5 * draws.standard_normal(time.size)
    here.write("band.csv", as_text(time, values[None], "time [s],tip [m/s2]"))
    here.scene("band", {"record": {"file": "band.csv"}, "spectrum": {}})
    found = here.run("band")["measured_angular_frequency"] / (2 * np.pi)
    assert abs(found - 72.0).min() < 1e-3 and abs(found - 86.0).min() < 1e-3


@pytest.mark.parametrize("seed", [1, 5, 7])
def test_a_beam_that_is_struck_again_before_it_rests(here, seed):
    """Five blows within a fifth of the decay time of mode 1, which each add to what still moves."""
    draws = np.random.default_rng(seed)
    poles = -np.array([0.125, 0.39, 1.2, 5.0]) + 2j * np.pi * np.array([4.64, 45.15, 140.57, 290.0])
    shapes = draws.uniform(0.3, 1, (4, 3)) * draws.choice([-1, 1], (4, 3))
    edges = np.array([0, 1870, 3600, 5280, 6650, 9000])
    motion = np.zeros((4, 3), complex)
    values = np.zeros((9000, 3))
    for first, last in itertools.pairwise(edges):
        size = np.array([0.015, 0.003, 0.0014, 0.0006]) * draws.uniform(0.7, 1.5) * draws.uniform(0.5, 1.2, 4)
        motion = motion - 1j * size[:, None] * shapes
        values[first:last] = (np.exp(np.outer(np.arange(last - first) / 5000, poles)) @ motion).real
        motion = motion * np.exp(poles * (last - first) / 5000)[:, None]
    values += 3e-4 * draws.standard_normal(values.shape)
    here.write("struck.csv", as_text(np.arange(9000) / 5000, values.T, "time [s],a [m],b [m],c [m]"))
    here.scene("struck", {"record": {"file": "struck.csv"}, "spectrum": {}})
    result = here.run("struck")
    away = abs(result["measured_angular_frequency"][: int(result["peak_count"])] - poles.imag)
    assert (away < WIDE * result["measured_angular_frequency_error"][: len(away)]).all()


@pytest.mark.parametrize(("second", "strength"), [(340, 0.7), (2800, 0.05)], ids=["double hit", "weak hit"])
def test_a_second_hit_that_is_early_or_weak(here, second, strength):
    """It comes a seventh of the lowest period after the first, or adds a twentieth of its motion."""
    rows, poles = np.arange(4500), -np.array([0.3, 0.9, 2.5]) + 2j * np.pi * np.array([7.3, 46.1, 128.8])
    decay = np.exp(np.outer(rows / 2000, poles)).imag @ [5, 1.5, 0.6]
    values = 0.005 * np.random.default_rng(3).standard_normal(len(rows))
    for first, size in ((300, 1), (second, strength)):
        values[first:] += size * decay[: len(rows) - first]
    here.write("twice.csv", as_text(rows / 2000, values[None], "time [s],a [m]"))
    here.scene("twice", {"record": {"file": "twice.csv"}, "spectrum": {}})
    result = here.run("twice")
    away = abs(result["measured_angular_frequency"][: int(result["peak_count"])] - poles.imag)
    assert (away < WIDE * result["measured_angular_frequency_error"][: len(away)]).all()


@pytest.mark.parametrize("seed", [30, 33])
def test_decays_at_uneven_times_in_coloured_noise_are_found(here, seed):
    """Clocks jitter by a tenth of a step, and both modes decay by 0.5 to 3 in the record."""
    draws = np.random.default_rng(seed)
    count, rate = int(draws.integers(120, 620)), 500.0
    time = (np.arange(count) + 0.2 * draws.uniform(-0.5, 0.5, count)) / rate
    colour = draws.uniform(0, 0.9)
    noise = lfilter([np.sqrt(1 - colour**2)], [1, -colour], draws.standard_normal(count + 99))[99:]
    modes = [draws.uniform(12, 60), draws.uniform(90, 200)]
    values = sum(a * np.exp(-draws.uniform(0.5, 3) * time * rate / count) * np.sin(2 * np.pi * f * time + 1)
                 for a, f in zip((1, 0.6), modes, strict=True))
    values += 10 ** (-draws.uniform(10, 40) / 20) * noise
    here.write("uneven.csv", as_text(time, values[None], "time [s],tip [m/s]"))
    here.scene("uneven", {"record": {"file": "uneven.csv"}, "spectrum": {}})
    result = here.run("uneven")
    away = abs(result["measured_angular_frequency"][:2] / (2 * np.pi) - modes)
    assert result["peak_count"] == 2
    assert (away < WIDE * result["measured_angular_frequency_error"][:2] / (2 * np.pi)).all()


def test_a_peak_that_noise_alone_seldom_has_is_a_rejected_candidate(here):
    """A tone with 13 times the power of the noise, where a line needs 15."""
    time = np.arange(2000) / 1000.0
    values = np.exp(-2 * time) * np.cos(2 * np.pi * 60 * time) + 0.008 * np.cos(2 * np.pi * 333.2 * time + 1)
    values += 0.05 * np.random.default_rng(2).standard_normal(time.size)
    here.write("weak.csv", as_text(time, values[None], "time [s],tip [m/s2]"))
    here.scene("weak", {"record": {"file": "weak.csv"}, "spectrum": {}})
    result = here.run("weak")
    assert (result["peak_count"], result["candidate_count"]) == (1, 1)
    assert abs(result["candidate_angular_frequency"][0] / (2 * np.pi) - 333.2) < 0.5  # what the record resolves
    assert 10.7 < result["candidate_ordinate"][0] < 15.3 and result["candidate_reason"][0] == 1


def test_a_force_that_is_taken_for_a_sensor_does_not_hide_the_line(here):
    """It is 0 but for one sample, and is left out."""
    time = np.arange(2000) / 1000.0
    ring = 100 * np.exp(-2 * time) * np.cos(2 * np.pi * 40 * time) + 0.5 * np.random.default_rng(3).standard_normal(time.size)
    here.write("force.csv", as_text(time, np.array([100.0 * (time == time[3]), ring]), "time [s],force,tip [m/s2]"))
    here.scene("force", {"record": {"file": "force.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "force.nml")
    result = here.result("force")
    assert (result["peak_count"], "constant: force (100 %)" in ended.stderr) == (1, True)
    assert abs(result["measured_angular_frequency"][0] / (2 * np.pi) - 40) < 2e-3


def test_a_sweep_of_a_shaker_is_no_free_decay(here):
    """Three modes that a sinus drives from below the first to above the last: what lines leave of it grows."""
    rate, count = 990.0, 500
    time = np.arange(count) / rate
    push = np.sin(2 * np.pi * (7.2 * time + 276.6 * time**2 / (2 * count / rate)))
    motion = np.zeros(count)
    for frequency, damping in [(14.4, 0.0145), (91.3, 0.0146), (258.0, 0.008)]:
        state, step = 0j, np.exp((-damping + 1j) * 2 * np.pi * frequency / rate)
        for sample in range(count):
            motion[sample] += state.imag
            state = step * state + push[sample]
    motion = motion / abs(motion).max() + 0.005 * np.random.default_rng(1).standard_normal(count)
    here.write("sweep.csv", "time,a [m/s]\n" + "".join(f"{t:.6f},{value:.6f}\n" for t, value in zip(time, motion)))
    here.scene("sweep", {"record": {"file": "sweep.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "sweep.nml")
    assert ended.returncode == 4
    assert "or these leave a residual that grows" in ended.stderr
    result = here.result("sweep")
    assert result["peak_count"] == 0
    assert result["candidate_ordinate"][0] > 100 and result["candidate_reason"][0] == 2  # white noise does not explain it


def test_two_modes_that_move_against_each_other_are_two_lines(here):
    """Both damped by 5 %, 3 % apart and opposite at the only sensor: their energies are 24 times that of the sum."""
    time = np.arange(2000) / 2000.0
    motion = sum(sign * np.exp(-0.05 * rate * time) * np.sin(rate * time) for sign, rate in [(1, 2 * np.pi * 100), (-1, 2 * np.pi * 103)])
    motion = motion + 1e-3 * abs(motion).max() * np.random.default_rng(1).standard_normal(time.size)
    here.write("pair.csv", "time,a [m/s]\n" + "".join(f"{t:.6f},{value:.9g}\n" for t, value in zip(time, motion)))
    here.scene("pair", {"record": {"file": "pair.csv"}, "spectrum": {}})
    result = here.run("pair")
    assert result["peak_count"] == 2
    np.testing.assert_allclose(result["measured_angular_frequency"][:2] / (2 * np.pi), [100, 103], atol=0.03)  # intervals are 0.014


def test_a_mode_stands_out_of_noise_behind_a_steep_filter(here):
    """A Butterworth filter of order 8 leaves no noise at all above its band; 60 dB, decay rate 2.4 1/s."""
    time = np.arange(2000) / 2000.0
    noise = lfilter(*butter(8, 0.16), np.random.default_rng(7).standard_normal(2400))[400:]
    motion = np.exp(-2.4 * time) * np.sin(2 * np.pi * 40 * time) + 1e-3 * noise / noise.std()
    here.write("filtered.csv", "time,a [m/s]\n" + "".join(f"{t:.6f},{value:.9g}\n" for t, value in zip(time, motion)))
    here.scene("filtered", {"record": {"file": "filtered.csv"}, "spectrum": {}})
    result = here.run("filtered")
    assert result["peak_count"] == 1
    assert abs(result["measured_angular_frequency"][0] / (2 * np.pi) - 40) < 1e-3
    assert abs(result["measured_decay_rate"][0] - 2.4) < 0.01


def wandering_phase(draws):
    """One mode whose phase wanders by 0.013 rad within the record, as friction or a clock lets it, in noise 80 dB below."""
    time = np.arange(4000) / 1000.0
    phase = 2e-4 * np.cumsum(draws.standard_normal(time.size))
    motion = np.exp(-1.2 * time) * np.sin(2 * np.pi * 40 * time + phase)
    return time, motion + 1e-4 * draws.standard_normal(time.size), [40.0]


def band_pass(draws):
    """A short cut of three modes, two of them strong, in noise behind a band pass."""
    time = np.arange(1600) / 8000.0
    noise = lfilter(*butter(4, [0.11, 0.2], "band"), draws.standard_normal(2600))[1000:]
    modes = [(4, 583, 1.02, 0.3), (1, 691, 3.7, 1.0), (0.5, 575, 2.2, 2.0)]
    motion = sum(a * np.exp(-d * time) * np.sin(2 * np.pi * f * time + p) for a, f, d, p in modes)
    return time, motion + 0.02 * noise / noise.std() + 1e-5 * draws.standard_normal(time.size), [583.0, 691.0]


@pytest.mark.parametrize("make, seed", [(wandering_phase, 0), (wandering_phase, 3), (band_pass, 2)])
def test_a_free_decay_that_the_model_does_not_fit_exactly_is_one(here, make, seed):
    """A phase that moves by 0.01 rad in a decay time of a second moves a frequency of 40 Hz by half of 1e-4."""
    time, motion, frequencies = make(np.random.default_rng(seed))
    here.write("real.csv", "time,a [m/s2]\n" + "".join(f"{t:.6f},{value:.7f}\n" for t, value in zip(time, motion)))
    here.scene("real", {"record": {"file": "real.csv"}, "spectrum": {}})
    result = here.run("real")
    found = result["measured_angular_frequency"][: int(result["peak_count"])] / (2 * np.pi)
    for frequency in frequencies:
        assert abs(found - frequency).min() < 1e-4 * frequency


def test_noise_that_rises_takes_no_lines_away(here):
    """A machine starts halfway: the noise is five times as large from there on, and still 20 dB below the motion."""
    time = np.arange(4001) / 1000.0
    draws = np.random.default_rng(1)
    motion = sum(a * np.exp(-d * time) * np.sin(2 * np.pi * f * time) for a, f, d in [(1.0, 40, 0.1), (0.7, 97, 0.15)])
    motion += 0.01 * draws.standard_normal(time.size) * np.where(time > 2, 5, 1)
    here.write("machine.csv", "time,a [mg]\n" + "".join(f"{t:.6f},{1e3 * value:.4f}\n" for t, value in zip(time, motion)))
    here.scene("machine", {"record": {"file": "machine.csv"}, "spectrum": {}})
    result = here.run("machine")
    found = result["measured_angular_frequency"][: int(result["peak_count"])] / (2 * np.pi)
    assert found == pytest.approx([40.0, 97.0], rel=1e-5)  # three Cramér–Rao bounds and more


def test_a_result_holds_what_its_pictures_show(ringing):
    _, result = ringing
    time, values = ring_down(1)
    np.testing.assert_allclose(result["recorded"], values, atol=1e-7)  # the digits of the text
    assert np.std(result["recorded"] - result["fitted"]) < 1.1 * NOISE
    assert result["time"].tolist() == pytest.approx(time.tolist())
    assert result["frequency"][-1] == RATE / 2
    at = np.searchsorted(result["frequency"], FREQUENCY)
    assert (result["amplitude"][:, at] > 10 * result["noise_level"][:, at]).all()
    quiet = result["frequency"] > 350.0
    level = result["noise_level"][:, quiet]
    np.testing.assert_allclose(np.sqrt((result["amplitude"][:, quiet] ** 2).mean()), level.mean(), rtol=0.15)
    windows = result["window_angular_frequency"][: FREQUENCY.size]
    there = ~results.is_fill(windows)
    assert there[:, 0].all()
    off = abs(windows - 2 * np.pi * FREQUENCY[:, None]) / result["window_angular_frequency_bound"][: FREQUENCY.size]
    assert off[there].max() < 5.0


def test_a_result_of_a_record_is_the_record(ringing):
    """What was fitted stands beside it, and has no noise: it is no sensor unless it is asked for."""
    here, result = ringing
    here.scene("again", {"record": {"file": "output/ring.nc"}, "spectrum": {}})
    again = here.run("again")
    assert again["measured_amplitude"].shape[0] == result["measured_amplitude"].shape[0]
    np.testing.assert_array_equal(again["measured_angular_frequency"], result["measured_angular_frequency"])
    np.testing.assert_array_equal(again["measured_angular_frequency_error"], result["measured_angular_frequency_error"])


def test_the_file_says_what_it_is_about(ringing):
    _, result = ringing
    assert result.attributes["method"] == "record"
    assert result.attributes["effects"] == ""
    assert result["point_position"].tolist() == [0.5, 1.0]
    assert result["sensor_name"].tolist() == ["mid [m/s2]", "tip [m/s2]"]
    assert result.variables["measured_amplitude"].attributes["units"] == "m s-2"
    simulated = {"mode", "event", "profile"} & set(result.sizes) | {"displacement", "mode_count"} & set(result.variables)
    assert not simulated


def test_the_report_is_a_table_of_lines(ringing):
    here, _ = ringing
    said = here.beamwave("run", "ring.nml").stdout
    assert "nothing to do" in said
    for k, frequency in enumerate(FREQUENCY, start=1):
        row = next(line.split() for line in said.splitlines() if line.startswith(f"{k:6d} "))
        assert abs(float(row[1]) - frequency) < WIDE * float(row[2])
        assert float(row[2]) > float(row[3])
    assert "Noise, standard deviation of the residual: mid 0.0" in said


def test_sensors_without_places_are_numbered(here):
    here.write("ring.csv", text_of(1))
    here.scene("ring", ASKED)
    result = here.run("ring")
    assert "point_position" not in result.variables
    assert result["point"].tolist() == [1, 2]
    assert "measured_wavenumber" not in result.variables


def test_noise_alone_has_no_line_and_says_so(here):
    here.write("ring.csv", as_text(np.arange(512) / RATE, np.random.default_rng(5).standard_normal((2, 512))))
    here.scene("ring", ASKED)
    ended = here.beamwave("run", "ring.nml")
    assert (ended.returncode, ended.stderr.count("no line: ")) == (0, 1)
    result = here.result("ring")
    assert result["peak_count"] == 0
    assert results.is_fill(result["measured_angular_frequency"]).all()


def test_short_records_of_any_length_come_to_an_end(here):
    """A drifting line is first looked at in a 64th of the record, which is less than a sample here."""
    for samples in range(20, 100):
        here.write("a.csv", text_of(samples, samples=samples))
        here.write("a.nml", "&record file = 'a.csv' /\n&spectrum /\n")
        ended = here.beamwave("run", "a.nml", "--overwrite", "--max-seconds", "20")
        assert ended.returncode in (0, 4), f"{samples} samples: {ended.stderr}"


def test_uneven_times_are_taken_as_they_are(here):
    dice = np.random.default_rng(7)
    times = (np.arange(700) + dice.uniform(-0.2, 0.2, 700)) / RATE
    times = np.delete(times, slice(200, 240))
    times -= times[0]
    here.write("ring.csv", text_of(3, times=times))
    here.scene("ring", ASKED)
    result = here.run("ring")
    assert result["peak_count"] == FREQUENCY.size
    away = lines_of(result, "measured_angular_frequency") / (2 * np.pi) - FREQUENCY
    assert (abs(away) < WIDE * lines_of(result, "measured_angular_frequency_error") / (2 * np.pi)).all()
    np.testing.assert_allclose(result["time"], times, atol=1e-8)


def test_repeats_and_sweeps_are_cases_with_the_bits_of_single_runs(here):
    """Files vary fastest; the axes of what is drawn are those of the longest case."""
    for name, seed, samples in [("a", 11, SAMPLES), ("b", 12, SAMPLES - 100)]:
        here.write(f"{name}.csv", text_of(seed, samples=samples))
    sweep = {"parameter": "record%end", "values": [0.5, 2.0]}
    here.scene("all", {"record": {"file": ["a.csv", "b.csv"]}, "spectrum": {}}, sweep)
    swept = here.run("all")
    assert swept["record_file"].tolist() == [1, 2, 1, 2]
    assert swept["record_end"].tolist() == [0.5, 0.5, 2.0, 2.0]
    for case in range(4):
        name = f"c{case}"
        here.scene(name, {"record": {"file": f"{'ab'[case % 2]}.csv", "end": [0.5, 2.0][case // 2]}, "spectrum": {}})
        alone = here.run(name)
        for variable, (dimensions, numbers, _) in alone.variables.items():
            if "time" in dimensions or "frequency" in dimensions or variable == "stage_seconds":
                continue
            there = swept[variable]
            if "case" in swept.variables[variable].dimensions:
                there = there[case]
            assert there.tobytes() == numbers.tobytes(), (case, variable)
        held = alone["recorded"].shape[1]
        assert swept["recorded"][case][:, :held].tobytes() == alone["recorded"].tobytes()
        assert results.is_fill(swept["recorded"][case][:, held:]).all()


def test_what_repeats_share_is_pooled(here):
    """Three repeats whose frequencies differ, each time by more than noise does; the last lacks the second line."""
    away = np.array([-0.1, 0.3, -0.2])  # Hz
    for k, shift in enumerate(away):
        time, noise = ring_down(30 + k)
        noise -= ring_down(30 + k, noise=0.0)[1]
        motion = np.exp(-np.outer(DECAY, time)) * np.cos(2 * np.pi * np.outer(FREQUENCY + shift, time))
        if k == 2:
            motion[1] = 0.0
        here.write(f"{k}.csv", as_text(time, AMPLITUDE @ motion + noise))
    here.scene("three", {"record": {"file": [f"{k}.csv" for k in range(3)]}, "spectrum": {}})
    result = here.run("three")
    assert result["pooled_count"][:4].tolist() == [3, 2, 3, 0]
    assert result["pooled_line"][:, :4].tolist() == [[1, 2, 3, 0], [1, 2, 3, 0], [1, 3, 0, 0]]
    frequency, error, following, scatter = (
        result[f"pooled_angular_frequency{part}"][:3] / (2 * np.pi) for part in ("", "_error", "_next", "_scatter")
    )
    assert results.is_fill(result["pooled_angular_frequency"][3:]).all()
    # Student's interval of the shifts, as noise moves frequencies by less than a twentieth of them
    spread = away.std(ddof=1)
    np.testing.assert_allclose(frequency - FREQUENCY, [0.0, 0.1, 0.0], atol=0.02)
    np.testing.assert_allclose(error[[0, 2]], 4.303 * spread / np.sqrt(3), rtol=0.1)
    np.testing.assert_allclose(following[[0, 2]], 4.303 * spread * np.sqrt(4 / 3), rtol=0.1)
    np.testing.assert_allclose(scatter[[0, 2]], spread, rtol=0.1)
    status = result["pooled_status"]
    assert (status[:3] & 2 > 0).all() and (status[:3] & 8 == 0).all() and (status[3:] == 0).all()
    assert (abs(result["pooled_decay_rate"][:3] - DECAY) < WIDE * result["pooled_decay_rate_error"][:3]).all()
    report = result.attributes["report"]
    assert "Pooled repeats" in report and "2 of 3" in report and "frequency scatters" in report


def test_what_repeats_drift_does_not_average_out(here):
    """All lines rise by 0.1 Hz along each of four records: the interval of all still reaches to both ends of that."""
    rise = 0.1  # Hz: twenty bounds of the strongest line, a tenth of what the record resolves
    for k in range(4):
        time, values = ring_down(50 + k)
        noise = values - ring_down(50 + k, noise=0.0)[1]
        turns = np.outer(FREQUENCY, time) + rise * time**2 / (2 * time[-1])
        motion = np.exp(-np.outer([0.5, 0.5, 0.5], time)) * np.cos(2 * np.pi * turns)
        here.write(f"{k}.csv", as_text(time, AMPLITUDE @ motion + noise))
    here.scene("four", {"record": {"file": [f"{k}.csv" for k in range(4)]}, "spectrum": {}})
    result = here.run("four")
    assert result["pooled_count"][:4].tolist() == [4, 4, 4, 0]
    assert (result["pooled_status"][:3] & 8 > 0).all() and re.search(r"   drifting *\n", result.attributes["report"])
    frequency, error, following = (result[f"pooled_angular_frequency{part}"][:3] / (2 * np.pi) for part in ("", "_error", "_next"))
    assert (frequency - error < FREQUENCY).all() and (frequency + error > FREQUENCY + rise).all()
    assert (error < 1.5 * rise).all() and (following < 0.2 * rise).all()


def test_a_drift_is_a_number_only_where_the_frequency_drifts(here):
    """One mode rises by 0.3 Hz in two seconds, and the decay rate of another by 4 1/s."""
    time = np.arange(2000) / 1000.0
    rising = np.exp(-1.5 * time) * np.cos(2 * np.pi * (60 * time + 0.3 * time**2 / 4))
    slowing = np.exp(-time - time**2) * np.cos(2 * np.pi * 150 * time + 1)
    noise = 0.01 * np.random.default_rng(1).standard_normal(time.size)
    here.write("drift.csv", as_text(time, (rising + slowing + noise)[None], "time [s],tip [m/s2]"))
    here.scene("drift", {"record": {"file": "drift.csv"}, "spectrum": {}})
    ended = here.beamwave("run", "drift.nml")
    rows = [line for line in ended.stdout.splitlines() if "; drifting" in line]
    by, half = re.search(r"; drifting by (\S+) \+/- (\S+) Hz$", rows[0]).groups()
    assert abs(float(by) - 0.3) < WIDE * float(half) < 0.05
    assert rows[1].endswith("; drifting")
    assert ended.stdout.count("Drift: ") == 1


def test_repeats_that_are_swept_too_are_not_pooled(here):
    for name, seed in [("a", 41), ("b", 42)]:
        here.write(f"{name}.csv", text_of(seed))
    sweep = {"parameter": "record%end", "values": [0.5, 1.0]}
    here.scene("swept", {"record": {"file": ["a.csv", "b.csv"]}, "spectrum": {}}, sweep)
    result = here.run("swept")
    assert "pooled" not in result.sizes and "pooled_count" not in result.variables
    assert "Pooled repeats" not in result.attributes["report"]


def test_a_changed_record_is_another_scene(here):
    here.write("ring.csv", text_of(1))
    here.scene("ring", ASKED)
    before = here.run("ring")
    assert "nothing to do" in here.beamwave("run", "ring.nml").stdout
    text = text_of(1)
    here.write("ring.csv", text[:-3] + "1\n" if text[-2] != "1" else text[:-3] + "2\n")
    ended = here.beamwave("run", "ring.nml")
    assert ended.returncode == 3
    assert "of another scene or version; --overwrite replaces it" in ended.stderr
    after = here.run("ring", "--overwrite")
    assert after.attributes["record_checksum"] != before.attributes["record_checksum"]


REPEATS = 12


def repeats(here):
    """Files, and the scene that has all of them."""
    for number in range(REPEATS):
        here.write(f"r{number}.csv", text_of(100 + number))
    here.scene("a", {"record": {"file": [f"r{number}.csv" for number in range(REPEATS)]}, "spectrum": {}})


def test_repeats_that_were_killed_go_on(here, injector):
    repeats(here)
    ended, _ = injector.run(here, "run", "a.nml", "--output", "killed", fault="fdatasync:3:kill")  # the result has no name yet
    assert ended.returncode == -signal.SIGKILL
    ended = here.beamwave("run", "a.nml", "--output", "killed")
    assert ended.returncode == 0, ended.stderr
    assert "taken over from an earlier run" in ended.stdout
    assert here.beamwave("run", "a.nml").returncode == 0
    assert results.differences(here.result("a", "killed"), here.result("a")) == []


def test_repeats_shared_by_processes_have_the_same_bits(here, processes):
    crew = processes(2)
    repeats(crew)
    assert crew.beamwave("run", "a.nml", "--output", "shared").returncode == 0
    assert here.beamwave("run", "a.nml").returncode == 0
    assert results.differences(here.result("a", "shared"), here.result("a")) == []


def test_a_changed_file_takes_unfinished_work_away(here):
    repeats(here)
    ended = here.beamwave("run", "a.nml", "--max-seconds", "0.3")
    if ended.returncode == 0:
        pytest.skip("a machine this fast is never stopped")
    assert ended.returncode == 5
    here.write("r0.csv", text_of(99))
    ended = here.beamwave("run", "a.nml")
    assert ended.returncode == 0
    assert "taken over" not in ended.stdout


@pytest.mark.parametrize("gaps", [0, 40])
def test_an_offset_and_a_slope_change_no_line(here, gaps):
    random = np.random.default_rng(1)
    times = np.arange(2000) / 1000
    since = np.maximum(times - 0.3, 0.0)
    quiet = 1e-3 * random.normal(size=len(times))
    ring = quiet + sum(a * np.exp(-d * since) * np.sin(2 * np.pi * f * since) for f, d, a in [(12, 0.6, 1), (75, 3, 0.6), (210, 7, 0.4)])
    kept = np.setdiff1d(np.arange(len(times)), random.integers(1, len(times) - 1, gaps))
    found = []
    for name, slope in {"level": 0.0, "sloping": 3.0}.items():
        rows = np.column_stack([times, ring + 7.0 * (slope > 0) + slope * times])[kept]
        here.write(f"{name}.csv", "time,a\n" + "".join(f"{t:.3f},{y:.12g}\n" for t, y in rows))
        here.scene(name, {"record": {"file": f"{name}.csv"}, "spectrum": {}})
        result = here.run(name)
        assert result["peak_count"] == 3
        found.append(result["measured_angular_frequency"][:3])
    assert found[1] == pytest.approx(found[0], rel=1e-9 if gaps == 0 else 1e-7)  # the fit's own steps end at other digits


def test_a_simulated_result_is_a_record(here):
    """Its lines are the modes of the beam with its mass."""
    response = {"duration": 0.4, "samples": 1024, "points": [0.5, 1.0]}
    here.scene("run", captured_beam(rotation=None, modes={"before": 4, "after": 4}, damping={"ratio": 0.001}, response=response))
    modes = here.run("run")
    here.scene("again", {"record": {"file": "output/run.nc"}, "spectrum": {}})
    lines = here.run("again")
    found = lines["measured_angular_frequency"]
    for beta in modes["angular_frequency"]:
        nearest = abs(found - beta).argmin()
        assert abs(found[nearest] - beta) < max(lines["measured_angular_frequency_error"][nearest], 1e-9 * beta)


BAD = {  # what is wrong with the second file, status, what standard error begins with
    "a word": (text_of(2) + "9.0,off,1.0\n", 3, "b.csv:1026: column 2 (mid [m/s2]): 'off' is not a finite number"),
    "other sensors": ("time,tip\n" + "".join(f"{j / 100},{j % 7}\n" for j in range(60)), 2, "b.csv: its sensors (displacement"),
    "nothing there": (None, 3, "b.csv: cannot be read: "),
}


@pytest.mark.parametrize("case", BAD.values(), ids=BAD.keys())
def test_a_bad_repeat_is_refused_before_any_work(here, case):
    text, status, said = case
    here.write("a.csv", text_of(1))
    if text is not None:
        here.write("b.csv", text)
    here.scene("ring", {"record": {"file": ["a.csv", "b.csv"]}, "spectrum": {}})
    ended = here.beamwave("run", "ring.nml")
    assert (ended.returncode, len(ended.stderr.splitlines())) == (status, 1), ended.stderr
    assert ended.stderr.startswith(said)
    assert not (here.directory / "output").exists()


def test_a_part_that_is_too_short_is_refused_before_any_work(here):
    here.write("ring.csv", text_of(1))
    here.write("ring.nml", namelist(ASKED, {"parameter": "record%end", "values": [0.5, 0.01]}))
    ended = here.beamwave("run", "ring.nml")
    assert ended.returncode == 2
    assert ended.stderr.startswith("ring.nml: &sweep: of ring.csv 11 samples remain up to end = 0.01; accepted: 16 or more")
    assert not (here.directory / "output").exists()


@pytest.mark.parametrize("command", ["accuracy", "effects"])
def test_studies_are_about_simulated_histories(here, command):
    here.write("ring.csv", text_of(1))
    here.scene("ring", ASKED)
    ended = here.beamwave(command, "ring.nml")
    assert (ended.returncode, len(ended.stderr.splitlines())) == (2, 1)
    assert ended.stderr.startswith("ring.nml: &record: ")
    assert here.left(".") == ["ring.csv", "ring.nml"]


@pytest.mark.parametrize("seed", [2, 3, 5, 18, 74])
def test_what_may_have_any_frequency_or_one_beyond_the_band_is_no_line(here, seed):
    """Something at the blow that is gone after two samples, as an imperfect filter leaves it."""
    rng, n, rate = np.random.default_rng(seed), np.arange(4096), 1000.0
    values = np.exp(-3 * n / rate) * np.cos(2 * np.pi * 40 * n / rate) + 0.5 * np.exp(-9 * n / rate) * np.cos(2 * np.pi * 130 * n / rate + 1)
    values += rng.uniform(0.5, 2) * np.exp(-rng.uniform(0.5, 1.5) * n) * np.cos(np.pi * n * rng.uniform(0.9, 1))
    values = np.concatenate([np.zeros(200), values]) + 1e-3 * rng.standard_normal(n.size + 200)
    here.write("ring.csv", as_text(np.arange(values.size) / rate, values[None, :], "time [s],tip [m]"))
    here.scene("a", {"record": {"file": "ring.csv"}, "spectrum": {}})
    ds = here.run("a")
    frequency, error = (ds[name][ds["measured_angular_frequency"] < 1e30] / (2 * np.pi) for name in ("measured_angular_frequency", "measured_angular_frequency_error"))
    assert (frequency + error < rate / 2).all() and all(np.abs(frequency - mode).min() < 0.01 for mode in (40, 130))
