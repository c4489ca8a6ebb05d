"""Waves of records and of simulated histories follow the ends that the scene gives its beam: held, carried and struck anywhere.

References are the modes of the simulated scene, which other tests hold against tables, and of records a beam whose root turns in a
spring, from its own frequency equation.
"""

import numpy as np
import pytest
import results
from ring_downs import as_text
from scipy.optimize import brentq
from workplace import PAPER_BEAM

RESPONSE = {"duration": 1.0, "samples": 65536, "points": [0.5, 1.0]}
SIMULATED = {
    "held and carried": {
        "beam": PAPER_BEAM,
        "support": {"stiffness": 1e7, "rotational_stiffness": 5e4},
        "body": {"position": 0.4, "mass": 1.0, "rotary_inertia": 0.002},
        "impact": {"mass_ratio": 0.2, "position": 0.7},
        "capture": {},
        "modes": {"before": 12, "after": 12},
    },
    "pieces that rotate": {
        "beam": {**PAPER_BEAM, "length": [0.4, 0.6], "diameter": [0.037, 0.03]},
        "rotation": {"angular_velocity": 66.0},
        "body": {"position": 1.0, "mass": 1.0, "rotary_inertia": 0.002},
        "impact": {"mass_ratio": 0.2, "position": 0.3},
        "modes": {"before": 12},
    },
    "a short piece at the tip": {
        "beam": PAPER_BEAM,
        "body": {"position": 0.999, "mass": 1.0, "rotary_inertia": 0.002},
        "impact": {"mass_ratio": 0.2, "position": 0.7},
        "modes": {"before": 12},
    },
    "many pieces": {
        "beam": {**PAPER_BEAM, "length": [0.05] * 20, "diameter": [0.03 + 0.001 * (7 * i % 11) for i in range(20)]},
        "impact": {"mass_ratio": 0.2, "position": 0.7},
        "modes": {"before": 12},
    },
    "a mass that turns": {
        "beam": PAPER_BEAM,
        "rotation": {"angular_velocity": 30.0},
        "impact": {"mass_ratio": 0.2},
        "capture": {"rotary_inertia": 0.05},
        "modes": {"before": 12, "after": 12},
    },
}


@pytest.mark.parametrize("name", SIMULATED)
def test_waves_are_measured_in_beams_of_parts_that_are_struck_anywhere(here, name):
    here.scene("parts", {**SIMULATED[name], "response": RESPONSE, "spectrum": {}})
    result = here.run("parts")
    found = int(result["peak_count"])
    assert found >= 10
    modes = [np.abs(result["angular_frequency"] - peak).argmin() for peak in result["measured_angular_frequency"][:found]]
    for wave in ("wavenumber", "phase_velocity", "group_velocity"):
        value, error = result[f"measured_{wave}"][:found], result[f"measured_{wave}_error"][:found]
        true = result[wave][modes]
        np.testing.assert_allclose(value, true, rtol=1e-8 if wave == "wavenumber" else 1e-6)
        assert (np.abs(value - true) <= error + 1e-14 * true).all(), wave


def test_a_folded_line_in_a_peaks_own_place_is_in_its_bound(here):
    """Mode 7 is folded to within 0.03 periods of mode 4, and too near to be seen."""
    record = {"duration": 0.07566670336036445, "samples": 297, "points": [0.5, 1.0]}
    scene = {"rotation": {"angular_velocity": 66.77038598918202}, "impact": {"mass_ratio": 0.010164867759727659}, "capture": {}}
    here.scene("folded", {"beam": PAPER_BEAM, **scene, "response": record, "spectrum": {}})
    result = here.run("folded")
    fourth = np.abs(result["measured_angular_frequency"] - result["angular_frequency"][3]).argmin()
    value, error = result["measured_wavenumber"][fourth], result["measured_wavenumber_error"][fourth]
    assert results.is_fill(value) or abs(value - result["wavenumber"][3]) <= error
    assert np.count_nonzero(~results.is_fill(result["measured_wavenumber"])) >= 4


BEAM = {"length": 0.6, "width": 0.03, "height": 0.006, "density": 2700.0, "youngs_modulus": 7e10}
STIFFNESS = 7e10 * 0.03 * 0.006**3 / 12
H = np.sqrt(STIFFNESS / (2700 * 0.03 * 0.006))
MODES = 4
NOISE = 0.01  # of the standard deviation of each sensor's motion


class SoftRoot:
    """A beam whose root turns in a spring of κ EI/l, with a mass of γ times its own at the tip."""

    def __init__(self, kappa, gamma):
        self.kappa, self.gamma = kappa, gamma
        grid = np.linspace(0.3, 15, 3000)
        sign = np.sign([self.lack(alpha) for alpha in grid])
        ends = np.flatnonzero(sign[1:] != sign[:-1])[:MODES]
        self.alpha = np.array([brentq(self.lack, grid[i], grid[i + 1], xtol=1e-14) for i in ends])
        self.wavenumber = self.alpha / BEAM["length"]
        self.frequency = H * self.wavenumber**2

    def parts(self, alpha, xi, order):
        """Derivatives over αⁿ of the two functions that the root allows, with v(0) = 0 and l v''(0) = κ v'(0)."""
        z = alpha * xi
        turned = [np.cos, lambda z: -np.sin(z), lambda z: -np.cos(z), np.sin][order](z)
        sine = [np.sin, np.cos, lambda z: -np.sin(z), lambda z: -np.cos(z)][order](z)
        cosh, sinh = (np.cosh(z), np.sinh(z)) if order % 2 == 0 else (np.sinh(z), np.cosh(z))
        share = -self.kappa / (2 * alpha) * (turned - cosh)
        return np.array([share + sine, share + sinh])

    def tip(self, alpha):
        shear = self.parts(alpha, 1.0, 3) + self.gamma * alpha * self.parts(alpha, 1.0, 0)
        return self.parts(alpha, 1.0, 2) / np.cosh(alpha), shear / np.cosh(alpha)

    def lack(self, alpha):
        moment, shear = self.tip(alpha)
        return moment[0] * shear[1] - moment[1] * shear[0]

    def shape(self, alpha, xi):
        moment, _ = self.tip(alpha)
        factors = np.array([moment[1], -moment[0]])
        shape = factors @ self.parts(alpha, np.asarray(xi), 0)
        return shape / (factors @ self.parts(alpha, 1.0, 0))

    def text(self, points, seed, modes=MODES, shared=0.0):
        """Velocities after a blow, with noise of each sensor and some that all share."""
        time = np.arange(16384) / 8192
        motion = np.zeros((len(points), time.size))
        for k, (alpha, frequency) in enumerate(zip(self.alpha[:modes], self.frequency)):
            ring = np.exp(-0.003 * frequency * time) * np.sin(frequency * np.sqrt(1 - 0.003**2) * time + k) * frequency / (k + 1)
            motion += np.outer(self.shape(alpha, points), ring)
        noise = NOISE * motion.std(axis=1, keepdims=True)
        dice = np.random.default_rng(seed)
        motion += noise * (dice.standard_normal(motion.shape) + shared * dice.standard_normal(time.size))
        return as_text(time, motion, "time," + ",".join(f"s{i}" for i in range(len(points))))


def waves_of(here, beam, points, scene=None, modes=MODES, seed=1, **spectrum):
    """The result and standard error of a run, and the numbers of the modes that its lines are."""
    here.write("soft.csv", beam.text(points, seed, modes))
    record = {"file": "soft.csv", "quantity": "velocity", "points": points}
    here.scene("soft", {"beam": BEAM, **(scene or {}), "record": record, "spectrum": spectrum})
    ended = here.beamwave("run", "soft.nml")
    assert ended.returncode in (0, 4), ended.stderr
    result = here.result("soft")
    lines = result["measured_angular_frequency"][: int(result["peak_count"])]
    return result, ended, [np.abs(beam.frequency - line).argmin() for line in lines]


def misses(result, beam, modes):
    """How far the wave numbers are off, in half intervals; none where no interval is claimed."""
    count = len(modes)
    value, error = result["measured_wavenumber"][:count], result["measured_wavenumber_error"][:count]
    claimed = ~results.is_fill(value) & ~results.is_fill(error)
    return (np.abs(value - beam.wavenumber[modes]) / error)[claimed]


@pytest.mark.parametrize("kappa", [20.0, 1600.0])
def test_the_scenes_own_ends_are_the_default_and_give_the_waves(here, kappa):
    beam = SoftRoot(kappa, 0.05)
    support = {"support": {"rotational_stiffness": kappa * STIFFNESS / BEAM["length"]}}
    result, ended, modes = waves_of(here, beam, [0.3, 0.6, 1.0], support)
    off = misses(result, beam, modes)
    assert off.size == MODES and (off < 2).all()
    assert (result["measured_wavenumber_error"][1:MODES] < 1e-3 * beam.wavenumber[1:]).all()
    assert "sqrt(EI/(rho A))" not in ended.stderr
    assert "ends = 'model'" in result.attributes["scene"]
    np.testing.assert_allclose(float(result["measured_stiffness_root"]), H, rtol=1e-3)


@pytest.mark.parametrize("points", [[0.5, 1.0], [0.3, 0.6, 1.0]], ids=["a pair", "three"])
def test_a_clamp_that_gives_moves_no_wave_number_out_of_its_interval(here, points):
    """The scene takes it for rigid. That makes the beam seem longer, which its own √(EI/ρA) shows."""
    beam = SoftRoot(1600.0, 0.05)
    result, ended, modes = waves_of(here, beam, points)
    assert (misses(result, beam, modes) < 1.5).all()
    assert "ends = 'tip'" in result.attributes["scene"]
    assert "sqrt(EI/(rho A)) of the waves" in ended.stderr and "intervals are widened to hold both" in ended.stderr


def test_a_material_that_is_off_is_warned_of(here):
    beam = SoftRoot(1e9, 0.05)
    result, ended, modes = waves_of(here, beam, [0.3, 0.6, 1.0], {"beam": {**BEAM, "youngs_modulus": 6.5e10}})
    assert (misses(result, beam, modes) < 2).all()
    assert "differs from that of the scene, 8.4984," in ended.stderr and "intervals are widened" not in ended.stderr
    np.testing.assert_allclose(float(result["measured_stiffness_root"]), H, rtol=1e-3)


def test_a_pair_whose_lines_confirm_nothing_claims_no_interval(here):
    beam = SoftRoot(1e9, 0.0)
    result, ended, _ = waves_of(here, beam, [0.3, 0.5], modes=1)
    count = int(result["peak_count"])
    assert results.is_fill(result["measured_wavenumber_error"][:count]).all()
    assert results.is_fill(result["measured_stiffness_root_error"])
    assert "no intervals" in ended.stdout or "fit equally well" in ended.stdout


def test_other_ends_are_fitted_where_they_are_named(here):
    """The body lies beyond all sensors, between which the motion is that of any piece of beam."""
    beam = SoftRoot(20.0, 0.05)
    body = {"body": {"position": 1.0, "mass_ratio": 0.05}}
    result, _, modes = waves_of(here, beam, [0.2, 0.35, 0.5, 0.65, 0.8, 0.95], body, ends="any")
    off = misses(result, beam, modes)
    assert off.size >= 2 and (off < 2).all()


CLAMP = 20.0 * STIFFNESS / BEAM["length"]
UNKNOWN = {"parameter": "support%rotational_stiffness", "first": CLAMP / 100, "last": 1000 * CLAMP}


def held(stiffness):
    return {"support": {"rotational_stiffness": stiffness}, "body": {"position": 1.0, "mass_ratio": 0.05}}


@pytest.mark.parametrize("repeats", [1, 2])
def test_waves_follow_from_the_identified_ends_and_not_from_the_guess(here, repeats):
    """The guess is a clamp a hundred times as stiff; the true wave number is that of the frequency by the dispersion relation."""
    beam = SoftRoot(20.0, 0.05)
    points = [0.3, 0.6, 0.9]
    for i in range(repeats):
        here.write(f"{i}.csv", beam.text(points, seed=i))
    files = [f"{i}.csv" for i in range(repeats)]
    record = {"file": files if repeats > 1 else files[0], "quantity": "velocity", "points": points}
    here.scene("soft", {"beam": BEAM, **held(100 * CLAMP), "record": record, "spectrum": {}, "identify": UNKNOWN})
    ended = here.beamwave("run", "soft.nml")
    assert ended.returncode == 0 and "measured waves" not in ended.stderr, ended.stderr
    result = here.result("soft")
    assert abs(result["identified"][0] / CLAMP - 1) < 1e-3
    for lines, value, error in zip(*(np.atleast_2d(result[f"measured_{name}"])
                                     for name in ("angular_frequency", "wavenumber", "wavenumber_error"))):
        true = np.sqrt(lines[:MODES] / H)
        assert (np.abs(value[:MODES] - true) < 2 * error[:MODES]).all()
        assert (error[1:MODES] < 1e-3 * true[1:]).all()
    np.testing.assert_allclose(result["measured_stiffness_root"], H, rtol=1e-3)
    assert ("phase velocity" in ended.stdout) == (repeats == 1)


def test_waves_of_an_identified_beam_know_what_sensors_share_of_their_noise(here):
    """They are those that the scene has whose clamp is given as it was identified, with their intervals."""
    points = [0.3, 0.6, 0.9]
    here.write("shared.csv", SoftRoot(20.0, 0.05).text(points, 3, shared=3.0))
    scene = {"beam": BEAM, "record": {"file": "shared.csv", "quantity": "velocity", "points": points}, "spectrum": {}}
    here.scene("sought", {**scene, **held(100 * CLAMP), "identify": UNKNOWN})
    sought = here.run("sought")
    assert not results.is_fill(sought["measured_noise_correlation_real"][:, :, :MODES]).any()
    assert (np.abs(sought["measured_noise_correlation_real"][0, 1, :MODES]) > 0.5).all()
    here.scene("given", {**scene, **held(float(sought["identified"][0]))})
    given = here.run("given")
    for name in ("wavenumber", "phase_velocity", "group_velocity"):
        for ending in ("", "_error"):
            np.testing.assert_allclose(sought[f"measured_{name}{ending}"], given[f"measured_{name}{ending}"], rtol=1e-9)
