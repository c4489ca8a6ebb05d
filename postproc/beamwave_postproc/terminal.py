"""What the commands print: lines in which nothing controls a terminal."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import unicodedata
from typing import Any, NoReturn, TextIO

UNSEEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}  # controls, formats such as right to left, stray bytes, ends of lines
LONGEST = 300  # letters of another library's reason


class Refusal(ValueError):
    """What this package itself says of a file: the text is all that there is to say."""


def printable(text: str) -> str:
    r"""Text as one line that a terminal may get: a letter that controls one, or is not seen, as its bytes, `\x1b`."""
    return "".join("".join(map(r"\x{:02x}".format, _bytes(c))) if _is_unseen(c) else c for c in text)


def _is_unseen(letter: str) -> bool:
    return unicodedata.category(letter) in UNSEEN and letter != "\t"


def _bytes(letter: str) -> bytes:
    """Bytes of a letter in UTF-8; a stray byte has come in as a surrogate (PEP 383)."""
    code = ord(letter)
    return bytes([code - 0xDC00]) if 0xDC80 <= code <= 0xDCFF else letter.encode("utf-8", "surrogatepass")


def reason(failure: BaseException) -> str:
    """Why something failed, in one line; what another library says is shortened, and named by its kind."""
    if isinstance(failure, Refusal):
        return str(failure)
    if isinstance(failure, OSError) and failure.strerror:
        return str(failure.strerror)
    if isinstance(failure, MemoryError):
        return "not enough memory: it takes far more than a file of this size should"
    said = " ".join(str(failure).split())
    said = said if len(said) <= LONGEST else f"{said[:LONGEST]}…"
    return f"{type(failure).__name__}: {said}" if said else type(failure).__name__


class Words(argparse.ArgumentParser):
    """The words of a command line; what is wrong with them is said as one line."""

    def error(self, message: str) -> NoReturn:
        """End with status 2."""
        super().error(printable(message))


class Streams:
    """Standard output and standard error of a command."""

    def __init__(self) -> None:
        self.lost = False  # standard output could not be written
        for number in (0, 1, 2):  # where one is closed, the next file that is opened would become it
            try:
                os.fstat(number)
            except OSError:
                os.open(os.devnull, os.O_RDWR)
        for stream in (sys.stdout, sys.stderr):
            if hasattr(stream, "reconfigure"):
                stream.reconfigure(errors="backslashreplace")

    def say(self, line: str) -> None:
        """Write a line to standard output. That the reader has closed a pipe, as `head` does, is no failure."""
        try:
            _write(sys.stdout, line)
        except OSError as failure:
            self.lost = self.lost or not isinstance(failure, BrokenPipeError)
            _to_nowhere(sys.stdout)

    def complain(self, line: str) -> None:
        """Write a line to standard error; nowhere is left to tell of a failure."""
        try:
            _write(sys.stderr, line)
        except OSError:
            _to_nowhere(sys.stderr)


def _write(stream: Any, line: str) -> None:
    if stream is not None:
        stream.write(printable(line) + "\n")
        stream.flush()


def _to_nowhere(stream: TextIO) -> None:
    """What still waits in a stream that cannot be written goes nowhere, when Python ends."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
