"""The Markdown documents of the project, as a Markdown library reads them."""

import re
from pathlib import Path

from markdown_it import MarkdownIt

PROJECT = Path(__file__).parents[2]
NOT_WRITTEN_HERE = {"build", "output"}  # nor what is hidden: .git, .venv


def all_documents():
    """Paths of all of them, relative to the project."""
    top = [path for path in PROJECT.iterdir() if path.name not in NOT_WRITTEN_HERE and not path.name.startswith(".")]
    found = [path for path in top if path.suffix == ".md"]
    found += [path for folder in top if folder.is_dir() for path in folder.rglob("*.md")]
    return sorted(str(path.relative_to(PROJECT)) for path in found)


def text_of(document):
    """The source of a document."""
    return (PROJECT / document).read_text(encoding="utf-8")


def tokens(text):
    """The document as markdown-it reads it, with the tables that GitHub knows."""
    return MarkdownIt("commonmark").enable("table").parse(text)


def blocks(text, language, after=None):
    """The fenced blocks of that language, in order; with `after`, those below the heading of that name."""
    parsed = tokens(text)
    first = 0
    if after:
        first = next(i for i, token in enumerate(parsed) if token.type == "inline" and token.content == after)
    return [token.content for token in parsed[first:] if token.type == "fence" and token.info == language]


def headings(text):
    """The anchors that GitHub gives to the headings."""
    parsed = tokens(text)
    titles = [parsed[i + 1].content for i, token in enumerate(parsed) if token.type == "heading_open"]
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
