"""Files that are written: whole or not at all, and in nobody else's place."""

from __future__ import annotations

import errno
import os
import secrets
from pathlib import Path
from typing import Callable

MARK = "made by beamwave-plot"  # in what it draws, by which it knows its own
START, END = 4096, 2**17  # bytes from the start, and of a PDF before the end, within which a mark stands
DRAFT = ".beamwave"  # how the name of a file begins that is not whole
NO_LINKS = {errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK, errno.EACCES}  # of a file system


def put(path: Path, write: Callable[[Path], object], *, overwrite: bool = False, mark: str = "") -> None:
    """Have `write` write a new file beside `path`, which gets that name when it is whole and on the disk.

    A file of that name is replaced if it has `mark` in its first or last bytes, which makes it our own, or with `overwrite`; a
    link is replaced itself, never what it leads to. Raises `FileExistsError` where something else is there, and what
    `write` raises; nothing is left of the new file then.
    """
    replace = overwrite or _is_our_own(path, mark)
    if not replace and os.path.lexists(path):
        raise _is_there(path)
    draft = path.with_name(f"{DRAFT}-{_group()}-{secrets.token_hex(8)}{path.suffix}")
    try:
        write(draft)
        _flush(draft)
        if replace:
            draft.replace(path)
        else:
            _give_free_name(draft, path)
    except OSError as failure:
        if failure.errno is None or isinstance(failure, FileExistsError):
            raise
        why = f"{path.parent} cannot be written: {failure.strerror}"
        raise OSError(failure.errno, why, str(path)) from failure
    finally:
        draft.unlink(missing_ok=True)


def make_directory(path: Path) -> None:
    """Make a directory and those that it lies in, unless it is there; raises `OSError`, saying what is in its place."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as failure:
        in_the_way = next(place for place in (path, *path.parents) if os.path.lexists(place))
        why = f"{in_the_way} is no directory; accepted: a directory, or a name that is free"
        raise NotADirectoryError(errno.ENOTDIR, why, f"--output {path}") from failure


def _group() -> int:
    """Number of this process and its helpers together."""
    return os.getpgrp() if hasattr(os, "getpgrp") else os.getpid()


def remove_drafts(directory: Path, group: int) -> None:
    """Remove what a process and its helpers left in a directory that ended while they wrote."""
    for draft in directory.glob(f"{DRAFT}-{group}-*"):
        draft.unlink(missing_ok=True)


def _is_our_own(path: Path, mark: str) -> bool:
    """Whether a file that is no link begins with the mark."""
    if not mark or path.is_symlink() or not path.is_file():
        return False
    with path.open("rb") as file:
        if mark.encode() in file.read(START):
            return True
        file.seek(max(0, path.stat().st_size - END))
        return mark.encode() in file.read()


def _is_there(path: Path) -> FileExistsError:
    return FileExistsError(errno.EEXIST, "is there already; accepted: --overwrite", str(path))


def _flush(draft: Path) -> None:
    with draft.open("r+b") as file:
        os.fsync(file.fileno())


def _give_free_name(draft: Path, path: Path) -> None:
    """Rename, unless something has taken the name meanwhile."""
    try:
        os.link(draft, path)
    except FileExistsError:
        raise _is_there(path) from None
    except OSError as failure:
        if failure.errno not in NO_LINKS:
            raise
        if os.path.lexists(path):
            raise _is_there(path) from None
        draft.rename(path)
