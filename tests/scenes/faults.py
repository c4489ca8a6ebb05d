"""Calls of the system that fail, or at which the process is killed, made so by a library that is preloaded into the program
(tests/faults/injector.c)."""

import errno
import os
import struct

KINDS = (
    "open fopen read pread write pwrite close fsync fdatasync fallocate ftruncate mmap rename link unlink mkdir rmdir opendir readdir "
    "stat flock fork malloc"
).split()
OF_BYTES = {"read", "write", "pread", "pwrite"}
NO_LOCKS = f"flock:1:+{errno.ENOSYS}"


class Injector:
    """Runs a command with a fault."""

    def __init__(self, library):
        self.library = library

    def environment(self, here, fault=None):
        """What the program needs around it for one run; `fault` is 'kind:number:what'."""
        counts = here.directory.with_name(here.directory.name + ".counts")
        counts.write_bytes(bytes(8 * len(KINDS)))
        environment = {**os.environ, **(here.environment or {})}
        preloaded = counts.with_suffix(".so")  # the place of the build may hold spaces, at which the list is divided
        if not preloaded.is_symlink():
            preloaded.symlink_to(self.library)
        environment["LD_PRELOAD"] = str(preloaded)
        environment["BEAMWAVE_FAULT_COUNTS"] = str(counts)
        environment["BEAMWAVE_FAULT_UNDER"] = str(here.directory)
        if fault:
            environment["BEAMWAVE_FAULT"] = fault
        return environment

    def run(self, here, *words, fault=None):
        """The program to its end, with this fault; how it ended, and how many calls of each kind there were."""
        before, here.environment = here.environment, self.environment(here, fault)
        try:
            ended = here.beamwave(*words)
        finally:
            here.environment = before
        counts = here.directory.with_name(here.directory.name + ".counts").read_bytes()
        return ended, dict(zip(KINDS, struct.unpack(f"={len(KINDS)}Q", counts)))
