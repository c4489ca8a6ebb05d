"""The published problems: the scene of each, where it is published, and what is compared to which tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Callable

import numpy as np
import xarray as xr

TAU = 2 * math.pi


@dataclass
class Row:
    """One number: what it is, as it is published (text, for its digits), ours from the results, and the relative difference allowed."""

    what: str
    published: str
    ours: Callable[[dict[str, xr.Dataset]], float]
    tolerance: float


@dataclass
class Problem:
    """A problem, its scenes in input/benchmarks/, and its rows."""

    title: str
    text: str
    scenes: list[str]
    rows: list[Row] = field(default_factory=list)


def digits(published: str) -> int:
    """Significant digits of a published number."""
    return len(published.lower().split("e")[0].replace("-", "").replace(".", "").lstrip("0"))


def half_digit(published: str) -> float:
    """Half a unit of the last published digit, over the number."""
    mantissa = published.lower().split("e")[0]
    step = 10.0 ** -len(mantissa.partition(".")[2])
    return 0.5001 * step / abs(float(mantissa))


def modes_of(scene: str, label: str, tables: list[list[str]], tolerance: float | None = None) -> list[Row]:
    """Frequencies in rad/s of the cases of a sweep, or of a single scene: rows of cases, columns of modes."""
    rows = []
    for case, table in enumerate(tables):
        for mode, published in enumerate(table):

            def ours(results, case=case, mode=mode):
                return float(np.atleast_2d(results[scene]["angular_frequency"].values)[case, mode])

            allowed = tolerance or half_digit(published)
            rows.append(Row(f"{label.format(case=case)}mode {mode + 1}", published, ours, allowed))
    return rows


def value(scene: str, pick: Callable[[xr.Dataset], object]) -> Callable[[dict[str, xr.Dataset]], float]:
    """A number of one result."""
    return lambda results: float(pick(results[scene]))


def tip_mass() -> Problem:
    """Roots of the characteristic equation."""
    known = {0.0: ["1.87510407", "4.69409113", "7.85475744"], 0.2: ["1.61639966", "4.26706157", "7.31837267"],
             1.0: ["1.24791741", "4.03113944", "7.13413224"]}
    rows = []
    for case, (ratio, roots) in enumerate(known.items()):
        for k, root in enumerate(roots):
            pick = value("tip_mass", lambda ds, case=case, k=k: ds["alpha"][case, k])
            rows.append(Row(f"γ = {ratio:g}, α{'₁₂₃'[k]}", root, pick, half_digit(root)))
    return Problem(
        "Cantilever with a tip mass",
        "Roots α of the characteristic equation (Eqs 8 and 19 of the paper) for three mass ratios. Reference: the equation solved with 50\n"
        "digits (`tests/reference/`); the first row agrees with R. D. Blevins, *Formulas for Natural Frequency and Mode Shape* (1979).",
        ["tip_mass"], rows)


def rotating() -> Problem:
    """Out of plane, with tension."""
    speeds = [0, 1, 3, 6, 12]
    tables = [["3.5160", "22.0345", "61.6972"], ["3.6816", "22.1810", "61.8418"], ["4.7973", "23.3203", "62.9850"],
              ["7.3604", "26.8091", "66.6839"], ["13.1702", "37.6031", "79.6145"]]
    rows = modes_of("rotating", "{case}: ", tables)
    for number, row in enumerate(rows):
        row.what = f"Ω = {speeds[number // 3]}, mode {number % 3 + 1}"
    return Problem(
        "Rotating cantilever, out of plane",
        "Frequencies in √(EI/ρAl⁴) of a uniform cantilever with centrifugal tension and no hub radius. Published by A. D. Wright, C. E. Smith,\n"
        "R. W. Thresher and J. L. C. Wang, *J. Appl. Mech.* 49 (1982) 197–202, and by D. H. Hodges and M. J. Rutkowski (1981).",
        ["rotating"], rows)


def chordwise() -> Problem:
    """In plane; the coupling with the axial motion is not modelled."""
    known = {2: "3.6195", 4: "3.888", 6: "4.2393", 8: "4.6105", 10: "4.97"}
    rows = [Row(f"Ω = {speed}, mode 1", text, value("chordwise", lambda ds, i=i: ds["angular_frequency"][i, 0]), 0.017)
            for i, (speed, text) in enumerate(known.items())]
    return Problem(
        "Rotating cantilever, in plane",
        "The same beam in the plane of rotation, at the slenderness √(Al²/I) = 70. The published values (H. H. Yoo and S. H. Shin, *J. Sound Vib.*\n"
        "212 (1998) 807–828) include the Coriolis coupling of bending with axial motion, **which beamwave does not model**: its values are up to 1.6 % higher.\n"
        "The report of a run estimates this difference in its line `left out`.",
        ["chordwise"], rows)


def tapering() -> Problem:
    """Linear taper, from two sources."""
    published = {"taper_height": ("height to 0.8", ["3.60827", "20.6210", "56.1923"]),
                 "taper_both_04": ("both to 0.6", ["4.318778559", "20.04998385", "51.33463262"]),
                 "taper_both_08": ("both to 0.2", ["6.196391007", "18.38546739", "39.83362986"])}
    rows = []
    for scene, (what, table) in published.items():
        rows += modes_of(scene, f"{what}, ", [table], None if scene != "taper_height" else 1e-5)
    for ratio, table in ((4, ["23.289", "73.9", "165.23", "299.7", "478.1"]), (5, ["24.308", "75.56", "167.21", "301.9", "480.4"])):
        rows += modes_of(f"taper_vpcs_{ratio}", f"height 4:1, width {ratio}:1, ", [table], 5e-4)
    return Problem(
        "Tapering cantilevers",
        "First a rectangle whose width and height decrease linearly to the fraction shown, in √(EI/ρAl⁴) of the root; values with many digits are from\n"
        "Frobenius's method. Then SDLL09 of the French guide VPCS, in √(Eh²/12ρl⁴) with the height h of the tip: H. H. Mabie and C. B. Rogers,\n"
        "*J. Acoust. Soc. Am.* 51 (1972) 1771–1774. Its digits are those of 1972; the tests compare beamwave with the Ritz method in 200 digits.",
        [*published, "taper_vpcs_4", "taper_vpcs_5"], rows)


def spring_stop() -> Problem:
    """SDNL32."""
    known = ["-2.6602806e-3", "-4.3276365e-3", "-4.9380501e-3", "-4.7666053e-3", "-3.7859305e-3"]
    rows = [Row(f"tip at {i + 1} ms, m", text, value("spring_stop", lambda ds, i=i: ds["displacement"][0, i + 1]), 1e-7)
            for i, text in enumerate(known)]
    return Problem(
        "A hinged beam meets a spring",
        "SDNL32 of VPCS, also V5.02.032 of code_aster, which states deviations of up to 0.8 % from the guide: a beam turns at 3.8 rad/s about\n"
        "its hinged root, and at t = 0 its tip meets a spring of 18 kN/m. Reference: the sum of 400 modes in 30 digits, Euler–Bernoulli without damping.",
        ["spring_stop"], rows)


def deep_beam() -> Problem:
    """NAFEMS 5."""
    def late(ds):
        return np.abs(ds["displacement"]).isel(time=slice(-1024, None)).max()

    rows = [Row("frequency 1, Hz", "42.65", value("deep_beam_step", lambda ds: ds["angular_frequency"][0] / TAU), 0.01),
            Row("step: largest, m", "1.043e-3", value("deep_beam_step", lambda ds: ds["displacement"].max()), 0.01),
            Row("step: time of it, s", "0.0117", value("deep_beam_step", lambda ds: ds["displacement"][0].idxmax()), 0.01),
            Row("harmonic: steady, m", "13.45e-3", value("deep_beam_tone", late), 0.01)]
    return Problem(
        "A deep beam between pins",
        "Test 5 of NAFEMS, *Selected Benchmarks for Forced Vibration* (R0016): a beam of 2 m × 2 m × 10 m with shear, 2 % damping and a uniform load of 1 MN/m,\n"
        "applied as a step and harmonically at 42.65 Hz. The load is represented by an acceleration of the base.",
        ["deep_beam_step", "deep_beam_tone"], rows)


def timoshenko() -> Problem:
    """The first contact of a sphere with a beam that was computed."""
    rows = [Row("largest force, N", "4.977", value("timoshenko", lambda ds: ds["event_force"][0]), 1e-3),
            Row("time of it, s", "72.6e-6", value("timoshenko", lambda ds: ds["event_force_time"][0]), 1e-3),
            Row("duration, s", "156.5e-6", value("timoshenko", lambda ds: ds["event_end"][0]), 1e-3),
            Row("ball's velocity after, over before", "-0.3023",
                value("timoshenko", lambda ds: 1 - ds["event_impulse"][0] / (ds["impact_mass"] * ds["impact_approach_velocity"])), 1e-3)]
    return Problem(
        "A ball strikes a beam between pins",
        "A steel ball of 1 cm radius strikes the middle of a beam of 1 cm × 1 cm × 15.35 cm at 1 cm/s: S. Timoshenko, *Z. Math. Phys.* 62 (1913)\n"
        "198–209.",
        ["timoshenko"], rows)


def infinite_beam() -> Problem:
    """The table of an integral equation."""
    table = {0.1: ("3.1783", "0.8340", "1.06465"), 0.5: ("3.0535", "0.3656", "0.83951"), 1.0: ("2.9547", "0.0233", "0.66986"),
             2.0: ("2.9080", "-0.3305", "0.48538")}
    rows = []
    for i, (number, texts) in enumerate(table.items()):
        picks = [lambda ds, i=i: ds["event_end"][i, 0] / ds["impact_mass"][i] ** 0.4,
                 lambda ds, i=i: ds["event_impulse"][i, 0] / ds["impact_mass"][i] - 1,
                 lambda ds, i=i: ds["event_force"][i, 0] / ds["impact_mass"][i] ** 0.6]
        for what, text, pick in zip(("duration", "speed back", "largest force"), texts, picks):
            rows.append(Row(f"Λ = {number:g}: {what}", text, value("infinite_beam", pick), 1.2 * half_digit(text)))
    return Problem(
        "Hertzian impact on an infinite beam",
        "A sphere strikes an infinite beam. With T = (m/(K√V))^⅖ the problem depends only on Λ = m/(ρA√(2πhT)): the indentation obeys\n"
        "x'' = −x^(3/2) − Λ d²/dτ² ∫x^(3/2)√(τ − s)ds (C. Zener, *Phys. Rev.* 59 (1941) 669–673, for plates; E. H. Lee, *J. Appl. Mech.* 7 (1940)\n"
        "A129–A138, for beams), which was solved numerically. Duration in T, rebound velocity of the sphere in V (negative: it moves on), force in K(VT)^(3/2).",
        ["infinite_beam"], rows)


def problems() -> list[Problem]:
    """All, in the order of the document."""
    return [tip_mass(), rotating(), chordwise(), tapering(), spring_stop(), deep_beam(), timoshenko(), infinite_beam()]
