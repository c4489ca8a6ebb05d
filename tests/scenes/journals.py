"""The finished cases that unfinished work holds, read independently of the program."""

import struct

LANES = 16
HEADER = struct.Struct(f"={6 + LANES}q")  # mark, work, case, count of numbers, letters, sums, sum of these
MARK = int.from_bytes(b"beamwave", "little")


def journals_in(directory):
    """The journals of unfinished work."""
    return sorted(directory.glob("*.journal"))


def cases_in(directory):
    """Numbers of all cases with a whole record in some journal of the directory."""
    found = set()
    for path in journals_in(directory):
        found |= {case for case, _, _ in records(path.read_bytes()) if case > 0}
    return found


def records(data):
    """A journal's whole records as (case, first byte, byte behind it); case 0 is the text of its work."""
    place = 0
    while place + HEADER.size <= len(data):
        mark, _, case, numbers, letters, *_ = HEADER.unpack_from(data, place)
        assert mark == MARK
        end = place + HEADER.size + 8 * numbers + 8 * -(-letters // 8)
        if end <= len(data):
            yield case, place, end
        place = end
