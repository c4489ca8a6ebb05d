"""How long a file in NetCDF's classic formats has to be: its library reads what is cut off as zeros, without a word."""

from __future__ import annotations

import math
import os
import struct
from pathlib import Path
from typing import BinaryIO

SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}  # bytes, by the code of a type
STREAMING = {4: 2**32 - 1, 8: 2**64 - 1}  # a number of records that is not told, by the bytes of counts


def needed_length(path: Path) -> int | None:
    """The bytes that a file's header asks for; None in another format. Raises `EOFError` where the header is cut."""
    with path.open("rb") as file:
        mark = file.read(4)
        return _Header(file, mark[3]).needed() if mark[:3] == b"CDF" and mark[3:] in (b"\1", b"\2", b"\5") else None


class _Header:
    """A header of CDF-1, CDF-2 or CDF-5, read up to its variables."""

    def __init__(self, file: BinaryIO, version: int) -> None:
        self.file, self.length = file, os.fstat(file.fileno()).st_size
        self.count, self.offset = 8 if version == 5 else 4, 4 if version == 1 else 8  # bytes

    def needed(self) -> int:
        """The bytes up to the end of the last variable, less its padding."""
        records = self._number(self.count)
        records = 0 if records == STREAMING[self.count] else records
        dimensions = []
        for _ in range(self._list()):
            self._skip(self._number(self.count))
            dimensions.append(self._number(self.count))
        self._attributes()
        variables = [self._variable(dimensions) for _ in range(self._list())]
        sizes = [size for _, size, recorded in variables if recorded]
        step = sizes[0] if len(sizes) == 1 else sum(-(-size // 4) * 4 for size in sizes)  # one alone is not padded
        ends = [begin + size + (records - 1) * step for begin, size, recorded in variables if recorded and records]
        ends += [begin + size for begin, size, recorded in variables if size and not recorded]
        return max(ends, default=self.file.tell())

    def _variable(self, dimensions: list[int]) -> tuple[int, int, bool]:
        """Where a variable begins, its bytes, of a record where it has records, and whether it has."""
        self._skip(self._number(self.count))
        lengths = [dimensions[self._number(self.count)] for _ in range(self._number(self.count))]
        self._attributes()
        size = SIZES[self._number(4)]
        self._number(self.count)  # its size, which is wrong of a large one
        recorded = lengths[:1] == [0]
        return self._number(self.offset), size * math.prod(lengths[recorded:]), recorded

    def _attributes(self) -> None:
        for _ in range(self._list()):
            self._skip(self._number(self.count))
            size = SIZES[self._number(4)]
            self._skip(size * self._number(self.count))

    def _list(self) -> int:
        """How many entries a list has."""
        self._number(4)  # its tag
        return self._number(self.count)

    def _number(self, size: int) -> int:
        text = self.file.read(size)
        if len(text) < size:
            raise EOFError
        return int(struct.unpack({4: ">I", 8: ">Q"}[size], text)[0])

    def _skip(self, size: int) -> None:
        """Go over letters or values, which are padded to whole words."""
        end = self.file.tell() + -(-size // 4) * 4
        if end > self.length:
            raise EOFError
        self.file.seek(end)
