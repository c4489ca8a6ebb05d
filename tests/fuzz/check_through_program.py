"""Damaged scenes through the whole program: `beamwave check` takes each with status 0, or refuses it with status 2 and messages
that name a place; it leaves nothing behind. What it takes is read by f90nml, too, and means the same.

check_through_program.py BEAMWAVE FUZZ_SCENE_READER COUNT SCENE …     BEAMWAVE_SEED sets the seed"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import f90nml

SECONDS = 60  # far above any check: what takes longer hangs
LOCATED = re.compile(r"0\d{4}\.nml(:\d+)?: (text|&\w*|\w+%[^:]*): \S")
WRONG_WAYS = {  # what f90nml 1.4 reads otherwise than the language defines, or not at all
    "texts with quotes, comments or groups inside": re.compile(r"""'[^'\n]*["!&$/][^'\n]*'|"[^"\n]*['!&$/][^"\n]*"|''|\"\""""),
}


def main(program, generator, count, *scenes):
    """Return the number of faults."""
    with tempfile.TemporaryDirectory() as directory:
        here = Path(directory)
        made = subprocess.run(
            [generator, count, *scenes, "--write", directory], capture_output=True, text=True, check=False, timeout=SECONDS
        )
        print(made.stdout + made.stderr, end="")
        texts = sorted(here.glob("*.nml"))
        faults = [made.stderr] if made.returncode or len(texts) != int(count) else []
        compared = 0
        for text in texts:
            fault = fault_of_program(program, text) or fault_of_meaning(text)
            compared += fault == ""
            if fault:
                faults.append(f"{text.name}: {fault}\n{text.read_text(errors='replace')}")
        left = sorted(path.name for path in here.iterdir() if path.suffix not in {".nml", ".resolved"})
        if left:
            faults.append(f"left behind: {left}")
    print(f"{len(texts)} texts through the program, of which f90nml read {compared} accepted ones alike")
    print("\n".join(faults))
    return len(faults)


def fault_of_program(program, text):
    """What the program does wrong with a text; empty for nothing."""
    try:
        ended = subprocess.run(
            [program, "check", text.name], cwd=text.parent, capture_output=True, text=True, check=False, timeout=SECONDS
        )
    except subprocess.TimeoutExpired:
        return "hangs"
    accepted = text.with_suffix(".resolved").exists()
    if ended.returncode != (0 if accepted else 2):
        return f"status {ended.returncode}: {ended.stderr}"
    lines = [] if accepted else ended.stderr.splitlines()
    if not accepted and not lines:
        return "refused without a word"
    return "".join(f"no place: {line}" for line in lines if not LOCATED.match(line))


if __name__ == "__main__":
    sys.exit(min(1, main(*sys.argv[1:])))
