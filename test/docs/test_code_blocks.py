"""Every code block of the README and of each page of the documentation runs, in page order.

A block that cannot run here is listed in exceptions.yaml with the reason. Where the reason names a
test that runs the block, that test has to be there.
"""

import contextlib
import re
import traceback

import pytest
import yaml
from conventions.source_tree import ROOT
from docs.pages import EXCEPTIONS, blocks, exceptions, pages
from docs.running import KINDS, PageRunner, public_names

pytestmark = pytest.mark.processes

PAGES = pages()
TABLE = yaml.safe_load(EXCEPTIONS.read_text())
# Scenes that fragments of scene files continue.
SCENES_BEFORE = {
    'docs/images.md': 'frames: [{name: panda_hand, source: left}]\n',
    'docs/proximity_rules.md': 'frames: [{name: hand, source: arm}]\n',
}


@pytest.mark.parametrize('page', PAGES)
def test_every_block_of_a_page_runs_and_prints_what_it_shows(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('PYTHONPATH', str(ROOT), prepend=':')
    runner = PageRunner(tmp_path, SCENES_BEFORE.get(page, ''))
    listed, failures, missing = exceptions(page), [], set()
    for block in blocks(page):
        if block.first_line in listed or '*' in listed:
            continue
        if page.startswith('docs/api/'):  # the examples of docstrings stand alone
            runner.names = public_names()
        try:
            assert block.kind in KINDS, 'neither run nor listed in test/docs/exceptions.yaml'
            runner.run(block)
        except ModuleNotFoundError as error:
            missing.add(error.name)
        except Exception:
            failures.append(f'{page}:{block.line}: {traceback.format_exc(limit=-2)}')
    assert not failures, '\n'.join(failures)
    if missing:
        pytest.skip(f'blocks of the page need {", ".join(sorted(missing))}')


def test_every_file_of_a_page_is_used_by_a_later_command():
    unused = []
    for page in PAGES:
        lines = (ROOT / page).read_text().splitlines()
        for block in blocks(page):
            later = '\n'.join(lines[block.line + block.text.count('\n') :])
            if block.title and not re.search(rf'(?<!["\w]){re.escape(block.title)}', later):
                unused.append(f'{page}:{block.line}: {block.title}')
    assert unused == []


def test_every_exception_is_a_block_of_its_page_and_gives_a_reason():
    there = {(page, block.first_line) for page in PAGES for block in blocks(page)}
    there |= {(page, '*') for page in PAGES}
    listed = {(page, line): why for page, lines in TABLE.items() for line, why in lines.items()}
    assert sorted(set(listed) - there) == []
    assert [place for place, why in listed.items() if len(why or '') < 15] == []


def test_a_test_that_an_exception_names_is_there():
    reasons = ' '.join(why for lines in TABLE.values() for why in lines.values())
    named = set(re.findall(r'test/[\w/]+\.py', reasons))
    assert len(named) > 5
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []


def test_pages_are_found_by_themselves(tmp_path, monkeypatch):
    page = tmp_path / 'docs/new.md'
    page.parent.mkdir()
    (tmp_path / 'README.md').write_text('No code.\n')
    page.write_text('- item\n\n  ```python\n  1 / 0\n  ```\n\n      $ false\n')
    monkeypatch.setattr('docs.pages.ROOT', tmp_path)
    assert pages() == ['docs/new.md']
    first, second = blocks('docs/new.md')
    assert (first.kind, first.first_line, second.kind) == ('python', '1 / 0', 'console')


def failing(tmp_path, kind_and_text):
    from docs.pages import Block

    with contextlib.suppress(Exception):
        PageRunner(tmp_path).run(Block(*kind_and_text, line=1))
        return False
    return True


@pytest.mark.parametrize(
    'wrong',
    [
        ('python', '1 / 0\n'),
        ('python', 'print(1)\n# 2\n'),
        ('python', '>>> 1 + 1\n3\n'),
        ('console', '$ echo a\nb\n'),
        ('console', '$ python -m drake_geom_ros check none.yaml\n'),
        ('yaml', 'geometries: [{name: ball, shape: {type: sphere, radius: -1}}]\n'),
        ('yaml', '/**/scene_graph: {ros__parameters: {nonsense: 1}}\n'),
    ],
    ids=lambda wrong: wrong[1].strip(),
)
def test_a_block_that_is_wrong_fails(tmp_path, wrong):
    assert failing(tmp_path, wrong)
