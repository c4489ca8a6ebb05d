"""The commands at work: file after file, each in a process of its own, within limits.

Whatever a file does to the library that reads it becomes one line with the file's name, and the next file follows.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import threading
import warnings
from argparse import Namespace
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Callable, NoReturn, Optional

from .result import NotAResult
from .terminal import Refusal, Streams, Words, printable, reason
from .writing import put, remove_drafts

try:
    import resource
except ImportError:  # Windows, which has no `os.fork` either
    resource = None  # type: ignore[assignment]

EXIT_DONE, EXIT_USAGE, EXIT_FILE, EXIT_STOPPED = 0, 2, 3, 5
Work = Callable[[], Optional[int]]  # on a file; returns an exit status, or None for 0

# What a file may take, in a fixed amount and by its size: far more than any takes that is what it seems to be.
SECONDS, SECONDS_PER_MB = 8.0, 1.0  # processor time of a step; a MB of text is read in 0.07 s
PICTURE_SECONDS, FILM_SECONDS = 60.0, 900.0  # the same of steps that draw
PATIENCE = 4  # times that by the clock, on a busy machine or where a read blocks
MEGABYTES, TIMES_SIZE = 650, 50  # beyond what Python itself holds; a file may hold its arrays compressed
STACK = 16  # MB of each thread that a library keeps for a processor
WORKERS = 4  # processes at most that share the work on a file
GARBAGE = 500_000  # objects made before unreachable ones among them are looked for: a picture makes about 100 000
TOO_LONG = "given up: it takes far longer than a file of this size should"


class WrongWords(Refusal):
    """What is wrong with the words of a command, and what would be accepted."""


def command(words: Words, work: Callable[[Namespace, Tool], int], argv: Sequence[str] | None = None) -> int:
    """Run a command of these words to its exit status: what `work` returns for them, 2 for wrong words, 3 where a file is refused."""
    if argv is None:
        gc.freeze()  # the libraries stay, and are not looked through for garbage when all ends
    given = words.parse_intermixed_args(argv)
    tool = Tool(overwrite=given.overwrite)

    def run() -> int:
        try:
            return work(given, tool)
        except WrongWords as wrong:
            tool.complain(reason(wrong))
            return EXIT_USAGE
        except OSError as failure:
            tool.complain(": ".join(filter(None, [failure.filename and str(failure.filename), reason(failure)])))
            return EXIT_FILE

    return tool.run(run)


def refuse_repeated(files: Iterable[Path], output: Path | None) -> None:
    """Raise `WrongWords` where files of one name would write the same file, in `output` or beside each."""
    targets = Counter((output or file.parent).resolve() / file.stem for file in files)
    twice = sorted(target.name for target, count in targets.items() if count > 1)
    if twice:
        other = "each by itself, with its own --output" if output is None else "each without --output"
        raise WrongWords(f"several files would write the same: {', '.join(twice)}; accepted: {other}")


class Tool(Streams):
    """A command that reads files and writes others: what it says, what it writes, and how it ends."""

    def __init__(self, *, overwrite: bool = False) -> None:
        super().__init__()
        self.overwrite = overwrite
        self._channel: int | None = None  # to the command, in the process of a file
        self._limit = SECONDS  # of the present step
        self._megabytes = 0.0  # size of the file
        self._warned: set[str] = set()  # what was said already

    def run(self, work: Callable[[], int]) -> int:
        """Run a command to its exit status, which is 5 where a signal stops it."""
        with _sigterm_as_sigint():
            try:
                status = work()
            except KeyboardInterrupt:
                self.complain("stopped")
                status = EXIT_STOPPED
        if self.lost:
            self.complain("standard output cannot be written")
            status = max(status, EXIT_FILE)
        return status

    def each(self, sources: Sequence[Path], directory: Path, work: Work) -> int:
        """Do the work on one file, or on several at once, that writes into `directory`; returns its exit status.

        A failure is one line on standard error that begins with the file's name.
        """
        name = ", ".join(map(str, sources))
        if not hasattr(os, "fork"):
            return self.attempt(name, work)
        self._limit = SECONDS
        self._megabytes = sum(source.stat().st_size for source in sources if source.is_file()) / 1e6
        ours, theirs = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(ours)
            self._be_child(theirs, name, work)
        os.close(theirs)
        why = TOO_LONG
        try:
            why = self._listen(ours)
        finally:
            os.close(ours)
            if why:
                _kill_all(child)
            ended = os.waitpid(child, 0)[1]
            remove_drafts(directory, child)
        if os.WIFEXITED(ended) and not why:
            return os.WEXITSTATUS(ended)
        if not why:
            number = os.WTERMSIG(ended)
            why = TOO_LONG if number == signal.SIGXCPU else f"reading it ended in signal {number}"
        self.complain(f"{name}: {why}")
        return EXIT_FILE

    def attempt(self, name: str, work: Work) -> int:
        """Do the work, with one line on standard error for its failure or warning; returns its exit status."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, kind, *_: self._warn(name, message, kind)
            try:
                return work() or EXIT_DONE
            except NotAResult as failure:  # which names the file itself
                self.complain(reason(failure))
            except FileExistsError as failure:
                self.complain(f"{failure.filename}: {reason(failure)}")
            except Exception as failure:  # whatever a library stumbles over
                self.complain(f"{name}: {reason(failure)}")
        return EXIT_FILE

    def _warn(self, name: str, message: Warning | str, kind: type[Warning]) -> None:
        """Say a warning, unless it is one library's to the authors of another, whatever filter that has set for it."""
        if not issubclass(kind, (DeprecationWarning, PendingDeprecationWarning, FutureWarning)):
            self.warn(f"{name}: warning: {message}")

    def save(self, path: Path, write: Callable[[Path], object], mark: str = "") -> None:
        """Have `write` write a file, as `put` does, and say its name."""
        put(path, write, overwrite=self.overwrite, mark=mark)
        self.say(str(path))

    def share(self, count: int, work: Callable[[Iterator[int]], Any]) -> list[Any]:
        """Let processes, one for each core, share works 0 … `count` − 1 (below 256); returns what `work` returns in each, as JSON has it.

        `work` takes numbers from its iterator as long as there are any, and opens for itself what it reads. Where a process dies this one
        dies with it.
        """
        workers = min(cores(), WORKERS, count) if self._channel is not None else 1
        tickets, full = os.pipe()
        os.write(full, bytes(range(count)))
        os.close(full)
        answers, ours = os.pipe()
        helpers = [_helper(lambda: os.write(ours, f"{json.dumps(work(_taken(tickets)))}\n".encode())) for _ in range(workers - 1)]
        os.close(ours)
        with open(answers, encoding="utf-8") as lines:
            found = [work(_taken(tickets)), *map(json.loads, lines)]
        os.close(tickets)
        for helper in helpers:
            ended = os.waitpid(helper, 0)[1]
            if os.WIFSIGNALED(ended):
                os.kill(os.getpid(), os.WTERMSIG(ended))
            if ended:
                raise Refusal("a process that helped has failed")
        return found

    def allow(self, seconds: float) -> None:
        """Let each of the next steps take so much processor time; what is said ends a step."""
        self._limit = seconds
        if self._channel is not None:
            self._tell(f"t{seconds}")

    def say(self, line: str) -> None:
        """Write a line to standard output."""
        super().say(line) if self._channel is None else self._tell(f"o{printable(line)}")

    def complain(self, line: str) -> None:
        """Write a line to standard error."""
        super().complain(line) if self._channel is None else self._tell(f"e{printable(line)}")

    def warn(self, line: str) -> None:
        """Write a line to standard error, once."""
        if self._channel is not None:
            self._tell(f"w{printable(line)}")
        elif line not in self._warned:
            self._warned.add(line)
            self.complain(line)

    def _seconds(self) -> float:
        return self._limit + SECONDS_PER_MB * self._megabytes

    def _tell(self, line: str) -> None:
        """Hand a line to the command; the next step begins."""
        data = f"{line}\n".encode()
        while data:
            data = data[os.write(self._channel, data) :]
        _limit_time(self._seconds())

    def _listen(self, channel: int) -> str:
        """Pass on what the process of a file says until it ends; returns why it is given up, or nothing."""
        silent, rest = 0, b""
        while silent <= PATIENCE * self._seconds():
            if not select.select([channel], [], [], 1.0)[0]:
                silent += 1  # counted, since the clock goes on while a process is suspended
                continue
            part = os.read(channel, 65536)
            if not part:
                return ""
            silent = 0
            *lines, rest = (rest + part).split(b"\n")
            for line in lines:
                kind, text = line[:1], line[1:].decode()
                if kind == b"t":
                    self._limit = float(text)
                else:
                    {b"o": self.say, b"e": self.complain, b"w": self.warn}[kind](text)
        return TOO_LONG

    def _be_child(self, channel: int, name: str, work: Work) -> NoReturn:
        """Do the work and end. What libraries print by themselves is dropped."""
        self._channel = channel
        status = EXIT_FILE
        try:
            gc.freeze()
            gc.set_threshold(GARBAGE)
            os.setpgid(0, 0)  # with its helpers, so that all can be ended
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_DFL)
            nowhere = os.open(os.devnull, os.O_RDWR)
            for number in (0, 1, 2):
                os.dup2(nowhere, number)
            _limit_memory(self._megabytes)
            _limit_time(self._seconds())
            status = self.attempt(name, work)
        finally:
            os._exit(status)


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _taken(tickets: int) -> Iterator[int]:
    """Numbers of works that are left, each of which one process gets."""
    while ticket := os.read(tickets, 1):
        yield ticket[0]


def _helper(work: Callable[[], object]) -> int:
    """Do the work in another process, which ends with it; returns its number."""
    child = os.fork()
    if child:
        return child
    status = EXIT_FILE
    try:
        work()
        status = EXIT_DONE
    finally:
        os._exit(status)


def _kill_all(child: int) -> None:
    """End the process of a file and its helpers."""
    with contextlib.suppress(OSError):  # it has ended, or has not its own group yet
        os.killpg(child, signal.SIGKILL)
    os.kill(child, signal.SIGKILL)


def _limit_memory(megabytes: float) -> None:
    """Refuse this process memory that a file of so many megabytes does not need, and keep it from dumping core."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    page = resource.getpagesize()
    more = 1e6 * (MEGABYTES + TIMES_SIZE * megabytes + STACK * (os.cpu_count() or 1))
    with contextlib.suppress(OSError, ValueError):  # a system that does not tell, or sets no such limit
        held = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5])  # pages of data and stacks
        _set_limit(resource.RLIMIT_DATA, page * min(held + int(more / page), os.sysconf("SC_PHYS_PAGES")))


def _limit_time(seconds: float) -> None:
    """Let this process take so many more seconds of the processor."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    _set_limit(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime + seconds) + 1)


def _set_limit(kind: int, limit: int) -> None:
    _, most = resource.getrlimit(kind)
    resource.setrlimit(kind, (limit if most == resource.RLIM_INFINITY else min(limit, most), most))


@contextlib.contextmanager
def _sigterm_as_sigint() -> Iterator[None]:
    """Let SIGTERM end a command as Ctrl-C does, so that nothing half-written is left."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
