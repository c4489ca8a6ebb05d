"""The page of a result needs no other file and holds its report, notes and pictures."""

import base64
import re
from html.parser import HTMLParser

import numpy as np
import pytest
import synthetic

from beamwave_postproc import cli, dispersion, open_result, page_of, velocity_jump
from beamwave_postproc.page.html import STYLE
from beamwave_postproc.page.tables import MAX_MODES, number, tables_of

PNG = b"\x89PNG\r\n\x1a\n"


class Reader(HTMLParser):
    """What a page refers to, and its words."""

    def __init__(self):
        super().__init__()
        self.open, self.sources, self.words = [], [], ""

    def handle_starttag(self, tag, attrs):
        """Keep what a tag refers to."""
        self.sources += [value for name, value in attrs if name in ("src", "href", "srcset")]
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        """Each end belongs to the last begin."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """Keep the words."""
        self.words += data.replace("\u00a0", " ")


def read(text):
    reader = Reader()
    reader.feed(text)
    assert not reader.open
    return reader


def test_a_page_holds_notes_report_scene_and_pictures_in_itself(full_result):
    with open_result(full_result) as ds:
        noted = ds.assign_attrs(notes="one < two & three\nanother", title="A <title>")
        page = read(page_of(noted, {"dispersion": dispersion(ds), "velocity_jump": velocity_jump(ds)}))
        first = ds["angular_frequency"].values[0]
    assert len(page.sources) == 2
    for source in page.sources:
        assert source.startswith("data:image/png;base64,")
        assert base64.b64decode(source.split(",")[1]).startswith(PNG)
    for words in (
        "A <title>",
        "one < two & three",
        "another",
        "&rotation",
        "impact γ = 0.2",
        number(first),
        "10 of 40 modes",
    ):
        assert words in page.words
    assert "url(" not in page_of(ds, {}) and "http" not in page_of(ds, {})


def test_tables_hold_the_numbers_of_the_file(full_result):
    with open_result(full_result) as ds:
        tables = {table.title: table for table in tables_of(ds)}
        peaks = ds["measured_wavenumber"].values
    assert set(tables) == {
        "Modes after the capture", "Outcomes", "Events", "Histories", "Measured in the histories"
    }  # fmt: skip
    assert len(tables["Modes after the capture"].rows) == MAX_MODES
    assert [row[0] for row in tables["Events"].rows] == ["impact", "capture"]
    measured = tables["Measured in the histories"]
    column = next(i for i, name in enumerate(measured.columns) if name.startswith("wavenumber"))
    assert [row[column].split(" ± ")[0] for row in measured.rows] == [number(value) for value in peaks]
    assert all(len(row) == len(table.columns) for table in tables.values() for row in table.rows)


def test_of_many_histories_the_largest_of_each_quantity_stay(full_result):
    with open_result(full_result) as ds:
        case = ds.isel(point=[0] * 21).load()
    share = np.linspace(0.0, 1.0, 21)  # the largest at the last point
    along = case["displacement"].dims
    shape = share[:, None] * np.ones(case.sizes["time"])
    case = case.assign(bending_moment=(along, shape[::-1], {"units": "N m"}), displacement=(along, shape, {"units": "m"}))
    case = case.drop_vars(["velocity", "point_position"]).assign_coords(point_position=("point", share))
    (table,) = (table for table in tables_of(case) if table.title == "Histories")
    assert len(table.rows) == 20 and table.note.startswith("20 of 42")
    places = {name: [float(row[1]) for row in table.rows if row[0] == name] for name in ("displacement", "bending moment")}
    assert places["displacement"] == pytest.approx(share[-10:]) and places["bending moment"] == pytest.approx(share[:10])


def test_outcomes_are_the_largest_values_with_their_places_and_no_critical_speed_of_a_beam_at_rest(full_result):
    with open_result(full_result) as ds:
        largest = {"largest_stress": ("point", [3e6, 1e6], {"units": "Pa"}), "largest_stress_time": ("point", [0.25, 0.5])}
        case = ds.assign(**largest, restitution=0.4, largest_contact_force=((), 50.0, {"units": "N"})).load()
    (rows,) = ({row[0]: row[1:] for row in table.rows} for table in tables_of(case) if table.title == "Outcomes")
    assert rows["largest bending stress"] == ["3000000", "Pa", f"{float(case['point_position'][0]):.4g}", "0.25"]
    assert rows["largest contact force"][:2] == ["50", "N"] and rows["restitution of the first contact"][0] == "0.4"
    assert "critical angular velocity" in rows
    still = case.drop_vars("rotation_angular_velocity")
    assert not any(row[0] == "critical angular velocity" for table in tables_of(still) for row in table.rows)


def test_what_does_not_exist_is_a_dash(full_result):
    with open_result(full_result) as ds:
        unstable = ds.assign(angular_frequency=ds["angular_frequency"].where(ds["mode"] > 1))
        assert tables_of(unstable)[0].rows[0][1] == "–"


def test_the_command_writes_a_page_for_each_file_or_for_two_together(tmp_path, capsys):
    settings = synthetic.scene(impact=None, modes={"after": 3})
    files = [str(synthetic.write(tmp_path / f"{name}.nc", settings)) for name in ("a", "b")]
    assert cli.main([*files, "--page"]) == 0
    assert not list(tmp_path.glob("*.png")) and read((tmp_path / "a.html").read_text(encoding="utf-8")).sources
    assert cli.main([*files, "--page", "--compare", "--output", str(tmp_path / "out")]) == 0
    both = read((tmp_path / "out/a_and_b.html").read_text(encoding="utf-8"))
    assert "Effects and inputs are the same." in both.words and len(both.sources) == 1
    assert len(re.findall(r"\.html$", capsys.readouterr().out, re.MULTILINE)) == 3


def test_of_a_sweep_the_report_is_that_of_the_first_case_and_says_so(paper_results):
    with open_result(paper_results / "fig7.nc") as ds:
        page = read(page_of(ds, {}))
    assert "Of case 1 of 4: γ = 0.1." in page.words


def test_titles_of_tables_are_smaller_than_those_of_sections():
    sizes = [float(re.search(rf"{tag} {{ font-size: ([\d.]+)rem", STYLE)[1]) for tag in ("h1", "h2", "h3")]
    assert sizes == sorted(sizes, reverse=True) and len(set(sizes)) == 3


def test_the_words_of_a_wide_table_s_columns_may_break_but_no_number_and_no_unit(full_result):
    with open_result(full_result) as ds:
        text = page_of(ds, {})
    assert "<th>impulse (N\u00a0s)</th>" in text and "<th>time (s)</th>" in text
    assert "\ntd { white-space: nowrap; }" in STYLE and "nowrap" not in STYLE.split("th, td {")[1].split("}")[0]
