"""`beamwave-blade`: a blade file becomes a scene whose frequencies are those of finite elements of the same stations."""

import math

import numpy as np
import pytest
import scipy.linalg

from beamwave_postproc import run
from beamwave_postproc.blade import NotABlade, blade_scene, main, read_blade

FRACTION = np.array([0.0, 0.1, 0.3, 0.6, 0.85, 1.0])
MASS = np.array([700.0, 450.0, 380.0, 250.0, 120.0, 30.0])
FLAP = np.array([1.8e10, 6.0e9, 2.2e9, 4.0e8, 4.0e7, 1.0e6])
EDGE = np.array([1.8e10, 9.0e9, 5.0e9, 1.8e9, 4.0e8, 2.0e7])
LENGTH, HUB = 60.0, 1.5


def blade_file(path, twist=0.0, change=None):
    """Write a blade in ElastoDyn's format. `change` = (old, new) damages its text."""
    twists = np.broadcast_to(twist, FRACTION.shape)
    rows = "\n".join(
        f"{a:15.7E} {0.25:15.7E} {b:15.7E} {c:15.7E} {d:15.7E} {e:15.7E}"
        for a, b, c, d, e in zip(FRACTION, twists, MASS, FLAP, EDGE)
    )
    text = f"""------- ELASTODYN V1.00.* INDIVIDUAL BLADE INPUT FILE --------------------------
A blade for tests
---------------------- BLADE PARAMETERS ----------------------------------------
          {FRACTION.size}   NBlInpSt    - Number of blade input stations (-)
   0.477465   BldFlDmp(1) - Blade flap mode #1 structural damping in percent of critical (%)
---------------------- BLADE ADJUSTMENT FACTORS --------------------------------
          1   FlStTunr(1) - Blade flapwise modal stiffness tuner, 1st mode (-)
          1   FlStTunr(2) - Blade flapwise modal stiffness tuner, 2nd mode (-)
       1.05   AdjBlMs     - Factor to adjust blade mass density (-)
        1.1   AdjFlSt     - Factor to adjust blade flap stiffness (-)
        0.9   AdjEdSt     - Factor to adjust blade edge stiffness (-)
---------------------- DISTRIBUTED BLADE PROPERTIES ----------------------------
    BlFract      PitchAxis      StrcTwst       BMassDen        FlpStff        EdgStff
      (-)           (-)          (deg)          (kg/m)         (Nm^2)         (Nm^2)
{rows}
---------------------- BLADE MODE SHAPES ---------------------------------------
     0.0622   BldFl1Sh(2) - Flap mode 1, coeff of x^2
"""
    path.write_text(text.replace(*change) if change else text)
    return path


def element_frequencies(stiffness, omega=0.0, in_plane=False, parts=40):
    """First three frequencies (rad/s) by Hermite elements, `parts` between two stations."""
    nodes = np.unique(np.concatenate([np.linspace(a, b, parts + 1) for a, b in zip(FRACTION, FRACTION[1:])])) * LENGTH
    at, weight = np.polynomial.legendre.leggauss(6)

    def mass(x):
        return 1.05 * np.interp(x, FRACTION * LENGTH, MASS)

    def pull(a, b):  # of the material between a and b
        x = 0.5 * (a + b) + 0.5 * (b - a) * at
        return omega**2 * 0.5 * (b - a) * np.sum(weight * mass(x) * (HUB + x))

    beyond = np.append(np.cumsum([pull(a, b) for a, b in zip(nodes, nodes[1:])][::-1])[::-1], 0.0)
    size = 2 * nodes.size
    stiff, inertia = np.zeros((size, size)), np.zeros((size, size))
    for e, (a, b) in enumerate(zip(nodes, nodes[1:])):
        h, place = b - a, slice(2 * e, 2 * e + 4)
        for s, w in zip(0.5 * (1 + at), 0.5 * h * weight):
            x = a + s * h
            v = np.array([1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, h * (s**3 - s**2)])
            slope = np.array([(6 * s**2 - 6 * s) / h, 1 - 4 * s + 3 * s**2, (6 * s - 6 * s**2) / h, 3 * s**2 - 2 * s])
            bend = np.array([(12 * s - 6) / h**2, (6 * s - 4) / h, (6 - 12 * s) / h**2, (6 * s - 2) / h])
            tension = pull(x, b) + beyond[e + 1]
            stiff[place, place] += w * (
                np.interp(x, FRACTION * LENGTH, stiffness) * np.outer(bend, bend)
                + tension * np.outer(slope, slope)
                - in_plane * omega**2 * mass(x) * np.outer(v, v)
            )
            inertia[place, place] += w * mass(x) * np.outer(v, v)
    # The reciprocal problem, whose largest values are the lowest modes: these keep their digits on a fine mesh.
    reciprocal = scipy.linalg.eigh(inertia[2:, 2:], stiff[2:, 2:], eigvals_only=True)
    return 1 / np.sqrt(reciprocal[::-1][:3])


@pytest.mark.parametrize("direction", ["flap", "edge"])
@pytest.mark.parametrize("rpm", [0.0, 12.0])
def test_frequencies_are_those_of_finite_elements(beamwave, tmp_path, direction, rpm):
    path = blade_file(tmp_path / "blade.dat")
    words = [str(path), "--direction", direction, "--tip-radius", str(LENGTH + HUB), "--hub-radius", str(HUB)]
    assert main([*words, "--rpm", str(rpm)]) == 0
    result = run(tmp_path / f"blade_{direction}.nml", program=beamwave)
    stiffness = 1.1 * FLAP if direction == "flap" else 0.9 * EDGE
    reference = element_frequencies(stiffness, 2 * math.pi * rpm / 60, in_plane=direction == "edge")
    # Against 20 elements between stations, 40 change the third flap frequency by 1.6e-6: their own error is near 1e-7.
    np.testing.assert_allclose(result["angular_frequency"].values[:3], reference, rtol=1e-6)


def test_a_right_angle_turns_flap_into_the_plane_of_rotation(tmp_path):
    blade = read_blade(blade_file(tmp_path / "blade.dat", twist=90.0))
    planes = [blade_scene(blade, d, LENGTH, angular_velocity=1.0)["rotation"]["plane"] for d in ("flap", "edge")]
    assert planes == ["in", "out"]
    turned_back = blade_scene(blade, "flap", LENGTH, angular_velocity=1.0, pitch_deg=-90.0)
    assert turned_back["rotation"]["plane"] == "out"


def test_a_setting_angle_that_couples_is_refused_unless_neglected(tmp_path, capfd):
    path = blade_file(tmp_path / "blade.dat", twist=np.linspace(13.0, 0.0, FRACTION.size))
    words = [str(path), "--direction", "flap", "--length", "60"]
    assert main(words) == 3
    assert "varies from 0 to 13 degrees, which couples flap with edge" in capfd.readouterr().err
    assert not list(tmp_path.glob("*.nml"))
    assert main([*words, "--neglect-twist"]) == 0
    assert "0 to 13 degrees are taken as 0" in capfd.readouterr().err


def test_a_constant_angle_is_refused_only_of_a_blade_that_rotates(tmp_path):
    blade = read_blade(blade_file(tmp_path / "blade.dat", twist=5.0))
    assert "rotation" not in blade_scene(blade, "edge", LENGTH)
    with pytest.raises(NotABlade, match="is 5 degrees, and rotation then couples"):
        blade_scene(blade, "edge", LENGTH, angular_velocity=1.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("6   NBlInpSt", "7   NBlInpSt"), ":21: has no row of 6 numbers; NBlInpSt says 7 stations"),
        (("6   NBlInpSt", "x   NBlInpSt"), ":4: NBlInpSt is x; accepted: a number"),
        (("NBlInpSt", "station_total"), "has no NBlInpSt"),
        (("FlpStff", "FlpStiff"), ":13: has no column FlpStff"),
        (("3.8000000E+02", "-3.8000000E+02"), ":17: BMassDen is -380; accepted: above 0"),
        (("3.0000000E-01", "5.0000000E-02"), ":17: BlFract is 0.05 after 0.1; accepted: it rises"),
        (("1.0000000E+00", "9.0000000E-01"), ":20: BlFract is 0.9; accepted: 1"),
    ],
)
def test_a_damaged_file_is_refused_with_its_line(tmp_path, change, message):
    with pytest.raises(NotABlade) as failure:
        read_blade(blade_file(tmp_path / "blade.dat", change=change))
    assert message in str(failure.value)


@pytest.mark.parametrize("words", [[], ["--length", "-1"], ["--tip-radius", "1", "--hub-radius", "2"]])
def test_wrong_words_write_nothing(tmp_path, words):
    assert main([str(blade_file(tmp_path / "blade.dat")), "--direction", "edge", *words]) == 2
    assert not list(tmp_path.glob("*.nml"))


@pytest.mark.parametrize("name", ["FlStTunr(2)", "FlStTunr2"])
def test_the_stiffness_factor_of_a_mode_is_found_in_both_spellings(tmp_path, name):
    change = ("          1   FlStTunr(2)", f"        1.2   {name}")
    assert read_blade(blade_file(tmp_path / "b.dat", change=change)).tuners == {name: 1.2}
