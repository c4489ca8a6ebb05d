"""The program with some of its streams on a terminal."""

import os
import pty

import pytest
from workplace import SECONDS


def ended_on_terminal(here, *words, streams=("stderr",)):
    """Run the program to its end: its status, and what the terminal got."""
    try:
        ours, theirs = pty.openpty()
    except OSError as reason:
        pytest.skip(f"no pseudo-terminal here: {reason}")
    running = here.start(*words, **dict.fromkeys(streams, theirs))
    os.close(theirs)
    shown = b""
    try:
        while part := os.read(ours, 65536):
            shown += part
    except OSError:  # how Linux says that the other end is closed
        pass
    os.close(ours)
    running.communicate(timeout=SECONDS)
    return running.returncode, shown.decode()
