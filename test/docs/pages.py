"""Code blocks of the documentation, each page read as CommonMark."""

import re
from dataclasses import dataclass

import yaml
from conventions.source_tree import ROOT
from markdown_it import MarkdownIt

EXCEPTIONS = ROOT / 'test/docs/exceptions.yaml'
PARSER = MarkdownIt('commonmark')


@dataclass(frozen=True)
class Block:
    """One code block: its language (empty for an indented one), its text, its line in the page.

    A block with a title is a file that the reader saves under this name.
    """

    language: str
    text: str
    line: int
    title: str = ''

    @property
    def first_line(self):
        return self.text.partition('\n')[0].strip()

    @property
    def kind(self):
        """Return how it is run: file, doctest, python, console or yaml; else the language."""
        if self.title:
            return 'file'
        if self.first_line.startswith('>>> '):
            return 'doctest'
        if self.first_line.startswith('$ '):
            return 'console'
        return self.language or 'plain'


def pages():
    """Return the names of all pages that have a code block, from the root of the tree."""
    paths = [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]
    return [path.relative_to(ROOT).as_posix() for path in paths if blocks(path)]


def blocks(path):
    """Return the code blocks of a page, fenced and indented, in order."""
    tokens = PARSER.parse((ROOT / path).read_text())
    return [
        Block(token.info.partition(' ')[0], token.content, token.map[0] + 1, _title(token.info))
        for token in tokens
        if token.type in ('fence', 'code_block') and token.content.strip()
    ]


def _title(info):
    title = re.search(r'title="([^"]+)"', info)
    return title[1] if title else ''


def exceptions(page):
    """Return {first line of a block: why no test here runs it} of a page."""
    return yaml.safe_load(EXCEPTIONS.read_text()).get(page, {})
