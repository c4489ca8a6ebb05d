"""Designs of many cases, as the table of a `&design`, and the command `beamwave-design` that writes one."""

from __future__ import annotations

import argparse
import difflib
import math
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Callable

import numpy as np
import pandas as pd

from .run import STREAMS, find_program
from .terminal import Refusal, Words
from .tool import EXIT_DONE, EXIT_FILE, Tool, WrongWords, command

MOST_ROWS = 1_000_000  # that `&design` takes
MOST_WHOLE = 2**31 - 1  # that a scene takes
LEAST_SHARE = np.finfo(float).tiny  # of probabilities, since a normal number has no end
MOST_SHARE = 1.0 - np.finfo(float).epsneg
NAME = re.compile(r"([a-z]\w*)(?:\(\d+\))?%([a-z]\w*)(?:\(\d+\))?", re.IGNORECASE | re.ASCII)  # as `beam%length(2)`
MARK = "# made by beamwave-design"
Inverse = Callable[[np.ndarray], np.ndarray]


class Distribution:
    """How an input is distributed; `inverse` gives its value for each probability 0 … 1, in the unit of the scene. Raises
    `Refusal` where a value may pass the largest number."""

    def __init__(self, words: str, inverse: Inverse) -> None:
        self.words = words
        self.inverse = inverse
        with np.errstate(over="ignore", invalid="ignore"):
            ends = inverse(np.array([LEAST_SHARE, MOST_SHARE]))
        _need(bool(np.isfinite(ends).all()), words, f"values, differences and ratios below {np.finfo(float).max:.2g}")

    def __repr__(self) -> str:
        return self.words


def uniform(low: float, high: float) -> Distribution:
    """Every value between both is as likely."""
    _need(low < high, f"uniform,{low:g},{high:g}", "the lower end first")
    return Distribution(_words("uniform", low, high), lambda p: low + p * (high - low))


def log_uniform(low: float, high: float) -> Distribution:
    """Every logarithm between both is as likely: for what is known to within powers of ten."""
    _need(0.0 < low < high, f"log,{low:g},{high:g}", "0 < low < high")
    return Distribution(_words("log", low, high), lambda p: low * (high / low) ** p)


def normal(mean: float, deviation: float) -> Distribution:
    """A normal distribution. It has no ends: what must be above 0 is better lognormal."""
    _need(deviation > 0.0, f"normal,{mean:g},{deviation:g}", "a deviation above 0")
    return Distribution(_words("normal", mean, deviation), lambda p: mean + deviation * _normal(p))


def lognormal(mean: float, deviation: float) -> Distribution:
    """Normal in its logarithm; the mean and the standard deviation are those of the number itself."""
    _need(mean > 0.0 and deviation > 0.0, f"lognormal,{mean:g},{deviation:g}", "both above 0")
    relative = deviation / mean
    variance = math.log1p(relative * relative)  # a product, unlike a power, may be infinite
    median = mean / math.exp(0.5 * variance)
    return Distribution(
        _words("lognormal", mean, deviation), lambda p: median * np.exp(math.sqrt(variance) * _normal(p))
    )


def whole(low: int, high: int) -> Distribution:
    """Every whole number from one to the other, both included."""
    inside = -MOST_WHOLE <= low < high <= MOST_WHOLE
    _need(
        inside and low == int(low) and high == int(high),
        f"whole,{low:g},{high:g}",
        f"two whole numbers, the lower first, at most ±{MOST_WHOLE}",
    )
    count = int(high) - int(low) + 1
    return Distribution(
        _words("whole", low, high), lambda p: int(low) + np.minimum((p * count).astype(int), count - 1)
    )


DISTRIBUTIONS = {"uniform": uniform, "log": log_uniform, "normal": normal, "lognormal": lognormal, "whole": whole}


def latin_hypercube(inputs: Mapping[str, Distribution], rows: int, *, seed: int = 0) -> pd.DataFrame:
    """Return a design of `rows` cases, a column for each input `group%name`: each input has one value in each of as many
    equally likely parts of its distribution, and the inputs are independent."""
    from scipy.stats import qmc  # here, since pictures do without it and it takes 1 s to import

    return _table(inputs, qmc.LatinHypercube(d=_count(inputs, rows), seed=seed).random(rows))


def sobol_sequence(inputs: Mapping[str, Distribution], rows: int, *, seed: int = 0) -> pd.DataFrame:
    """The same by a scrambled Sobol sequence, which fills the space of few inputs more evenly; rows have to be a power of 2."""
    power = rows.bit_length() - 1
    if rows != 2**power:
        raise Refusal(f"a Sobol sequence of {rows} rows is not balanced; accepted: a power of 2, as {2**power} or {2 ** (power + 1)}")
    from scipy.stats import qmc

    return _table(inputs, qmc.Sobol(d=_count(inputs, rows), scramble=True, seed=seed).random_base2(power))


def write_design(table: pd.DataFrame, path: str | Path, comments: Sequence[str] = ()) -> None:
    """Write a design as the CSV that `&design file` reads: every number to its last digit, and no index.

    Raises `Refusal` for a table that no scene can take: one without rows or with too many, a column that is not called `group%name`
    or comes twice, a value that is not a finite number. Whether the scene has an input of that name is checked by `beamwave run`.
    """
    rows = zip(*_columns(table))
    with Path(path).open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(f"{line}\n" for line in (*comments, ",".join(table)))
        file.writelines(",".join(map(repr, row)) + "\n" for row in rows)


def _columns(table: pd.DataFrame) -> list[list[float]]:
    """The numbers of each column; raises `Refusal` as `write_design` does."""
    names = [str(name) for name in table]
    for name in names:
        if not NAME.fullmatch(name):
            raise Refusal(f"{name!r} names no input; accepted: 'group%name'")
        if [one.lower() for one in names].count(name.lower()) > 1:
            raise Refusal(f"{name!r} has two columns; accepted: each name once")
    if not names or not 1 <= len(table) <= MOST_ROWS:
        raise Refusal(f"holds {len(table)} rows of {len(names)} names; accepted: a name or more, and 1 to {MOST_ROWS} rows")
    return [_finite(name, table[name]) for name in table]


def _finite(name: str, column: pd.Series) -> list[float]:
    """The values of a column; raises `Refusal` where one is not a finite number."""
    numbers = pd.to_numeric(column.astype(object), errors="coerce")
    wrong = ~np.isfinite(numbers.to_numpy(float)) | column.map(lambda value: isinstance(value, (bool, np.bool_))).to_numpy(bool)
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0])
        value = str(column.iloc[row])
        raise Refusal(f"row {row + 1}: {name}: {value!r} is not a finite number; accepted: a finite number as 2.5 or -1e-3")
    return numbers.tolist()


def check_name(name: str) -> None:
    """Raise `Refusal` where the program, if it is found, knows no input of this name; else `beamwave run` finds out."""
    group, own = NAME.fullmatch(name).groups()
    try:
        told = subprocess.run([find_program(), "describe", group], **{**STREAMS, "stdout": subprocess.PIPE}, check=False)
    except OSError:
        return
    if told.returncode:
        raise Refusal(f"{name!r} is not a known name: {told.stderr.strip().removeprefix('beamwave: ')}")
    known = re.findall(r"^\| `(\w+)`", told.stdout, re.MULTILINE)
    if own.lower() not in known:
        like = difflib.get_close_matches(own, known, 1)
        hint = f" (did you mean {like[0]}?)" if like else ""
        raise Refusal(f"{name!r} is not a known name{hint}; accepted: {' '.join(known)}")


def _normal(share: np.ndarray) -> np.ndarray:
    """Quantiles of the normal distribution of mean 0 and standard deviation 1."""
    from scipy.special import ndtri

    return ndtri(share)


def _table(inputs: Mapping[str, Distribution], probabilities: np.ndarray) -> pd.DataFrame:
    inside = np.clip(probabilities, LEAST_SHARE, MOST_SHARE)
    return pd.DataFrame({name: one.inverse(inside[:, i]) for i, (name, one) in enumerate(inputs.items())})


def _count(inputs: Mapping[str, Distribution], rows: int) -> int:
    if not inputs:
        raise Refusal("no input varies; accepted: at least one")
    if not 1 <= rows <= MOST_ROWS:
        raise Refusal(f"{rows} rows; accepted: 1 to {MOST_ROWS}")
    return len(inputs)


def _words(word: str, *numbers: float) -> str:
    """A distribution as the command takes it, its numbers in as few digits as read back the same."""
    texts = [next(text for text in (f"{number:.{n}g}" for n in range(4, 18)) if float(text) == number) for number in numbers]
    return ",".join([word, *texts])


def _need(so: bool, words: str, accepted: str) -> None:
    if not so:
        raise Refusal(f"{words}; accepted: {accepted}")


def parse_input(words: str) -> tuple[str, Distribution]:
    """The name and the distribution of `group%name=word,number,number`. Raises `Refusal`."""
    name, mark, what = words.partition("=")
    word, *numbers = what.split(",")
    name, word = name.strip().lower(), word.strip()
    if not mark or not NAME.fullmatch(name):
        raise Refusal(f"{words}: accepted: group%name=word,number,number, as beam%length=uniform,0.9,1.1")
    if word not in DISTRIBUTIONS:
        raise Refusal(f"{words}: no distribution is called {word!r}; accepted: {', '.join(DISTRIBUTIONS)}")
    try:
        values = [float(number) for number in numbers]
    except ValueError:
        values = []
    if len(values) != 2 or not all(map(math.isfinite, values)):
        raise Refusal(f"{words}: accepted: two numbers behind the word, as beam%length=uniform,0.9,1.1")
    try:
        return name, DISTRIBUTIONS[word](*values)
    except Refusal as refusal:
        raise Refusal(f"{name}: {refusal}") from None


def parser() -> argparse.ArgumentParser:
    """Return the words of the command line."""
    words = Words(
        prog="beamwave-design",
        description="Writes the table of a &design: many cases, each with other numbers.",
        epilog="An input is group%name=word,number,number in the unit of the scene. The words: uniform,LOW,HIGH; "
        "log,LOW,HIGH; normal,MEAN,DEVIATION; lognormal,MEAN,DEVIATION; whole,LOW,HIGH.",
    )
    words.add_argument("table", metavar="TABLE.csv", type=Path, help="what is written")
    words.add_argument("inputs", metavar="INPUT", nargs="+", help="an input that varies, as beam%%length=uniform,0.9,1.1")
    words.add_argument("--rows", metavar="N", type=int, default=100, help="how many cases (default: 100)")
    words.add_argument("--sobol", action="store_true", help="a Sobol sequence instead of a Latin hypercube")
    words.add_argument("--seed", metavar="N", type=int, default=0, help="another design of the same kind (default: 0)")
    words.add_argument("--overwrite", action="store_true", help="replace a file that is there")
    return words


def main(argv: Sequence[str] | None = None) -> int:
    """Write the table; 0, or 2 for wrong words, or 3 if it could not be written."""
    return command(parser(), _run, argv)


def _run(given: argparse.Namespace, tool: Tool) -> int:
    try:
        inputs = dict(map(parse_input, given.inputs))
        if len(inputs) < len(given.inputs):
            raise Refusal("an input is given twice; accepted: each name once")
        for name in inputs:
            check_name(name)
        if given.seed < 0:
            raise Refusal(f"--seed {given.seed}; accepted: 0 or more")
        draw = sobol_sequence if given.sobol else latin_hypercube
        table = draw(inputs, given.rows, seed=given.seed)
    except Refusal as refusal:
        raise WrongWords(str(refusal)) from refusal
    kind = "Sobol sequence" if given.sobol else "Latin hypercube"
    comments = [f"{MARK}: {kind} of {given.rows} rows, seed {given.seed}"]
    comments += [f"# {name}={one}" for name, one in inputs.items()]

    def save() -> int:
        tool.save(given.table, lambda path: write_design(table, path, comments))
        return EXIT_DONE

    return EXIT_FILE if tool.attempt(str(given.table), save) else EXIT_DONE


if __name__ == "__main__":
    sys.exit(main())
