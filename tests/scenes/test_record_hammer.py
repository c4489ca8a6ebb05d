"""A hammer's measured force turns amplitudes into modal constants, frequency responses and kilograms.

The records are sums over the modes of a clamped beam, its closed form, each moved by the force step by step on a grid eight times as
fine as the samples: no part of the program is in them.
"""

import numpy as np
import pytest
import results
from scipy.optimize import brentq
from scipy.signal import lfilter
from workplace import namelist

BEAM = {"length": 0.6, "width": 0.03, "height": 0.006, "density": 2700.0, "youngs_modulus": 7e10}
LENGTH, MASS = 0.6, 2700 * 0.03 * 0.006 * 0.6  # m, kg
H = np.sqrt(7e10 * 0.006**2 / 12 / 2700)  # m²/s
POINTS, STRUCK = [0.5, 0.8, 1.0], 0.8
RATE, SAMPLES, FINE = 8192, 16384, 8
MODES = 6
ALPHA = np.array(
    [brentq(lambda a: np.cos(a) + 1 / np.cosh(a), (k - 0.5) * np.pi - 0.4, (k - 0.5) * np.pi + 0.4) for k in range(1, MODES + 1)]
)
FREQUENCY = H * (ALPHA / LENGTH) ** 2  # rad/s
DERIVATIVE = {"displacement": 0, "velocity": 1, "acceleration": 2}
UNIT = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2"}


def shapes(xi):
    """Of mean square 1, (places, modes)."""
    z = np.outer(np.atleast_1d(xi), ALPHA)
    sigma = (np.cosh(ALPHA) + np.cos(ALPHA)) / (np.sinh(ALPHA) + np.sin(ALPHA))
    return np.cosh(z) - np.cos(z) - sigma * (np.sinh(z) - np.sin(z))


CONSTANT = shapes(POINTS) * shapes(STRUCK) / MASS  # 1/kg, (sensors, modes)


def poles(damping):
    return -damping * FREQUENCY + 1j * FREQUENCY * np.sqrt(1 - damping**2)


def struck(dice, quantity, damping=0.004, noise=0.01, unit="N", scale=1.0, later=(), gains=(1, 1, 1), spoil=None):
    """A text of time, force with an offset, and sensors."""
    time = np.arange(SAMPLES * FINE) / (RATE * FINE)
    start, length, peak = 0.05 + 0.01 * dice.random(), 0.0012 + 0.0006 * dice.random(), 50 * (1 + dice.random())
    phase = np.clip((time - start) / length, 0, 1)
    force = peak * np.sin(np.pi * phase) ** 2
    for delay in later:
        force = force + 0.6 * np.roll(force, round(delay * RATE * FINE))
    values = np.zeros((len(POINTS), SAMPLES))
    for k, pole in enumerate(poles(damping)):
        step = np.exp(pole * time[1])
        drive = time[1] / 2 * (force + step * np.roll(force, 1))
        state = lfilter([1], [1, -step], drive.astype(complex))[::FINE]
        moved = np.imag(pole ** DERIVATIVE[quantity] * state) / pole.imag
        moved += force[::FINE] if quantity == "acceleration" else 0
        values += np.outer(CONSTANT[:, k], moved)
    values += noise * values.std(axis=1, keepdims=True) * dice.standard_normal(values.shape)
    force = (force[::FINE] + 0.002 * peak * dice.standard_normal(SAMPLES) + 3.0) / scale
    if spoil:
        spoil(force, values)
    head = f"time [s],force [{unit}]," + ",".join(f"s{i} [{UNIT[quantity]}]" for i in range(len(POINTS)))
    rows = np.column_stack([time[::FINE], force, values.T * gains])
    return head + "\n" + "\n".join(",".join(f"{x:.10g}" for x in row) for row in rows) + "\n"


def hammered(here, quantity, repeats=3, seed=1, unknowns=(), groups=None, status=(0,), **options):
    dice = np.random.default_rng(seed)
    files = [f"{i}.csv" for i in range(repeats)]
    for name in files:
        here.write(name, struck(dice, quantity, **options))
    record = {"file": files if repeats > 1 else files[0], "force": "force", "force_point": STRUCK, "points": POINTS}
    scene = namelist({"beam": BEAM, **(groups or {}), "record": record, "spectrum": {}})
    here.write("hammer.nml", scene + "".join(namelist({"identify": unknown}) for unknown in unknowns))
    ended = here.beamwave("run", "hammer.nml", "--verbose")
    assert ended.returncode in status, ended.stderr
    return here.result("hammer"), ended


@pytest.mark.parametrize("quantity, later", [*((name, ()) for name in UNIT), ("velocity", [0.03]), ("acceleration", [0.7])])
def test_modal_constants_are_inside_their_intervals(here, quantity, later):
    """After one hit, after two that follow each other at once, and after the first of two blows."""
    result, ended = hammered(here, quantity, later=later)
    lines = result["measured_angular_frequency"]
    real, imag, error = (result[f"measured_modal_constant_{part}"] for part in ("real", "imag", "error"))
    off = []
    for case, line in np.argwhere(~results.is_fill(lines)):
        mode = np.abs(FREQUENCY - lines[case, line]).argmin()
        off.append((real[case, :, line] - CONSTANT[:, mode]) / error[case, :, line])
        off.append(imag[case, :, line] / error[case, :, line])
    off = np.abs(np.concatenate(off))
    assert off.size >= 2 * 3 * 3 * 4
    assert np.mean(off < 1) >= 0.88 and off.max() < 2.5  # 95 % of some hundred, and three deviations
    best = np.nanmin(np.where(results.is_fill(real), np.nan, error / np.abs(real)))
    assert best < 0.01
    assert "Frequency response over the repeats" in ended.stdout
    check_reported_constants(ended.stdout)


def check_reported_constants(report):
    """The report of repeats has the constant of each line at the sensor that tells it best, within three half intervals."""
    table = report.split("Modal constants from all repeats")[1].split("\n\n")[0].splitlines()[3:]
    rows = [row.split() for row in table]
    assert len(rows) >= 3
    pooled = report.split("Pooled repeats")[1].split("\n\n")[0].splitlines()[3:]
    lines = {row.split()[0]: 2 * np.pi * float(row.split()[4]) for row in pooled}
    for line, constant, error, *_, mass, sensor in rows:
        mode = np.abs(FREQUENCY - lines[line]).argmin()
        true = CONSTANT[int(sensor[1:]), mode]
        assert abs(float(constant) - true) < 3 * float(error)
        assert float(mass) == pytest.approx(1 / abs(float(constant)), rel=0.02)


def exact_response(result, quantity):
    """At the modes 2 to 5 of a beam with a damping of 0.02: their places in the result, and the response there."""
    frequency = 2 * np.pi * result["frequency"]
    top = [np.abs(frequency - beta).argmin() for beta in FREQUENCY[1:5]]
    omega = frequency[top, None]
    return top, (1j * omega) ** DERIVATIVE[quantity] / (FREQUENCY**2 - omega**2 + 2j * 0.02 * FREQUENCY * omega) @ CONSTANT.T


def test_the_frequency_response_is_that_of_the_beam_and_coherent(here):
    """Damped so much that all has died within the record: nothing leaks."""
    result, _ = hammered(here, "acceleration", damping=0.02, noise=0.002)
    top, exact = exact_response(result, "acceleration")
    for name in ("h1", "h2"):
        found = result[f"pooled_response_{name}_real"] + 1j * result[f"pooled_response_{name}_imag"]
        np.testing.assert_allclose(found[:, top].T, exact, atol=0.02 * np.abs(exact).max())
    assert (result["pooled_coherence"][:, top] > 0.99).all()
    assert ((result["pooled_coherence"] <= 1 + 1e-12) | results.is_fill(result["pooled_coherence"])).all()


def spoil_decay(force, values):
    """One sensor has a spike, another is stuck."""
    after = np.flatnonzero(force > force.max() / 10)[-1] + 8
    values[1, after + 100 : after + 200] = values[1, after + 100]
    values[0, after + 300] = 1e4 * abs(values[0]).max()


def test_flawed_samples_after_the_blow_leave_the_frequency_response_as_it_is(here):
    result, ended = hammered(here, "velocity", repeats=1, damping=0.02, noise=0.002, spoil=spoil_decay)
    assert "constant: s1" in ended.stderr and "spike: s0" in ended.stderr
    top, exact = exact_response(result, "velocity")
    found = result["frequency_response_real"] + 1j * result["frequency_response_imag"]
    np.testing.assert_allclose(found[:, top].T, exact, atol=0.02 * np.abs(exact).max())


def test_a_sensor_that_is_overloaded_by_the_blow_has_constants_but_no_response(here):
    def spoil(force, values):
        hit = np.flatnonzero(force > force.max() / 2)
        values[1, hit[0] : hit[-1] + 1] = 3 * abs(values[1]).max()

    result, ended = hammered(here, "velocity", repeats=2, spoil=spoil)
    assert "hammer: s1 [m/s] has missing, clipped or constant samples or spikes during a blow" in ended.stderr
    known = ~results.is_fill(result["frequency_response_real"][:, :, 1:])
    assert known[:, [0, 2]].all() and not known[:, 1].any()
    known = ~results.is_fill(result["pooled_coherence"][:, 1:])
    assert known[[0, 2]].all() and not known[1].any()
    count = result["peak_count"][0]
    mode = np.abs(FREQUENCY - result["measured_angular_frequency"][0, :count, None]).argmin(axis=1)
    away = result["measured_modal_constant_real"][0, :, :count] - CONSTANT[:, mode]
    assert count >= 4
    assert np.all(np.abs(away) < 2 * result["measured_modal_constant_error"][0, :, :count])


def test_a_number_that_is_missing_during_the_blow_costs_no_force(here):
    text = struck(np.random.default_rng(1), "velocity").splitlines()
    force = np.array([float(row.split(",")[1]) for row in text[1:]])
    hit = 1 + int(force.argmax())
    for row in (hit - 1, hit):
        text[row] = ",".join([*text[row].split(",")[:2], "", *text[row].split(",")[3:]])
    here.write("one.csv", "\n".join(text) + "\n")
    record = {"file": "one.csv", "force": "force", "force_point": STRUCK, "points": POINTS}
    here.scene("hammer", {"beam": BEAM, "record": record, "spectrum": {}})
    result = here.run("hammer")
    assert result["peak_count"] >= 4
    away = result["measured_modal_constant_real"][:, :4] - CONSTANT[:, :4]
    assert np.all(np.abs(away) < 2 * result["measured_modal_constant_error"][:, :4])


@pytest.mark.parametrize("limit", [0.8, 1])
def test_a_force_is_said_to_be_clipped_if_it_is(here, limit):
    def spoil(force, values):
        np.minimum(force, limit * force.max(), out=force)

    _, ended = hammered(here, "velocity", repeats=1, spoil=spoil)
    words = "samples, so that modal constants and frequency responses are too large"
    assert (words in " ".join(ended.stderr.split())) == (limit < 1)
    assert ("clipped" in ended.stderr) == (limit < 1)


@pytest.mark.parametrize("quantity", ["velocity", "acceleration"])
def test_a_blow_whose_force_is_not_known_may_last(here, quantity):
    """The hammer touches the beam during 10 to 15 samples: they are left out, and every line is a mode."""
    here.write("one.csv", struck(np.random.default_rng(5), quantity, noise=0.001))
    here.scene("blow", {"record": {"file": "one.csv", "columns": ["s0", "s1", "s2"]}, "spectrum": {}})
    ended = here.beamwave("run", "blow.nml", "--verbose")
    assert (ended.returncode, "contact: the first " in ended.stdout) == (0, True), ended.stderr
    result = here.result("blow")
    count = result["peak_count"]
    found = result["measured_angular_frequency"][:count]
    damped = poles(0.004).imag
    mode = np.abs(damped - found[:, None]).argmin(axis=1)
    assert count >= 4 and len(set(mode)) == count
    assert np.all(np.abs(found - damped[mode]) < 2 * result["measured_angular_frequency_error"][:count])


def test_masses_come_in_kilograms(here):
    """Frequencies alone know E over density; the blow knows the density itself."""
    unknowns = [
        {"parameter": "beam%density", "first": 2000, "last": 4000},
        {"parameter": "beam%youngs_modulus", "first": 5e10, "last": 9e10},
    ]
    result, ended = hammered(here, "velocity", repeats=2, unknowns=unknowns, seed=3)
    assert "calibration" not in ended.stderr
    value, error = result["identified"], result["identified_error"]
    assert (np.abs(value - [2700, 7e10]) <= 1.5 * error).all()
    assert (error < 0.02 * value).all()


MODULUS = {"parameter": "beam%youngs_modulus", "first": 5e10, "last": 9e10}
DENSITY = {"parameter": "beam%density", "first": 700, "last": 20000}


@pytest.mark.parametrize("unknowns", [(), (MODULUS,), (DENSITY,)], ids=["nothing", "modulus", "density"])
@pytest.mark.parametrize(
    "fault, words",
    [
        ({"gains": (1, -1, 1)}, "sensor s1 seems to be reversed: with factor -1 "),
        ({"scale": -1.0}, "the force or all sensors seem to be reversed: with factor -1 "),
        ({"gains": (1 / 9.80665,) * 3}, "the force or all sensors seem to be of another scale: with factor 9.8"),
    ],
    ids=["a sensor", "the hammer", "in g"],
)
def test_a_sensor_or_hammer_that_is_reversed_or_of_another_scale_is_named(here, fault, words, unknowns):
    """Whether or not its sign leads the unknowns astray; sensors that are right are not named."""
    _, ended = hammered(here, "acceleration", repeats=1, unknowns=unknowns, status=(0, 4), **fault)
    assert words in ended.stderr
    assert ended.stderr.count("seem") == 1
    assert ("accelerations in g" in ended.stderr) == ("9.8" in words)


def test_a_force_in_other_units_is_brought_to_newtons(here):
    result, _ = hammered(here, "velocity", repeats=1, unit="kN", scale=1000.0)
    assert abs(result["measured_modal_constant_real"][1, 0] / CONSTANT[1, 0] - 1) < 0.02


def test_a_force_that_is_none_is_refused_with_its_place(here):
    dice = np.random.default_rng(1)
    here.write("one.csv", struck(dice, "velocity", unit="V"))
    here.write("two.csv", struck(dice, "velocity"))
    for name, force, words in (
        ("one", "force", "is in 'V', which is no unit of force; accepted: N, mN, kN, lbf"),
        ("two", "hammer", "'hammer' is no column"),
        ("two", "s1", "is also the time or a sensor"),
    ):
        here.scene("bad", {"record": {"file": f"{name}.csv", "columns": ["s0", "s1"], "force": force}, "spectrum": {}})
        ended = here.beamwave("check", "bad.nml")
        assert ended.returncode == 2 and "record%force: " in ended.stderr and words in ended.stderr, ended.stderr
    here.scene("bad", {"record": {"file": "two.csv", "force_point": 0.5}, "spectrum": {}})
    ended = here.beamwave("check", "bad.nml")
    assert ended.returncode == 2 and "record%force_point: is given without force" in ended.stderr


@pytest.mark.parametrize("quantity", UNIT)
def test_the_model_of_the_beam_has_a_response_beside_the_measured_one(here, quantity):
    _, ended = hammered(here, quantity, groups={"damping": {"ratio": 0.004}})
    result = here.result("hammer")
    frequency = result["frequency"][1:]
    found = (result["modelled_response_real"] + 1j * result["modelled_response_imag"])[0, :, 1:]  # of the first repeat
    omega = 2 * np.pi * frequency[:, np.newaxis]
    k = np.arange(1, 2001)
    alpha = np.concatenate([ALPHA, (k[MODES:] - 0.5) * np.pi])
    beta = H * (alpha / LENGTH) ** 2
    terms = (1j * omega) ** DERIVATIVE[quantity] / (beta**2 - omega**2 + 0.008j * beta * omega) / MASS
    # shapes of high modes without exponentials that grow: e^(-αξ) and, at the tip, e^(-α(1-ξ)) beside cos and sin
    odd = (-1.0) ** k
    phi = lambda xi: np.sin(alpha * xi) - np.cos(alpha * xi) + np.exp(-alpha * xi) - odd * np.exp(-alpha * (1 - xi))  # noqa: E731
    for s, xi in enumerate(POINTS):
        exact = shapes(xi)[0] * shapes(STRUCK)[0]
        products = np.concatenate([exact, (phi(xi) * phi(STRUCK))[MODES:]])
        expected = terms @ products
        assert np.abs(found[s] - expected).max() <= 1e-6 * np.abs(expected).max()
    assert results.is_fill(result["modelled_response_real"][0, :, 0]).all()
