"""The commands of bench/ run, and what the documents say of them is what was measured. No time is judged here."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
BENCHES = ("peers", "contact", "growth", "effects", "price", "records", "large_records")
sys.path.insert(0, str(PROJECT / "bench"))


@pytest.fixture(scope="module")
def small_run(program, tmp_path_factory):
    """Runs a bench in a small size, once: what it printed, its data, its directory."""
    known = {}

    def run(name):
        if name not in known:
            output = tmp_path_factory.mktemp(name)
            words = [sys.executable, "-m", name, "--small", "--output", output, "--beamwave", program]
            ended = subprocess.run(words, cwd=PROJECT / "bench", capture_output=True, text=True, check=False)
            assert ended.returncode == 0, ended.stderr
            known[name] = ended.stdout, json.loads((output / f"{name}.json").read_text()), output
        return known[name]

    return run


@pytest.mark.parametrize("name", BENCHES)
def test_a_small_size_runs_to_its_table_and_its_picture(small_run, name):
    _, measured, output = small_run(name)
    bench = importlib.import_module(f"{name}.bench").BENCH
    assert bench.section(measured, f"pictures/{name}.png").strip() in (output / "numbers.md").read_text()
    assert (output / f"pictures/{name}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", BENCHES)
def test_the_document_holds_the_committed_numbers(name):
    bench = importlib.import_module(f"{name}.bench").BENCH
    document = importlib.import_module("common.document")
    command = importlib.import_module("common.command")
    expected = bench.section(command.read(bench.data()), f"pictures/{name}.png").strip()
    again = f"bench/{name}.sh --redraw writes it anew"
    assert document.section(PROJECT / "docs/numbers.md", bench.first) == expected, again


def test_the_document_opens_and_closes_with_what_the_committed_data_say():
    overview = importlib.import_module("overview.sections")
    document = importlib.import_module("common.document")
    measured, text = overview.committed(), overview.DOCUMENT.read_text(encoding="utf-8")
    expected = {overview.FIRST: overview.what_matters(measured, text), overview.LAST: overview.machines(measured)}
    for mark, words in expected.items():
        assert document.section(overview.DOCUMENT, mark) == words.strip(), "PYTHONPATH=bench python -m overview writes it anew"


def test_the_flags_of_the_compiler_stand_once_in_the_document():
    flags = [line for line in (PROJECT / "docs/numbers.md").read_text(encoding="utf-8").splitlines() if "-march" in line]
    assert len(flags) == 1


def test_every_peer_is_measured_or_said_not_to_be(small_run):
    printed, measured, _ = small_run("peers")
    for peer in importlib.import_module("peers.measure").PEERS:
        rows = [row for row in measured["rows"] if row["peer"] == peer.name]
        if peer.missing():
            assert f"{peer.name}: not measured" in printed
        else:
            assert len(rows) == len(peer.small)


def test_beamwave_keeps_its_tolerance_against_the_independent_reference(small_run):
    _, measured, _ = small_run("peers")
    rows = [row for row in measured["rows"] if row["peer"] == "beamwave"]
    assert rows
    for row in rows:
        tolerance = float(row["setting"].removeprefix("tolerance "))  # over the tip's peak
        assert row["error"] <= 3 * tolerance  # over each point's own, the midpoint's is 0.4 of the tip's


def test_a_careful_sum_gains_digits_with_modes(small_run):
    _, measured, _ = small_run("peers")
    worse, better = (row["error"] for row in measured["rows"] if row["peer"] == "numpy, direct sum")
    assert better < worse / 5  # three times the modes; the tail falls with their square


def test_the_section_of_throughput_holds_the_committed_numbers():
    section = importlib.import_module("throughput.section")
    document = importlib.import_module("common.document")
    measured = json.loads((PROJECT / "bench/throughput/measured.json").read_text())
    written = document.section(PROJECT / "docs/numbers.md", section.FIRST)
    assert written == section.section(measured).strip(), "bench/throughput.sh --redraw writes it anew"


def test_a_small_throughput_measures_every_part(program):
    words = [sys.executable, "-m", "throughput", "--small", "--beamwave", program]
    ended = subprocess.run(words, cwd=PROJECT / "bench", capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    for part in ["numpy loop", "very small cases", "Estimates of `beamwave check`"]:
        assert part in ended.stdout


def test_effects_are_counted_or_said_not_to_be(small_run):
    _, measured, output = small_run("effects")
    paper, shear = measured["rows"]
    assert (paper["method"], shear["method"]) == ("closed form", "pieces")
    if paper["instructions"] is None:  # no valgrind, or it does not know the instructions of this build
        assert "| – " in (output / "numbers.md").read_text()
    else:
        assert 0 < paper["instructions"] < shear["instructions"]


def test_a_small_comparison_of_sums_runs_and_both_sides_keep_the_accuracy(program):
    words = [sys.executable, "-m", "sum", "--small", "--beamwave", program]
    ended = subprocess.run(words, cwd=PROJECT / "bench", capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    rows = [line.split("|")[1:-1] for line in ended.stdout.splitlines() if line.startswith("| 200 ")]
    assert len(rows) == 2
    for row, tolerance in zip(rows, (3e-11, 1e-12)):
        assert float(row[-2]) <= tolerance
        if importlib.util.find_spec("finufft"):
            assert float(row[-1]) <= 10 * tolerance  # FINUFFT's bound is one of the mean square
        else:
            assert row[-1].strip() == "–"


def test_the_section_of_sums_holds_the_committed_numbers():
    section = importlib.import_module("sum.section")
    document = importlib.import_module("common.document")
    data = PROJECT / "bench/sum/measured.json"
    written = document.section(PROJECT / "docs/numbers.md", section.FIRST)
    expected = section.section(json.loads(data.read_text())).strip() if data.is_file() else ""
    assert written == expected, "bench/sum.sh --redraw writes it anew"
