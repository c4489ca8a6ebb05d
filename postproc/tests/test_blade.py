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


def beamdyn_files(folder, twist=0.0, shift=(0.0, 0.0), mixed=0.0, bow=0.0, change=None):
    """Write the same blade in BeamDyn's format; the tension centre of its sections is shifted from the axis by x and y."""
    x, y = shift
    rows = []
    for a, b, c, d in zip(FRACTION, 1.05 * MASS, 1.1 * FLAP, 0.9 * EDGE):
        stiff, inertia = np.diag([1e9, 2e9, 1e10, d, c, 5e9]), np.diag([b, b, b, 10.0, 20.0, 30.0])
        moved = np.array([y, -x])  # moments about x and y of a pull at the tension centre
        stiff[2, 3:5] = stiff[3:5, 2] = stiff[2, 2] * moved
        stiff[3:5, 3:5] += stiff[2, 2] * np.outer(moved, moved)
        stiff[3, 4] = stiff[4, 3] = stiff[3, 4] + mixed * np.sqrt(c * d)
        matrices = [
            "\n".join("  ".join(f"{value:23.16e}" for value in row) for row in matrix) for matrix in (stiff, inertia)
        ]
        rows.append(f" {a:.6f}\n" + "\n\n".join(matrices) + "\n")
    damping = (
        "   mu1  mu2  mu3  mu4  mu5  mu6\n   (-)  (-)  (-)  (-)  (-)  (-)\n  0.001 0.001 0.001 0.001 0.001 0.001\n"
    )
    (folder / "sections.dat").write_text(
        f"------- BEAMDYN V1.00.* INDIVIDUAL BLADE INPUT FILE ----\nA blade for tests\n---- BLADE PARAMETERS ----\n"
        f"{FRACTION.size}   station_total    - Number of blade input stations (-)\n 1   damp_type        - Damping\n"
        f"---- DAMPING COEFFICIENT ----\n{damping}---- DISTRIBUTED PROPERTIES ----\n" + "\n".join(rows)
    )
    twists = np.broadcast_to(twist, FRACTION.shape)
    points = "\n".join(f"{bow * 4 * a * (1 - a)} 0.0 {LENGTH * a} {b}" for a, b in zip(FRACTION, twists))
    path = folder / "beamdyn.dat"
    text = f"""--------- BEAMDYN with OpenFAST INPUT FILE ------
A blade for tests
---------------------- GEOMETRY PARAMETER ----------
          1   member_total   - Total number of members (-)
          {FRACTION.size}   kp_total       - Total number of key points (-)
     1     {FRACTION.size}                - Member number; Number of key points in this member
    kp_xr   kp_yr   kp_zr   initial_twist
    (m)     (m)     (m)     (deg)
{points}
---------------------- MATERIAL PARAMETER ----------
"sections.dat"    BldFile - Name of file containing properties for blade (quoted string)
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


def test_a_blade_of_beamdyn_is_the_same_beam_wherever_its_axis_runs(tmp_path):
    elastodyn = read_blade(blade_file(tmp_path / "blade.dat"))
    beamdyn = read_blade(beamdyn_files(tmp_path, shift=(0.3, -0.2)))
    assert beamdyn.length == pytest.approx(LENGTH, rel=1e-15)
    for direction in ("flap", "edge"):
        ours, other = (blade_scene(blade, direction, LENGTH)["beam"] for blade in (beamdyn, elastodyn))
        for name in ("length", "mass_per_length", "bending_stiffness"):
            # of E A d^2, which is taken off again, and the ten digits of ElastoDyn's file
            np.testing.assert_allclose(ours[name], other[name], rtol=1e-7, err_msg=name)


def test_a_blade_of_beamdyn_says_what_bends_otherwise(tmp_path, capfd):
    words = [str(beamdyn_files(tmp_path, bow=1.0, mixed=0.1)), "--direction", "flap"]
    assert main(words) == 3
    assert "sections couple one direction of bending with the other or with twist, by 0.1 of" in capfd.readouterr().err
    assert main([*words, "--neglect-twist"]) == 0
    said = capfd.readouterr().err
    assert "what sections couple, 0.1 of their stiffnesses, is neglected" in said
    assert "the axis, which is up to 0.96 m off a straight line, is taken as straight" in said
    assert main([*words, "--length", "60"]) == 2
    assert "holds the blade's length; accepted: neither --length nor --tip-radius" in capfd.readouterr().err
    with pytest.raises(NotABlade, match="accepted: the BeamDyn input file that names it"):
        read_blade(tmp_path / "sections.dat")
    with pytest.raises(NotABlade, match="varies from 0 to 13 degrees"):
        blade_scene(read_blade(beamdyn_files(tmp_path, twist=np.linspace(13.0, 0.0, FRACTION.size))), "flap", LENGTH)


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("beamdyn.dat", ("6   kp_total", "7   kp_total"), "beamdyn.dat:15: a key point is ------"),
        ("beamdyn.dat", ("6   kp_total", "x   kp_total"), "beamdyn.dat:5: kp_total is x; accepted: a number"),
        ("beamdyn.dat", ("kp_xr", "kp_x"), "has no line of column names that begins with kp_xr"),
        ("beamdyn.dat", ("0.0 0.0 6.0 ", "0.0 0.0 0.0 "), "key points 1 and the next are at the same place"),
        ("sections.dat", ("6   station_total", "7   station_total"), "ends in station 7 of 7; each has a place"),
        ("sections.dat", ("DISTRIBUTED", "OTHER"), "has no line with the words DISTRIBUTED PROPERTIES"),
        ("sections.dat", (" 0.300000\n", " 0.050000\n"), "the places of the stations are 0 to 1; accepted: they rise"),
        (
            "sections.dat",
            ("1.0000000000000000e+09", "-1.0000000000000000e+09"),
            "the stiffness of station 1 is not positive definite",
        ),
        ("sections.dat", (" 1.0000000000000000e+09", " much"), ":12: a section's number is much; accepted: a number"),
        ("sections.dat", ("7.3500000000000000e+02", "0"), "station 1 has no mass"),
    ],
)
def test_a_damaged_file_of_beamdyn_is_refused(tmp_path, name, change, message):
    path = beamdyn_files(tmp_path)
    damaged = tmp_path / name
    assert change[0] in damaged.read_text()
    damaged.write_text(damaged.read_text().replace(*change))
    with pytest.raises(NotABlade) as failure:
        read_blade(path)
    assert message in str(failure.value)


def test_a_missing_file_of_sections_is_named(tmp_path, capfd):
    path = beamdyn_files(tmp_path)
    (tmp_path / "sections.dat").unlink()
    assert main([str(path), "--direction", "flap"]) == 3
    assert "beamdyn.dat:16: " in (said := capfd.readouterr().err) and "sections.dat: No such file" in said


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
        (("NBlInpSt", "stations"), "has neither NBlInpSt nor kp_total"),
        (("FlpStff", "FlpStiff"), ":13: has no column FlpStff"),
        (("3.8000000E+02", "-3.8000000E+02"), ":17: BMassDen is -380; accepted: above 0"),
        (("3.0000000E-01", "5.0000000E-02"), ":17: BlFract is 0.05 after 0.1; accepted: it rises"),
        (("1.05   AdjBlMs", "0.0    AdjBlMs"), "AdjBlMs is 0; accepted: above 0"),
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
