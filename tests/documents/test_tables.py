"""Documents look on a page as they were meant: tables are tables, cells are short, links lead somewhere."""

import re

import pytest
from documents import PROJECT, all_documents, headings, text_of, tokens

LONGEST_CELL = 60  # words; what is longer is a paragraph
VERBATIM = {"fence", "code_block", "html_block"}


def lines_in(text, kinds):
    """Numbers of the source lines that stand in tokens of these kinds."""
    return {line for token in tokens(text) if token.type in kinds and token.map for line in range(*token.map)}


def rows(text):
    """(number, cells) of each source line that looks like the row of a table."""
    verbatim = lines_in(text, VERBATIM)
    looks = [(i, line.strip()) for i, line in enumerate(text.splitlines()) if i not in verbatim and line.lstrip().startswith("|")]
    return [(i, re.split(r"(?<!\\)\|", line.removeprefix("|").removesuffix("|"))) for i, line in looks]


@pytest.mark.parametrize("document", all_documents())
def test_each_line_that_looks_like_a_row_is_in_a_table(document):
    text = text_of(document)
    tables = lines_in(text, {"table_open"})
    assert [i + 1 for i, _ in rows(text) if i not in tables] == []


@pytest.mark.parametrize("document", all_documents())
def test_each_row_has_as_many_cells_as_the_head_of_its_table(document):
    """A `|` inside a cell that has no backslash ends the cell, between backquotes as well."""
    text = text_of(document)
    cells = dict(rows(text))
    for table in [token.map for token in tokens(text) if token.type == "table_open"]:
        for line in range(*table):
            assert len(cells.get(line, [])) == len(cells[table[0]]), f"line {line + 1}"


@pytest.mark.parametrize("document", all_documents())
def test_no_cell_is_an_essay(document):
    for line, cells in rows(text_of(document)):
        for cell in cells:
            assert len(cell.split()) <= LONGEST_CELL, f"line {line + 1}: {len(cell.split())} words: {cell}"


@pytest.mark.parametrize("document", all_documents())
def test_each_link_to_a_heading_finds_it(document):
    links = re.findall(r"\]\(([^)#:\s]*)#([^)\s]+)\)", text_of(document))
    for path, anchor in links:
        target = (PROJECT / document).parent / path if path else PROJECT / document
        assert anchor in headings(text_of(target.resolve().relative_to(PROJECT))), f"{path}#{anchor}"


@pytest.mark.parametrize("document", all_documents())
def test_each_link_to_a_file_finds_it(document):
    prose = [token.content for token in tokens(text_of(document)) if token.type == "inline"]
    links = [link for text in prose for link in re.findall(r"\]\(([^)#:\s]+)(?:#[^)\s]*)?\)", text)]
    assert [link for link in links if not (PROJECT / document).parent.joinpath(link).exists()] == []
