"""The finished cases that unfinished work holds, read independently of the program."""

import struct

HEADER = struct.Struct("=7q")
MARK = int.from_bytes(b"beamwave", "little")


def cases_in(directory):
    """Numbers of all cases with a whole record in some journal of the directory."""
    found = set()
    for path in sorted(directory.glob("*.cases")):
        found |= set(whole_records(path.read_bytes()))
    return found


def whole_records(data):
    """Case numbers of a journal's whole records; the first record holds no case."""
    place = 0
    while place + HEADER.size <= len(data):
        mark, case, numbers, letters, *_ = HEADER.unpack_from(data, place)
        assert mark == MARK
        place += HEADER.size + 8 * numbers + 8 * -(-letters // 8)
        if place <= len(data) and case > 0:
            yield case
