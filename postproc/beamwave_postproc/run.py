"""From Python to the program and back: a scene in, its result out."""

from __future__ import annotations

import errno
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Callable, Union

import numpy as np
import xarray as xr

from .result import open_result

DONE, UNTRUSTED = 0, 4  # exit statuses with a result
PROGRAM = "BEAMWAVE"  # environment variable with the program's path
CHECKOUT = Path("postproc", "beamwave_postproc", "__init__.py")  # by which the top of a checkout is known
STREAMS: dict[str, Any] = {
    "stdin": subprocess.DEVNULL,
    "stdout": subprocess.DEVNULL,
    "stderr": subprocess.PIPE,
    "text": True,
    "errors": "replace",
}
READING = threading.Lock()  # NetCDF's library knows no threads
Scene = Union[str, "os.PathLike[str]", Mapping[str, Any]]


class RunFailed(RuntimeError):
    """The program ended without a result; `status` is its exit status, and the text what it wrote to standard error."""

    def __init__(self, status: int, said: str) -> None:
        super().__init__(f"beamwave ended with status {status}\n{said}".rstrip())
        self.status = status


class ProgramWarning(UserWarning):
    """What the program warns of: physics out of range, an error larger than one would expect; `notes` say it too."""


class Untrusted(ProgramWarning):
    """The result holds numbers that cannot be trusted; `case_status` and `notes` say which and why."""


def run(
    scene: Scene, output: str | Path | None = None, *, overwrite: bool = False, program: str | Path | None = None
) -> xr.Dataset:
    """Run one scene and return its result, in memory.

    `scene` is one of three:

    - a mapping of groups, in which a group that is there several times is a list: {"beam": {"length": 1.0, …}, "sweep":
      [{…}, {…}]}. Files of its record are looked for from the working directory.
    - a text that begins as a namelist does, with `&` behind comments and blanks.
    - any other text, or a `Path`: the path of a namelist file. A path that itself begins with `&` has to be a `Path`.

    The result is kept in the directory `output` where given: a mapping's and a text's as `scene.nc`. One of the same
    scene that is there is returned as it is; one of another scene is replaced with `overwrite`, and else is an error.
    The program is `program`, else $BEAMWAVE, else `beamwave` on the PATH, else the one built in the checkout: the one
    that this package lies in, or its Python's `.venv`, or the directory in which it runs.

    Raises `ValueError` for an empty scene and `TypeError` for what is none of the three, `FileNotFoundError` without a
    file of that name or a program, `IsADirectoryError` for a directory, and `RunFailed` with the program's messages
    where it ends without a result. Each warning of the program becomes a `ProgramWarning`; all together are one of
    `Untrusted` numbers where some cannot be trusted (exit status 4).
    """
    check_output(output)
    result, said = call_program(scene, output, overwrite, program, _waited_for)
    for warning in said:
        warnings.warn(warning, stacklevel=2)
    return result


def call_program(
    scene: Scene,
    output: str | Path | None,
    overwrite: bool,
    program: str | Path | None,
    wait: Callable[[list[str]], tuple[int, str]],
    name: str = "scene",
) -> tuple[xr.Dataset, list[ProgramWarning]]:
    """A scene's result and its warnings; raises as `run` does.

    `wait` runs a command to its end, and returns its exit status and what it wrote to standard error. A scene that is
    no file is called `name`.
    """
    with tempfile.TemporaryDirectory(prefix="beamwave-") as scratch:
        path = _scene_file(scene, Path(scratch), name)
        command = find_program(program)
        directory = Path(scratch) / "output" if output is None else Path(output)
        word = f".{os.sep}{path}" if str(path).startswith("-") else str(path)
        words = [command, "run", word, "--output", str(directory), "--quiet", *(["--overwrite"] if overwrite else [])]
        status, text = wait(words)
        if status not in (DONE, UNTRUSTED):
            raise RunFailed(status, text.replace(f"{scratch}{os.sep}", ""))
        with READING, open_result(directory / f"{path.stem}.nc") as ds:
            result = ds.load()
        if output is None:
            result.encoding.pop("source", None)  # a file that is gone
    said = warnings_in(text)
    if status == UNTRUSTED:
        return result, [Untrusted("\n".join(said))]
    return result, [ProgramWarning(one) for one in said]


def check_output(output: str | Path | None) -> None:
    """Raise `ValueError` for a directory without a name."""
    if output is not None and not str(output):
        raise ValueError("output is empty; accepted: a directory, or None")


def _waited_for(words: list[str]) -> tuple[int, str]:
    """Run a command to its end."""
    with hearing_sigterm(), subprocess.Popen(words, **STREAMS) as process:
        try:
            said = process.communicate()[1]
        except SystemExit:
            process.terminate()
            raise
        except BaseException:
            process.kill()
            raise
    return process.returncode, said


@contextmanager
def hearing_sigterm() -> Iterator[None]:
    """Make SIGTERM raise `SystemExit`: it would end this process and leave the programs that it has begun to run on. Where the
    caller hears it in a way of its own, or this is no main thread, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def leave(number: int, _: object) -> None:
        raise SystemExit(128 + number)  # the status that shells give to what a signal ended

    signal.signal(signal.SIGTERM, leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def warnings_in(text: str) -> list[str]:
    """Each warning of what the program wrote to standard error, without the scene's name before it."""
    return [part.strip() for part in re.split(r"^.*?: warning: ", text, flags=re.MULTILINE) if part.strip()]


def find_program(program: str | Path | None = None) -> str:
    """Path of the program `beamwave`; raises `FileNotFoundError`, naming where it was looked for."""
    built = [checkout / "build" / "bin" / "beamwave" for checkout in _checkouts()]
    for candidate in (program, os.environ.get(PROGRAM), "beamwave", *built):
        found = candidate and shutil.which(str(candidate))
        if found:
            return found
        if candidate is not None and candidate is program:
            raise FileNotFoundError(f"{program} is no program")
    where = f"not at {' or '.join(map(str, built))}" if built else "in no checkout that holds this Python or directory"
    raise FileNotFoundError(
        f"no program beamwave: not in ${PROGRAM}, not on the PATH, {where}; build it by ./run.sh, or give program="
    )


def _checkouts() -> list[Path]:
    """Checkouts of beamwave around this package, around the environment it is installed in, and around here."""
    here = Path.cwd()
    around = [*Path(__file__).resolve().parents, *Path(sys.prefix).absolute().parents, here, *here.parents]
    return list(dict.fromkeys(place for place in around if (place / CHECKOUT).is_file()))


def namelist(groups: Mapping[str, Any]) -> str:
    """Groups as the text of a namelist file."""
    text = ""
    for name, group in groups.items():
        for one in group if isinstance(group, (list, tuple)) else [group]:
            lines = "".join(f"  {item} = {_value(value)}\n" for item, value in (one or {}).items())
            text += f"&{name}\n{lines}/\n"
    return text


def _value(value: Any) -> str:
    """One value, or several, as Fortran reads them."""
    if isinstance(value, (bool, np.bool_)):
        return ".true." if value else ".false."
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, (list, tuple, np.ndarray)):
        return ", ".join(_value(one) for one in value)
    return repr(value.item() if isinstance(value, np.generic) else value)


WITH_FILES = {"record": "file", "design": "file", "force": "file", "base": "file", "identify": "with"}


def _with_paths(groups: Mapping[str, Any]) -> Mapping[str, Any]:
    """The same with all files as they are found from here, since the scene will lie elsewhere."""
    return {group: _placed_in(value, WITH_FILES.get(str(group).lower())) for group, value in groups.items()}


def _placed_in(group: Any, holder: str | None) -> Any:
    """A group, or a list of several, whose name `holder` holds files as they are found from here; None: it has none."""
    if isinstance(group, (list, tuple)):
        return [_placed_in(one, holder) for one in group]
    if holder is None or not group:
        return group
    return {name: _placed(value) if str(name).lower() == holder else value for name, value in group.items()}


def _placed(files: Any) -> Any:
    """One path, or several, from the root."""
    if isinstance(files, (str, Path)):
        return str(Path(files).absolute())
    return [str(Path(file).absolute()) for file in files]


def _scene_file(scene: Scene, scratch: Path, name: str) -> Path:
    """Path of the scene: as given, or a file of its text in `scratch`, of this name; raises as `run` does."""
    if not is_scene(scene):
        raise TypeError(f"a scene is a path, a text or a mapping of groups, and no {type(scene).__name__}")
    text = namelist(_with_paths(scene)) if isinstance(scene, Mapping) else scene
    if not str(text).strip():
        raise ValueError("the scene is empty; accepted: a path, the text of a namelist, or a mapping with a group")
    if is_text(scene):
        path = scratch / f"{name}.nml"
        path.write_text(text, encoding="utf-8")
        return path
    path = Path(text)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "a directory; accepted: the path of one scene", str(path))
    if not path.exists():
        raise FileNotFoundError(errno.ENOENT, "no such scene", str(path))
    return path


def is_scene(scene: object) -> bool:
    """Whether it is of one of the types that `run` accepts."""
    return isinstance(scene, (str, os.PathLike, Mapping))


def is_text(scene: Scene) -> bool:
    """Whether a scene is no file: a mapping, or the text of a namelist."""
    return isinstance(scene, Mapping) or (isinstance(scene, str) and _is_namelist(scene))


def _is_namelist(text: str) -> bool:
    """Whether a text begins as a namelist does: with a group, behind comments and blanks."""
    lines = (line.strip() for line in text.splitlines())
    return next((line for line in lines if line and not line.startswith("!")), "").startswith("&")
