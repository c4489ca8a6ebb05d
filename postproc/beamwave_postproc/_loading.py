"""Garbage is not looked for while the libraries load: next to none of what they make is any, and looking takes a seventh of the time."""

from __future__ import annotations

import gc

COLLECTS = gc.isenabled()
gc.disable()


def done() -> None:
    """Let garbage be looked for as before, among what has been loaded last of all."""
    if COLLECTS:
        if gc.get_freeze_count() == 0:
            gc.freeze()
            gc.unfreeze()  # into the oldest generation
        gc.enable()
