"""Many scenes in processes at the same time, and their results in the order of the scenes."""

from __future__ import annotations

import subprocess
import threading
import warnings
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Callable, Literal, Union

import xarray as xr

from .run import STREAMS, RunFailed, Scene, call_program, check_output, find_program, hearing_sigterm, is_scene, is_text
from .tool import cores

STOPPED = 5  # exit status of a run that was stopped in order
Progress = Callable[[int, int], object]
Outcome = Union[xr.Dataset, Exception]


def run_many(
    scenes: Iterable[Scene],
    processes: int | None = None,
    output: str | Path | None = None,
    *,
    overwrite: bool = False,
    program: str | Path | None = None,
    errors: Literal["raise", "return"] = "raise",
    progress: Progress | None = None,
) -> list[Outcome]:
    """Run scenes in `processes` at a time, by default one for each core; returns their results, in their order.

    Scenes, `output`, `overwrite` and `program` are those of `run`. In `output` the results of mappings and texts are
    called `scene_1.nc`, `scene_2.nc`, … by their places among the scenes. The same call goes on where one was stopped:
    a result that is there is returned as it is, and unfinished work is continued.

    A scene that fails stops no other. With `errors="raise"` the first exception, in the order of the scenes, is raised
    when all are done; with `errors="return"` exceptions stand in the place of results. Warnings of the program become
    Python warnings, in the order of the scenes, before that. `progress(done, total)` is called in this thread as scenes
    end.

    Ctrl-C, SIGTERM (as `SystemExit`, where the caller does not hear it otherwise) or an exception of `progress` stops all
    runs in order, and is raised when they have ended; where `output` is given, what is finished of sweeps is saved. A second
    signal ends them at once.

    Raises `ValueError` for what is no list of scenes, for `processes` below 1, for scenes that would write the same file into
    `output`, and for another word than these two for `errors`, and `FileNotFoundError` without a program, all before
    anything is run.
    """
    scenes = _listed(scenes)
    check_output(output)
    if errors not in ("raise", "return"):
        raise ValueError(f"errors is {errors!r}; accepted: 'raise' or 'return'")
    processes = cores() if processes is None else processes
    if not isinstance(processes, int) or processes < 1:
        raise ValueError(f"processes is {processes!r}; accepted: a whole number from 1 on")
    names = [f"scene_{number}" if is_text(scene) else Path(scene).stem for number, scene in enumerate(scenes, 1)]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if output is not None and twice:
        raise ValueError(f"several scenes would write the same result: {', '.join(twice)}")
    command = find_program(program)
    crew = _Crew()
    with hearing_sigterm(), ThreadPoolExecutor(processes, thread_name_prefix="beamwave") as pool:
        futures = [
            pool.submit(call_program, scene, output, overwrite, command, crew.run, name)
            for scene, name in zip(scenes, names)
        ]
        try:
            for done, _ in enumerate(as_completed(futures), 1):
                if progress is not None:
                    progress(done, len(futures))
        except BaseException:
            crew.stop()
            _wait_for(futures, crew)
            raise
    return _results(futures, errors)


def _listed(scenes: Iterable[Scene]) -> list[Scene]:
    """The scenes as a list; raises `ValueError` where they are one scene, or one of them is none."""
    if is_scene(scenes) or not isinstance(scenes, Iterable):
        raise ValueError(f"scenes is a {type(scenes).__name__}; accepted: a list of scenes, of one as of many")
    listed = list(scenes)
    for number, scene in enumerate(listed, 1):
        if not is_scene(scene):
            raise ValueError(f"scene {number} is a {type(scene).__name__}; accepted: a path, a text or a mapping of groups")
    return listed


def _results(futures: list[Future], errors: str) -> list[Outcome]:
    """Results or exceptions, after the warnings of all."""
    results: list[Outcome] = []
    for future in futures:
        failure = future.exception()
        if failure is not None:
            results.append(failure)
            continue
        result, said = future.result()
        results.append(result)
        for warning in said:
            warnings.warn(warning, stacklevel=3)
    for result in results if errors == "raise" else ():
        if isinstance(result, Exception):
            raise result
    return results


def _wait_for(futures: list[Future], crew: _Crew) -> None:
    """Wait until all runs have ended; another signal asks them once more, which ends them at once."""
    for future in futures:
        future.cancel()
    for future in futures:
        while not future.done():
            try:
                future.exception(timeout=0.1)
            except (KeyboardInterrupt, SystemExit):
                crew.stop()
            except Exception:
                continue


class _Crew:
    """The programs that are running.

    They do not hear a terminal's Ctrl-C themselves: a second signal would end them at once.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._running: set[subprocess.Popen] = set()
        self._stopped = False

    def run(self, words: list[str]) -> tuple[int, str]:
        """Run a command to its end; none is begun any more once they are stopped."""
        with self._lock:
            if self._stopped:
                raise RunFailed(STOPPED, "stopped before it was begun")
            process = subprocess.Popen(words, start_new_session=True, **STREAMS)
            self._running.add(process)
        try:
            said = process.communicate()[1]
        finally:
            with self._lock:
                self._running.discard(process)
        return process.returncode, said

    def stop(self) -> None:
        """Ask all to stop in order."""
        with self._lock:
            self._stopped = True
            for process in self._running:
                process.terminate()
