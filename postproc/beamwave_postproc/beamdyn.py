"""Blades in OpenFAST's BeamDyn files: the input file, with axis and twist, and the file of sections that it names."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np

from .blade import MOST_STATIONS, Blade, NotABlade, number, read_lines, scalars_of
from .terminal import printable, reason

SHEAR_AND_STRETCH, BENDING_AND_TWIST = slice(0, 3), slice(3, 6)  # rows of a section's matrices
EDGE, FLAP = 0, 1  # of bending and twist: moments about the x axis, which points downwind, and about the y axis


def read_beamdyn(path: Path, lines: list[str]) -> Blade:
    """Read a blade from the lines of BeamDyn's input file. Raises `NotABlade`, with the line, and `OSError`."""
    axis, twist = _key_points(path, lines)
    steps = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    place = np.concatenate([[0.0], np.cumsum(steps)])
    if not np.all(steps > 0):
        raise NotABlade(f"{path}: key points {int(np.argmin(steps > 0)) + 1} and the next are at the same place")
    line, word = scalars_of(lines)["BldFile"]
    named = path.parent / word.strip("\"'").replace("\\", "/")
    try:
        sections = read_lines(named)
    except OSError as failure:
        raise NotABlade(f"{path}:{line}: {named}: {reason(failure)}") from None
    fraction, stiffness, mass = _sections(named, sections)
    bent = np.array([_bending(matrix, named, station) for station, matrix in enumerate(stiffness, 1)])
    straight = axis[0] + np.outer(place / place[-1], axis[-1] - axis[0])
    root_to_tip = np.linalg.norm(axis[-1] - axis[0])
    return Blade(
        path=path,
        title=printable(lines[1].strip()),
        fraction=fraction.tolist(),
        twist_deg=np.interp(fraction, place / place[-1], twist).tolist(),
        mass_per_length=mass[:, 0, 0].tolist(),
        flap_stiffness=bent[:, FLAP, FLAP].tolist(),
        edge_stiffness=bent[:, EDGE, EDGE].tolist(),
        tuners={},
        length=float(place[-1]),
        coupling=float(max(_coupling(matrix) for matrix in bent)),
        off_axis=float(np.linalg.norm(axis - straight, axis=1).max()) if root_to_tip > 0 else float(place[-1]),
    )


def _key_points(path: Path, lines: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return places of the axis (key points, 3), in m, and the initial twist in degrees."""
    scalars = scalars_of(lines)
    line, word = scalars.get("kp_total", (0, "none"))
    count = number(word, path, line, "kp_total")
    if count != int(count) or not 3 <= count <= 10 * MOST_STATIONS:
        raise NotABlade(f"{path}:{line}: kp_total is {count:g}; accepted: 3 or more")
    head = next((n for n, text in enumerate(lines) if text.split()[:1] == ["kp_xr"]), None)
    if head is None:
        raise NotABlade(f"{path}: has no line of column names that begins with kp_xr")
    rows = []
    for n in range(head + 2, head + 2 + int(count)):  # below the line of units
        words = lines[n].split()[:4] if n < len(lines) else []
        if len(words) < 4:
            raise NotABlade(f"{path}:{n + 1}: has no row of 4 numbers; kp_total says {count:g} key points")
        rows.append([number(text, path, n + 1, "a key point") for text in words])
    table = np.array(rows)
    return table[:, :3], table[:, 3]


def _sections(path: Path, lines: list[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return fractions of the length, stiffness and mass matrices, (stations, 6, 6), of a blade file."""
    line, word = scalars_of(lines).get("station_total", (0, "none"))
    count = number(word, path, line, "station_total")
    if count != int(count) or not 2 <= count <= MOST_STATIONS:
        raise NotABlade(f"{path}:{line}: station_total is {count:g}; accepted: 2 to {MOST_STATIONS}")
    head = next((n for n, text in enumerate(lines) if "distributed properties" in text.lower()), None)
    if head is None:
        raise NotABlade(f"{path}: has no line with the words DISTRIBUTED PROPERTIES")
    words = ((n, word) for n, text in enumerate(lines[head + 1 :], head + 2) for word in text.split())
    each = 1 + 2 * 36
    found = list(islice(words, int(count) * each))
    if len(found) < count * each:
        raise NotABlade(
            f"{path}: ends in station {len(found) // each + 1} of {count:g}; each has a place and two matrices of 6 rows"
        )
    values = np.array([number(word, path, n, "a section's number") for n, word in found]).reshape(int(count), each)
    fraction, matrices = values[:, 0], values[:, 1:].reshape(-1, 2, 6, 6)
    if fraction[0] != 0 or fraction[-1] != 1 or not np.all(np.diff(fraction) > 0):
        raise NotABlade(
            f"{path}: the places of the stations are {fraction[0]:g} to {fraction[-1]:g}; accepted: they rise from 0 to 1"
        )
    if not np.all(matrices[:, 1, 0, 0] > 0):
        raise NotABlade(
            f"{path}: station {int(np.argmin(matrices[:, 1, 0, 0] > 0)) + 1} has no mass; accepted: above 0"
        )
    return fraction, matrices[:, 0], matrices[:, 1]


def _bending(section: np.ndarray, path: Path, station: int) -> np.ndarray:
    """Return the stiffness against bending and twist, (3, 3), of a section that shears and stretches as it likes."""
    section = 0.5 * (section + section.T)
    try:
        np.linalg.cholesky(section)
    except np.linalg.LinAlgError:
        raise NotABlade(f"{path}: the stiffness of station {station} is not positive definite") from None
    mixed = section[SHEAR_AND_STRETCH, BENDING_AND_TWIST]
    return section[BENDING_AND_TWIST, BENDING_AND_TWIST] - mixed.T @ np.linalg.solve(
        section[SHEAR_AND_STRETCH, SHEAR_AND_STRETCH], mixed
    )


def _coupling(stiffness: np.ndarray) -> float:
    """Return the largest part that one curvature makes of another's moment, over the geometric mean of their stiffnesses."""
    scale = np.sqrt(np.diag(stiffness))
    return float(np.abs(stiffness / np.outer(scale, scale) - np.eye(3)).max())
