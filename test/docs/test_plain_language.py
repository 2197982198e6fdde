"""Pages that people write are easy to read: short sentences and short paragraphs."""

import re

import pytest
from conventions.source_tree import ROOT
from docs.pages import PARSER

LONGEST_MEAN = 18.0  # [words] of the sentences of a page
LONGEST_PARAGRAPH = 90  # [words]
PAGES = [
    path
    for path in [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]
    if path.parent.name != 'api' and 'Generated' not in path.read_text()[:600]
]
END = re.compile(r'(?<=[.!?:])\s+(?=[A-Z`*"(])|(?<=[a-z`)%]\.)\s+(?=[0-9])')


def paragraphs(text):
    """Return the paragraphs and list items of a page, without tables; code is one word."""
    inlines = [token for token in PARSER.parse(text) if token.type == 'inline']
    shown = [
        ''.join(
            {'code_inline': '`code`', 'softbreak': ' '}.get(c.type, c.content) for c in children
        )
        for children in (token.children for token in inlines if not token.content.startswith('|'))
    ]
    return [each for each in shown if each.strip()]


def sentences(paragraph):
    """Return the numbers of words of its sentences; headings and labels are none."""
    counts = [len(each.split()) for each in END.split(paragraph)]
    return [count for count in counts if count > 2]


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_sentences_and_paragraphs_are_short(page):
    found = paragraphs(page.read_text(encoding='utf-8'))
    long = [each[:80] for each in found if len(each.split()) > LONGEST_PARAGRAPH]
    assert long == [], f'paragraphs of more than {LONGEST_PARAGRAPH} words'
    counts = [count for each in found for count in sentences(each)]
    assert sum(counts) <= LONGEST_MEAN * len(counts)


def test_a_long_paragraph_and_long_sentences_are_seen():
    text = f'# Title\n\n{"word " * 91}\n\n- a `b c` item. It ends.\n\n| a | table |\n|---|---|\n'
    title, paragraph, item = paragraphs(text)
    assert len(paragraph.split()) == 91
    assert item == 'a `code` item. It ends.'
    assert sentences(item) == [3]
    assert sentences('One two three. 4 five six seven.') == [3, 4]
    assert title == 'Title'
