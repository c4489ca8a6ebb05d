"""The command `beamwave-blade`: a scene of one bending direction of a blade of OpenFAST's ElastoDyn or BeamDyn."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .run import namelist
from .terminal import Refusal, Words, printable
from .tool import EXIT_DONE, EXIT_FILE, EXIT_USAGE, Tool, WrongWords, command
from .writing import make_directory

LEAST_ANGLE = 0.01  # degrees that count as none: two decimals are what these files write
LEAST_COUPLING = 1e-3  # of stiffnesses that counts as none: it changes frequencies by its square
LEAST_BOW = 1e-6  # of the length, by which a straight axis may be off
MOST_STATIONS = 1001  # that `&beam` takes
MOST_BYTES = 10_000_000
COLUMNS = ("BlFract", "StrcTwst", "BMassDen", "FlpStff", "EdgStff")


class NotABlade(Refusal):
    """The file is no blade of OpenFAST, or has no scene of one bending direction; the text names the file."""


@dataclass
class Blade:
    """A blade by stations, with the factors of its file applied; lists are (n_stations)."""

    path: Path
    title: str
    fraction: list[float]  # of the length, from 0 at the root to 1 at the tip
    twist_deg: list[float]  # structural twist: from the plane of rotation to the chord
    mass_per_length: list[float]  # kg/m
    flap_stiffness: list[float]  # N m²
    edge_stiffness: list[float]  # N m²
    tuners: dict[str, float]  # of the stiffness of single modes, where they are not 1
    length: float | None = None  # m along the axis, where the file holds it
    coupling: float = 0.0  # of bending in one direction with the other and with twist, over their stiffnesses
    off_axis: float = 0.0  # m by which the axis leaves the straight line from root to tip


def read_blade(path: Path) -> Blade:
    """Read a blade file. Raises `NotABlade`, with the line, for what is no such file, and `OSError`."""
    lines = read_lines(path)
    scalars = scalars_of(lines)
    if "kp_total" in scalars and "BldFile" in scalars:
        from .beamdyn import read_beamdyn  # numpy takes longer than all of ElastoDyn's

        return read_beamdyn(path, lines)
    if "station_total" in scalars:
        raise NotABlade(
            f"{path}: has sections alone; accepted: the BeamDyn input file that names it, which has length and twist"
        )
    if "NBlInpSt" not in scalars:
        raise NotABlade(
            f"{path}: has neither NBlInpSt nor kp_total; accepted: an ElastoDyn blade file, or a BeamDyn input file"
        )

    def scalar(name: str) -> float:
        line, text = scalars[name] if name in scalars else (0, "1")
        return number(text, path, line, name)

    count = scalar("NBlInpSt")
    if count != int(count) or not 2 <= count <= MOST_STATIONS:
        raise NotABlade(f"{path}:{scalars['NBlInpSt'][0]}: NBlInpSt is {count:g}; accepted: 2 to {MOST_STATIONS}")
    table = _stations(path, lines, int(count))
    factors = {name: scalar(name) for name in ("AdjBlMs", "AdjFlSt", "AdjEdSt")}
    for name, value in factors.items():
        if value <= 0:
            raise NotABlade(f"{path}:{scalars[name][0]}: {name} is {value:g}; accepted: above 0")
    tuners = {
        name: scalar(name) for name in ("FlStTunr(1)", "FlStTunr(2)", "FlStTunr1", "FlStTunr2")
    }  # both spellings occur
    return Blade(
        path=path,
        title=printable(lines[1].strip()) if len(lines) > 1 else "",
        fraction=table["BlFract"],
        twist_deg=table["StrcTwst"],
        mass_per_length=[factors["AdjBlMs"] * value for value in table["BMassDen"]],
        flap_stiffness=[factors["AdjFlSt"] * value for value in table["FlpStff"]],
        edge_stiffness=[factors["AdjEdSt"] * value for value in table["EdgStff"]],
        tuners={name: value for name, value in tuners.items() if value != 1.0},
    )


def read_lines(path: Path) -> list[str]:
    """Return the lines of a file. Raises `NotABlade` where it is too large, and `OSError`."""
    with path.open("rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise NotABlade(f"{path}: is larger than {MOST_BYTES} bytes; accepted: a blade file of OpenFAST")
    return data.decode("latin-1").splitlines()


def scalars_of(lines: list[str]) -> dict[str, tuple[int, str]]:
    """Return line and text of each value that stands before its name."""
    return {words[1]: (n, words[0]) for n, words in enumerate(map(str.split, lines), 1) if len(words) > 1}


def _stations(path: Path, lines: list[str], count: int) -> dict[str, list[float]]:
    """Read the columns of the distributed properties by their names."""
    head = next((n for n, line in enumerate(lines) if line.split()[:1] == ["BlFract"]), None)
    if head is None:
        raise NotABlade(f"{path}: has no line of column names that begins with BlFract")
    names = lines[head].split()
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise NotABlade(f"{path}:{head + 1}: has no column {', '.join(missing)}; it has {printable(', '.join(names))}")
    first = head + 2  # below the line of units
    table: dict[str, list[float]] = {name: [] for name in COLUMNS}
    for line in range(first, first + count):
        words = lines[line].split() if line < len(lines) else []
        if len(words) < len(names):
            raise NotABlade(f"{path}:{line + 1}: has no row of {len(names)} numbers; NBlInpSt says {count} stations")
        for name in COLUMNS:
            value = number(words[names.index(name)], path, line + 1, name)
            if name not in ("BlFract", "StrcTwst") and value <= 0:
                raise NotABlade(f"{path}:{line + 1}: {name} is {value:g}; accepted: above 0")
            if name == "BlFract" and table[name] and value <= table[name][-1]:
                raise NotABlade(
                    f"{path}:{line + 1}: BlFract is {value:g} after {table[name][-1]:g}; accepted: it rises"
                )
            table[name].append(value)
    for line, wanted in ((first, 0.0), (first + count - 1, 1.0)):
        value = table["BlFract"][line - first]
        if value != wanted:
            raise NotABlade(f"{path}:{line + 1}: BlFract is {value:g}; accepted: {wanted:g} at this end of the blade")
    return table


def number(text: str, path: Path, line: int, name: str) -> float:
    """Read a number as Fortran writes it; it has to be finite."""
    try:
        value = float(text.lower().replace("d", "e"))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise NotABlade(f"{path}:{line}: {name} is {printable(text)}; accepted: a number")
    return value


def blade_scene(
    blade: Blade,
    direction: str,
    length: float,
    *,
    hub_radius: float = 0.0,
    angular_velocity: float = 0.0,
    pitch_deg: float = 0.0,
    neglect_twist: bool = False,
) -> dict[str, dict[str, object]]:
    """Return the groups of a scene, as `run` takes them, of one bending direction of a blade.

    `direction` is 'flap' or 'edge', `length` is in m from the root to the tip, `hub_radius` in m, `angular_velocity` in
    rad/s and `pitch_deg` is added to the structural twist. Raises `NotABlade` where the setting angle couples flap with
    edge: it varies along the blade, or the blade rotates and it is neither 0 nor 90 degrees; or where the sections do. With
    `neglect_twist` the blade bends as if the angle were 0 everywhere and no section coupled anything.
    """
    if direction not in ("flap", "edge"):
        raise ValueError(f"direction is {direction!r}; accepted: 'flap' or 'edge'")
    in_plane = direction == "edge"
    if not neglect_twist:
        angles = [pitch_deg + twist for twist in blade.twist_deg]
        quarter = round(angles[0] / 90.0)
        far = max(abs(angle - 90.0 * quarter) for angle in angles)
        if max(angles) - min(angles) > LEAST_ANGLE:
            why = f"the setting angle varies from {min(angles):g} to {max(angles):g} degrees, which couples flap with edge"
        elif angular_velocity and far > LEAST_ANGLE:
            why = f"the setting angle is {angles[0]:g} degrees, and rotation then couples flap with edge"
        else:
            why = ""
        if why:
            raise NotABlade(f"{blade.path}: {why}; accepted: 0 or 90 degrees along the whole blade, or --neglect-twist")
        if blade.coupling > LEAST_COUPLING:
            raise NotABlade(
                f"{blade.path}: sections couple one direction of bending with the other or with twist, by {blade.coupling:.1g} of their "
                "stiffnesses; accepted: sections without it, or --neglect-twist"
            )
        in_plane = in_plane != bool(quarter % 2)
    stiffness = blade.flap_stiffness if direction == "flap" else blade.edge_stiffness
    steps = [length * (b - a) for a, b in zip(blade.fraction, blade.fraction[1:])]
    groups: dict[str, dict[str, object]] = {
        "scene": {"title": f"{blade.title[:200]}, {direction}".lstrip(", ")},
        "beam": {
            "length": steps,
            "mass_per_length": blade.mass_per_length,
            "bending_stiffness": stiffness,
            "taper": "linear",
        },
    }
    if angular_velocity:
        groups["rotation"] = {"angular_velocity": angular_velocity, "plane": "in" if in_plane else "out"}
        groups["stiffening"] = {"hub_radius": hub_radius}
    return groups


def parser() -> argparse.ArgumentParser:
    """Return the words of the command line."""
    words = Words(prog="beamwave-blade", description="Makes a scene of one bending direction of a blade of OpenFAST.")
    words.add_argument("file", metavar="FILE", type=Path, help="ElastoDyn blade file, or BeamDyn input file")
    words.add_argument("--direction", choices=["flap", "edge"], required=True, help="in which the blade bends")
    words.add_argument("--length", metavar="M", type=float, help="of a blade of ElastoDyn; or --tip-radius")
    words.add_argument(
        "--tip-radius", metavar="M", type=float, help="TipRad of the main file; length is TipRad - HubRad"
    )
    words.add_argument(
        "--hub-radius", metavar="M", type=float, default=0.0, help="HubRad of the main file (default: 0)"
    )
    words.add_argument("--rpm", metavar="N", type=float, default=0.0, help="rotor speed, 1/min (default: 0, at rest)")
    words.add_argument(
        "--pitch", metavar="DEG", type=float, default=0.0, help="added to the structural twist (default: 0)"
    )
    words.add_argument(
        "--neglect-twist", action="store_true", help="bend as if the setting angle were 0; says what that neglects"
    )
    words.add_argument("--output", metavar="DIR", type=Path, help="where the scene goes (default: beside the file)")
    words.add_argument("--overwrite", action="store_true", help="replace a scene that is there")
    return words


def main(argv: Sequence[str] | None = None) -> int:
    """Write the scene; 0, or 2 for wrong words, or 3 if the file has no such scene, or cannot be read or written."""
    return command(parser(), _run, argv)


def _run(given: argparse.Namespace, tool: Tool) -> int:
    _check(given)
    directory = given.output or given.file.parent
    make_directory(directory)
    return tool.each([given.file], directory, lambda: _convert(given, directory, tool))


def _check(given: argparse.Namespace) -> None:
    """Raise `WrongWords` where a word is out of range; completes the blade's length."""
    if given.length is not None and given.tip_radius is not None:
        raise WrongWords("--length and --tip-radius; accepted: one of them")
    if not 0 <= given.hub_radius < math.inf:
        raise WrongWords(f"--hub-radius is {given.hub_radius:g}; accepted: 0 or above")
    if given.tip_radius is not None:
        given.length = given.tip_radius - given.hub_radius
    if given.length is not None and not 0 < given.length < math.inf:
        raise WrongWords(f"the blade's length is {given.length:g} m; accepted: above 0")
    if not (math.isfinite(given.rpm) and math.isfinite(given.pitch)):
        raise WrongWords("--rpm and --pitch; accepted: finite numbers")


def _convert(given: argparse.Namespace, directory: Path, tool: Tool) -> int:
    """Write the scene of one file, and say what it leaves out; returns the exit status."""
    try:
        blade = read_blade(given.file)
        if (given.length is None) == (blade.length is None):
            held = "does not hold" if blade.length is None else "holds"
            wanted = "--length or --tip-radius" if blade.length is None else "neither --length nor --tip-radius"
            tool.complain(f"{given.file}: {held} the blade's length; accepted: {wanted}")
            return EXIT_USAGE
        groups = blade_scene(
            blade,
            given.direction,
            given.length or blade.length,
            hub_radius=given.hub_radius,
            angular_velocity=2.0 * math.pi * given.rpm / 60.0,
            pitch_deg=given.pitch,
            neglect_twist=given.neglect_twist,
        )
    except NotABlade as refusal:
        tool.complain(str(refusal))
        return EXIT_FILE
    path = directory / f"{given.file.stem}_{given.direction}.nml"
    tool.save(path, lambda draft: draft.write_text(namelist(groups), encoding="utf-8"))
    if given.neglect_twist:
        angles = [given.pitch + twist for twist in blade.twist_deg]
        tool.complain(
            f"{given.file}: warning: setting angles of {min(angles):g} to {max(angles):g} degrees are taken as 0: "
            "their coupling of flap with edge is neglected"
        )
        if blade.coupling > LEAST_COUPLING:
            tool.complain(
                f"{given.file}: warning: what sections couple, {blade.coupling:.1g} of their stiffnesses, is neglected"
            )
    if blade.length and blade.off_axis > LEAST_BOW * blade.length:
        tool.complain(
            f"{given.file}: warning: the axis, which is up to {blade.off_axis:.3g} m off a straight line, is taken as straight"
        )
    if blade.tuners and given.direction == "flap":
        words = ", ".join(f"{name} = {value:g}" for name, value in blade.tuners.items())
        tool.complain(f"{given.file}: warning: {words}: factors of single modes are not applied")
    return EXIT_DONE


if __name__ == "__main__":
    sys.exit(main())
