"""The documentation builds as a site: without warnings, with every page, with every link."""

import os
import re
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

pytest.importorskip(
    'material', reason='mkdocs-material is not installed: pip install mkdocs-material'
)


@pytest.fixture(scope='module')
def built(tmp_path_factory):
    """Return the folder of the site, and what was printed while it was built."""
    folder = tmp_path_factory.mktemp('site')
    done = subprocess.run(
        [sys.executable, '-m', 'mkdocs', 'build', '--strict', '--site-dir', str(folder)],
        cwd=ROOT,
        env={**os.environ, 'NO_MKDOCS_2_WARNING': '1'},  # the theme's advertisement
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=800,
    )
    assert done.returncode == 0, done.stdout
    return folder, done.stdout


@pytest.mark.everything
@pytest.mark.processes
def test_it_builds_without_warnings(built):
    assert 'WARNING' not in built[1]
    assert 'ERROR' not in built[1]


@pytest.mark.everything
@pytest.mark.processes
def test_every_page_is_there(built):
    pages = [path.relative_to(ROOT / 'docs') for path in (ROOT / 'docs').rglob('*.md')]
    assert len(pages) > 20
    for page in pages:
        name = 'index.html' if page.name in ('README.md', 'index.md') else f'{page.stem}.html'
        assert (built[0] / page.parent / name).exists(), page


@pytest.mark.everything
@pytest.mark.processes
def test_what_pages_link_to_outside_is_copied(built):
    assert (built[0] / 'source/scenes/two_pandas.yaml.txt').read_text() == (
        ROOT / 'scenes/two_pandas.yaml'
    ).read_text()


@pytest.mark.everything
@pytest.mark.processes
def test_lists_and_tables_are_told_from_paragraphs(built):
    """A list or a table without an empty line before it is a paragraph to Python-Markdown."""
    for page in built[0].rglob('*.html'):
        paragraphs = re.findall(r'<p>(.*?)</p>', page.read_text(), re.S)
        wrong = [text for text in paragraphs if re.search(r'^(- |\|)', text, re.M)]
        assert wrong == [], page


@pytest.mark.everything
@pytest.mark.processes
def test_code_is_highlighted_and_nothing_comes_from_a_network(built):
    page = (built[0] / 'tutorials/planner_in_python.html').read_text()
    assert '<span class="kn">import</span>' in page
    loaded = re.findall(r'<(?:script|img|iframe)[^>]+src="(https?:[^"]*)"', page)
    loaded += re.findall(
        r'<link[^>]+rel="(?:stylesheet|preconnect)"[^>]+href="(https?:[^"]*)"', page
    )
    assert loaded == []


@pytest.mark.everything
@pytest.mark.processes
def test_the_title_of_a_file_is_shown(built):
    page = (built[0] / 'tutorials/first_scene.html').read_text()
    assert '<span class="filename">first_scene.yaml</span>' in page


def test_the_index_lists_every_page():
    index = (ROOT / 'docs/index.md').read_text()
    pages = {path.relative_to(ROOT / 'docs').as_posix() for path in (ROOT / 'docs').rglob('*.md')}
    pages = {page for page in pages if not page.startswith('api/')}  # python_api.md lists these
    assert {*re.findall(r'\]\(([^)#]+\.md)\)', index)} == pages - {'index.md'}


def test_the_navigation_has_the_order_of_the_index():
    index = (ROOT / 'docs/index.md').read_text().partition('## Tutorials')[2]
    site = (ROOT / 'mkdocs.yml').read_text().partition('nav:')[2]
    listed = re.findall(r'\]\(([^)#]+\.md)\)', index)
    navigation = re.findall(r': (\S+\.md)$', site, re.M)
    assert list(dict.fromkeys(listed)) == [
        page for page in navigation if page != 'index.md' and not page.startswith('api/')
    ]
