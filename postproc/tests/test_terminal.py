"""What the commands print: names control no terminal, and a stream that is closed, full or not read spoils no file."""

import io
import resource
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import hostile
import numpy as np
import pytest
import synthetic

from beamwave_postproc import KINDS, cli
from beamwave_postproc.record import cli as record
from beamwave_postproc.terminal import printable
from beamwave_postproc.tool import Tool

PACKAGE = Path(__file__).parents[1]
STEERING = "\x1b]0;x\x07\r\u202eq\x9b\n"  # title of the terminal, right to left, escape and bracket, another line
SHOWN = r"\x1b]0;x\x07\x0d\xe2\x80\xaeq\xc2\x9b\x0a"


def test_what_controls_a_terminal_is_shown_as_bytes():
    assert printable(STEERING) == SHOWN
    assert printable("ξ = 0.5\t±1 µm – naïve \U0001d11e") == "ξ = 0.5\t±1 µm – naïve \U0001d11e"
    assert printable("\udcff\ud800\u2028\U000e0001") == r"\xff\xed\xa0\x80\xe2\x80\xa8\xf3\xa0\x80\x81"


def test_names_of_files_and_of_what_is_in_them_do_not_steer_a_terminal(tmp_path, capfd):
    directory = tmp_path / f"d{STEERING}"
    directory.mkdir()
    result = synthetic.write(tmp_path / "r.nc", synthetic.scene(impact=None, modes={"after": 2}), title=STEERING[:4])
    result.rename(directory / f"r{STEERING}.nc")
    np.save(directory / "a.npy", np.zeros(300, dtype=[("t", "f8"), (f"a{STEERING}", "f8")]))
    np.save(directory / f"b{STEERING}.npy", hostile.VALUES)
    (directory / "c.nc").write_text("nothing")
    assert record.main([str(directory / "a.npy"), "--sample-rate", "2048"]) == 0
    assert record.main([str(directory / "a.npy"), "--time", STEERING, "--overwrite"]) == 3
    assert record.main([str(directory / f"b{STEERING}.npy"), "--sample-rate", "2048"]) == 0
    assert record.main([str(directory / f"b{STEERING}.npy"), str(directory / "absent.mat")]) == 3
    one = ["--only", "dispersion"]
    for words in ([*one, str(directory)], [*one, "--page", str(directory)], ["--compare", str(directory)], [str(directory / "x")]):
        assert cli.main(words) in (2, 3)
    for words in ([f"--{STEERING}"], [], ["a", f"--output{STEERING}"]):
        with pytest.raises(SystemExit):
            cli.main(words)
    out, err = capfd.readouterr()
    assert f"d{SHOWN}/r{SHOWN}_dispersion.png" in out and f"d{SHOWN}/c.nc: not readable" in err
    assert not set(out + err) & set(STEERING.replace("\n", "").replace("q", "").replace("x", "")) - set("]0;")
    assert sum(len(list(directory.glob(f"*.{end}"))) for end in ("png", "html")) == 2


@pytest.fixture
def history(tmp_path):
    np.save(tmp_path / "a.npy", hostile.VALUES)
    return tmp_path / "a.npy"


@pytest.mark.parametrize(("streams", "status"), [(">&- 2>&- <&-", 0), ("2>&- | exit 0", 0), (">/dev/full", 3)])
def test_a_stream_that_cannot_be_written_spoils_no_file(history, streams, status):
    words = [sys.executable, "-m", "beamwave_postproc.record.cli", str(history), "--sample-rate", "2048"]
    shell = ["sh", "-c", f'exec "$@" {streams}', "sh", *words]
    ended = subprocess.run(shell, cwd=PACKAGE, capture_output=True, text=True, check=False)
    assert ended.returncode == status
    assert ended.stdout + ended.stderr == ("standard output cannot be written\n" if status else "")
    good = history.with_name("good")
    assert record.main([str(history), "--sample-rate", "2048", "--output", str(good)]) == 0
    assert history.with_suffix(".nc").read_bytes() == (good / "a.nc").read_bytes()


def test_an_encoding_that_lacks_letters_stops_nothing(monkeypatch):
    written = io.BytesIO()
    monkeypatch.setattr("sys.stdout", io.TextIOWrapper(written, encoding="ascii"))
    Tool().say("ξ")
    assert written.getvalue() == b"\\u03be\n"


def test_warnings_of_libraries_to_their_callers_are_not_said(capsys):
    def work():
        for kind in (UserWarning, DeprecationWarning, FutureWarning):
            warnings.filterwarnings("always", category=kind)  # as a library may do when it is imported
            warnings.warn(kind.__name__, kind, stacklevel=1)

    assert Tool().attempt("a.nc", work) == 0
    assert capsys.readouterr().err == "a.nc: warning: UserWarning\n"


def test_a_full_disk_leaves_what_was_there_and_nothing_else(history, tmp_path, monkeypatch, capsys):
    full = (resource.RLIMIT_FSIZE, (1000, 1000))
    monkeypatch.setattr("beamwave_postproc.tool._limit_memory", lambda _: resource.setrlimit(*full))
    monkeypatch.setattr("beamwave_postproc.kinds.KINDS", dict(list(KINDS.items())[:1]))
    result = synthetic.write(tmp_path / "r.nc", synthetic.scene(impact=None, modes={"after": 2}))
    (tmp_path / "r_dispersion.png").write_bytes(b"made by beamwave-plot, before")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for command, words in (
        (record, [history, "--sample-rate", "2048"]), (cli, [result]), (cli, [result, "--page"]),
    ):  # fmt: skip
        assert command.main(list(map(str, words))) == 3
        said = capsys.readouterr().err
        assert "File too large" in said and len(said.splitlines()) == 1
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_command_that_is_ended_leaves_nothing_half_written(history):
    """It is ended while the file is there that has not its name yet."""
    script = f"""
import sys, time
from beamwave_postproc.record import cli, write
whole = write._write
write._write = lambda *words: (whole(*words), time.sleep(1000))
sys.exit(cli.main([{str(history)!r}, "--sample-rate", "2048"]))
"""
    running = subprocess.Popen([sys.executable, "-c", script], cwd=PACKAGE, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 60.0
    while not list(history.parent.glob(".beamwave*.nc")) and time.monotonic() < until:
        time.sleep(0.02)
    running.send_signal(signal.SIGTERM)
    _, said = running.communicate(timeout=60.0)
    assert (running.returncode, said) == (5, "stopped\n")
    assert [path.name for path in history.parent.iterdir()] == ["a.npy"]
