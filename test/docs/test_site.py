"""The documentation builds as a site: without warnings, with every page, with every link."""

import re
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

pytest.importorskip('mkdocs', reason="mkdocs is not installed: pip install -e '.[test]'")


@pytest.fixture(scope='module')
def built(tmp_path_factory):
    """Return the folder of the site, and what was printed while it was built."""
    folder = tmp_path_factory.mktemp('site')
    done = subprocess.run(
        [sys.executable, '-m', 'mkdocs', 'build', '--strict', '--site-dir', str(folder)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=800,
    )
    assert done.returncode == 0, done.stdout
    return folder, done.stdout


@pytest.mark.processes
def test_it_builds_without_warnings(built):
    assert 'WARNING' not in built[1]
    assert 'ERROR' not in built[1]


@pytest.mark.processes
def test_every_page_is_there(built):
    pages = [path.relative_to(ROOT / 'docs') for path in (ROOT / 'docs').rglob('*.md')]
    assert len(pages) > 20
    for page in pages:
        name = 'index.html' if page.name in ('README.md', 'index.md') else f'{page.stem}.html'
        assert (built[0] / page.parent / name).exists(), page


@pytest.mark.processes
def test_what_pages_link_to_outside_is_copied(built):
    assert (built[0] / 'source/scenes/two_pandas.yaml.txt').read_text() == (
        ROOT / 'scenes/two_pandas.yaml'
    ).read_text()


@pytest.mark.processes
def test_lists_and_tables_are_told_from_paragraphs(built):
    """A list or a table without an empty line before it is a paragraph to Python-Markdown."""
    for page in built[0].rglob('*.html'):
        paragraphs = re.findall(r'<p>(.*?)</p>', page.read_text(), re.S)
        wrong = [text for text in paragraphs if re.search(r'^(- |\|)', text, re.M)]
        assert wrong == [], page


def test_the_index_lists_every_page():
    index = (ROOT / 'docs/index.md').read_text()
    pages = {path.relative_to(ROOT / 'docs').as_posix() for path in (ROOT / 'docs').rglob('*.md')}
    assert {*re.findall(r'\]\(([^)#]+\.md)\)', index)} == pages - {'index.md'}
