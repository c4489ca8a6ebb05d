"""The version of the package as it is built: the project's, from the CMakeLists.txt above; in a source distribution, which has none, the
one that was written into it; unknown of a copy of this directory alone."""

import re
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCES = {HERE.parent / "CMakeLists.txt": r"project\(beamwave VERSION ([0-9.]+)", HERE / "PKG-INFO": r"(?m)^Version: (\S+)"}
found = [re.search(pattern, path.read_text(encoding="utf-8")) for path, pattern in SOURCES.items() if path.is_file()]
__version__ = next((one[1] for one in found if one), "0+unknown")
