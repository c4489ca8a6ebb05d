"""What the wheel of the package holds."""

import os
import zipfile
from pathlib import Path

from hatchling import build

PACKAGE = Path(__file__).parents[1]


def test_the_wheel_has_the_licence_of_the_project(tmp_path, monkeypatch):
    monkeypatch.chdir(PACKAGE)
    with zipfile.ZipFile(tmp_path / build.build_wheel(os.fspath(tmp_path))) as wheel:
        (name,) = [name for name in wheel.namelist() if name.endswith("LICENSE")]
        text = wheel.read(name)
    assert text == (PACKAGE / "LICENSE").read_bytes()
    whole = PACKAGE.parent / "LICENSE"
    assert not whole.is_file() or text == whole.read_bytes()
