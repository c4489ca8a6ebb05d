"""Tables as plain text: comment lines with '#', a line of column names, then one row per line."""

from pathlib import Path

from mpmath import mp, mpf

FOLDER = Path(__file__).parent
DIGITS = 40  # binary128 holds 34


def number(value):
    """Integers as they are, binary64 as its shortest decimal, computed values with DIGITS digits."""
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value)
    return mp.nstr(mpf(value), DIGITS)


def write_table(name, description, columns, rows):
    lines = [f"# {line}" for line in description.strip().splitlines()]
    lines.append(" ".join(columns))
    for row in rows:
        assert len(row) == len(columns)
        lines.append(" ".join(number(value) for value in row))
    (FOLDER / name).write_text("\n".join(lines) + "\n")
    print(f"{name}: {len(lines)} lines")
