"""Runs a command and prints its CPU seconds, wall seconds and peak memory in bytes.

Linux counts the memory of the process that started another into the other's peak, until it becomes the new program: so
this one stays small and imports nothing large.
"""

import os
import sys
import time

start = time.perf_counter()
child = os.posix_spawnp(sys.argv[1], sys.argv[1:], os.environ)
_, status, usage = os.wait4(child, 0)
wall = time.perf_counter() - start
print(usage.ru_utime + usage.ru_stime, wall, usage.ru_maxrss * 1024)
sys.exit(os.waitstatus_to_exitcode(status))
