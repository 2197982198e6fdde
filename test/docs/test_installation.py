"""docs/installation.md lists what setup.py has, and what can be started."""

import re
import shutil
import subprocess

import pytest
from conventions.setup_file import setup_keywords
from conventions.source_tree import ROOT

from drake_geom_ros import programs as module

PAGE = (ROOT / 'docs/installation.md').read_text()


def test_every_extra_is_listed_once():
    table = PAGE.split('| extra | for |')[1].split('\n\n')[0]
    cells = re.findall(r'^\| (`[^|]+) \|', table, re.MULTILINE)
    listed = [name for cell in cells for name in re.findall(r'`(\w+)`', cell)]
    assert sorted(listed) == sorted(setup_keywords()['extras_require'])


def test_every_program_is_there_and_starts_something_of_ours():
    (line,) = [line for line in PAGE.splitlines() if '`./run exec PROGRAM`' in line]
    listed = set(re.findall(r'`(\w+)`', line.rpartition(':')[2]))
    programs = {path.name: path for path in (ROOT / 'scripts').iterdir()}
    assert set(programs) == listed
    for name, path in programs.items():
        assert path.stat().st_mode & 0o111, f'{name} cannot be started'
        (started,) = re.findall(
            r'^from drake_geom_ros.programs import (\w+)$', path.read_text(), re.M
        )
        assert callable(getattr(module, started)), name


@pytest.mark.processes
@pytest.mark.parametrize('program', ['drake_geom_ros', 'compile'])
def test_a_program_explains_itself(program):
    told = subprocess.run(
        [ROOT / 'scripts' / program, '--help'],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    assert told.stdout.startswith('usage: ')


@pytest.mark.processes
@pytest.mark.parametrize('program', ['scheduler', 'worker'])
def test_the_programs_of_a_cluster_have_what_the_page_gives_them(program):
    if not shutil.which('dask'):
        pytest.skip('the extra `cluster` is not installed')
    (line,) = re.findall(rf'^    dask {program}.*$', PAGE, re.MULTILINE)
    told = subprocess.run(
        ['dask', program, '--help'], capture_output=True, text=True, check=True
    ).stdout
    assert [option for option in re.findall(r'--\w+', line) if option not in told] == []


def test_a_page_says_once_what_takes_the_place_of_ros2():
    assert PAGE.count('### Without the program `ros2`') == 1
    for page in (
        'troubleshooting',
        'services',
        'inputs',
        'outputs',
        'lifecycle',
        'viewing',
        'images',
    ):
        text = (ROOT / f'docs/{page}.md').read_text()
        if re.search(r'^ +ros2 |`ros2 ', text, re.MULTILINE):
            assert 'installation.md#without-the-program-ros2' in text, page
