"""Which procedures a run enters, and who calls them, as valgrind's callgrind counts instructions."""

import re
import shutil
import subprocess
from typing import NamedTuple

SECONDS = 300  # far above any run here, which valgrind makes fifty times slower


class Entered(NamedTuple):
    """What was entered."""

    procedures: set  # symbols
    callers: dict  # symbol: set of symbols that call it


def missing():
    """Why nothing can be counted; empty where it can."""
    return "" if shutil.which("valgrind") else "there is no valgrind"


def entered(here, *words):
    """Run the program; None where valgrind does not know the processor's instructions, as of a build tuned for it."""
    counts = here.directory / "callgrind.out"
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={counts}", here.program, *words]
    ended = subprocess.run(
        command, cwd=here.directory, capture_output=True, text=True, timeout=SECONDS, stdin=subprocess.DEVNULL
    )
    if "unhandled instruction" in ended.stderr or "Illegal" in ended.stderr or "SIGILL" in ended.stderr:
        return None
    assert ended.returncode == 0, ended.stderr
    return read(counts.read_text())


def read(text):
    """A profile: `fn=(1) name` opens the lines of a procedure, `cfn=(2) name` names one that it calls."""
    names, procedures, callers, procedure = {}, set(), {}, ""
    for kind, number, name in re.findall(r"^(c?fn)=\((\d+)\)(?: (.+))?$", text, re.MULTILINE):
        if name:
            names[number] = re.sub(r"'\d+$", "", name)  # a recursion's depth
        if kind == "fn":
            procedure = names[number]
            procedures.add(procedure)
        else:
            callers.setdefault(names[number], set()).add(procedure)
    return Entered(procedures, callers)
