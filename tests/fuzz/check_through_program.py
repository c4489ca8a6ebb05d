"""Damaged scenes through the whole program.

`beamwave check` takes each, or refuses it with messages that name a place, and leaves nothing behind. What it
takes means the same to f90nml.

check_through_program.py BEAMWAVE FUZZ_SCENE_READER COUNT SCENE …     BEAMWAVE_SEED sets the seed
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import f90nml
except ImportError:
    f90nml = None

SECONDS = 60  # far above any check: what takes longer hangs
LOCATED = re.compile(r"\d{5}\.nml(:\d+)?: (text|&\w*|\w+%\S*): \S")
GLUED_COMMENT = re.compile(r"[^\s!]!")  # f90nml 1.4 takes it for a part of the word before it
PLACE = re.compile(r"\(\d+\)")  # of one of several, in a swept name
EXIT_FILE = 3
REPLACED = "replaced by a sweep"


def main(program, generator, count, *scenes):
    """Try `count` texts and print what went wrong; return the exit status."""
    with tempfile.TemporaryDirectory() as directory:
        made = subprocess.run([generator, count, *scenes, "--write", directory], timeout=SECONDS, check=False)
        texts = sorted(Path(directory).glob("*.nml"))
        faults = [] if made.returncode == 0 and len(texts) == int(count) else ["the texts were not made"]
        for text in texts:
            fault = fault_of_program(program, text) or fault_of_meaning(text)
            if fault:
                faults.append(f"{text.name}: {fault}\n{text.read_text(encoding='latin-1')}")
        left = sorted(path.name for path in Path(directory).iterdir() if path.suffix not in {".nml", ".resolved"})
        if left:
            faults.append(f"left behind: {left}")
    print(f"{len(texts)} texts through the program" + ("" if f90nml else "; no f90nml: meanings are not compared"))
    print(*faults, sep="\n")
    return 1 if faults else 0


def fault_of_program(program, text):
    """What the program does wrong with a text; empty for nothing."""
    command = [program, "check", text.name]
    try:
        ended = subprocess.run(command, cwd=text.parent, capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        return "hangs"
    accepted = text.with_suffix(".resolved").exists()
    messages = ended.stderr.decode("utf-8").splitlines()
    if accepted and ended.returncode == EXIT_FILE and all(": cannot be read: " in line for line in messages):
        return ""  # a record whose file is not here
    if ended.returncode != (0 if accepted else 2):
        return f"status {ended.returncode}: {messages}"
    if accepted:
        return ""
    return ", ".join(f"no place: {line}" for line in messages if not LOCATED.match(line)) if messages else "no message"


def fault_of_meaning(text):
    """Where f90nml reads a text otherwise than the program resolved it; empty for nothing."""
    resolved = text.with_suffix(".resolved")
    words = text.read_text(encoding="latin-1")
    if f90nml is None or not resolved.exists() or GLUED_COMMENT.search(words):
        return ""
    said, said_sweeps = parts(words)
    held, held_sweeps = parts(resolved.read_text(encoding="latin-1"))
    if len(said_sweeps) != len(held_sweeps):
        return "another number of sweeps"
    unknown = [values for name, values in held.items() if name.startswith("identify(")]
    for sweep in [*held_sweeps, *unknown]:
        group, name = sweep["parameter"].lower().split("%")
        held[group if group in held else f"{group}(1)"][PLACE.sub("", name)] = REPLACED
    for sweep in [*said_sweeps, *held_sweeps]:  # `body(02)%mass` is held as `body(2)%mass`, or `body%mass` of a single one
        sweep["parameter"] = PLACE.sub("", sweep["parameter"])
    if "after" in said.get("modes", {}):  # where there is one set of modes, it may only repeat `before`, and goes unsaid
        held["modes"].setdefault("after", held["modes"]["before"])
    added = set(held) - set(said) - {"scene", "modes"}
    pairs = [*zip(said_sweeps, held_sweeps), *((said[group], held.get(group, {})) for group in said)]
    differing = [name for one, other in pairs for name in one if not alike(one[name], other.get(name))]
    return f"f90nml reads otherwise: {differing}, added: {sorted(added)}" if differing or added else ""


def parts(text):
    """Groups by name, bodies and unknowns with their numbers, and the sweeps in their order, as f90nml reads them."""
    items = list(f90nml.reads(text).items())
    bodies = [values for name, values in items if name == "body"]
    unknowns = [values for name, values in items if name == "identify"]
    groups = {name: values for name, values in items if name not in {"sweep", "body", "identify"}}
    groups |= {f"body({number})": values for number, values in enumerate(bodies, 1)}
    groups |= {f"identify({number})": values for number, values in enumerate(unknowns, 1)}
    return groups, [values for name, values in items if name == "sweep"]


def alike(said, held):
    """One value or several; trailing blanks and the case of words do not count."""
    if isinstance(said, str) and isinstance(held, str):
        return said.rstrip().lower() == held.rstrip().lower() or held == REPLACED
    listed = [value if isinstance(value, list) else [value] for value in (said, held)]
    return held == REPLACED or listed[0] == listed[1]


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
