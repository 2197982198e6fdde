"""The README and the page of main figures: what they show is what files and pages say."""

import re
from pathlib import Path

import pytest
import yaml
from every import report

from drake_geom_ros.geometry._proximity.kernels.pair_table import PAIR_TABLE

ROOT = Path(__file__).parents[1]
README = (ROOT / 'README.md').read_text()
MEASURED = (ROOT / 'docs/measured.md').read_text()


def blocks(language):
    """Return the README's code blocks in a language."""
    return re.findall(rf'^```{language}\n(.*?)^```$', README, re.S | re.M)


def test_the_robot_is_one_of_the_scene_that_ships():
    (robot,) = blocks('yaml')
    scene = yaml.safe_load((ROOT / 'scenes/two_pandas.yaml').read_text())
    assert yaml.safe_load(robot)['robots'] == scene['robots'][:1]


def test_it_is_short():
    assert len(README.splitlines()) <= 95


def test_the_film_is_small_and_moves():
    (film,) = re.findall(r'!\[.*\]\((.*\.gif)\)', README)
    content = (ROOT / film).read_bytes()
    assert content.startswith(b'GIF89a')
    assert len(content) < 3_000_000
    assert content.count(b'\x21\xf9\x04') > 50  # graphic control extensions, one a picture


def test_the_worst_errors_are_those_of_the_pair_table():
    least, most = (f'{f(row.worst_error for row in PAIR_TABLE):.0e} m' for f in (min, max))
    assert f'between\n  {least} and {most} for bodies of about 0.2 m' in README


def test_every_command_of_run_is_known():
    """Here and in docs/installation.md, which lists all of them."""
    page = (ROOT / 'docs/installation.md').read_text()
    usage = (ROOT / 'run').read_text().partition("<<'EOF'\n")[2].partition('\nEOF')[0]
    known = set(re.findall(r'^\./run ([\w-]+)', usage, re.M))
    assert known == set(re.findall(r'^\| `\./run ([\w-]+)', page, re.M))
    named = set(re.findall(r'\./run ([\w-]+)', README))
    assert named <= known
    assert 'test' in named, 'which .ci/run calls'


def test_figures_are_those_of_the_pages():
    """What is called measured stands on the page that was measured."""
    cases = (ROOT / 'docs/hard_cases.md').read_text()
    ((count, told),) = re.findall(r'^\| (\d+) hard cases.* \| (.*) \|', MEASURED, re.M)
    for library, passed in re.findall(r'(Coal|MuJoCo|python-fcl|pydrake) (\d+)', told):
        assert f'| signed_distance | {library} | {passed} |' in cases
    (ours,) = re.findall(r'^(\d+)', told)
    assert f'| signed_distance | ours | {ours} |' in cases
    assert f'Of {count} hard cases of usual size, this project solves {ours} ' in cases
    hunt = (ROOT / 'docs/accuracy/hunt.md').read_text()
    ((pairs, places, broken),) = re.findall(
        r'^\| \[(\d+) pairs\].* (\d+) placements .* \| (\d+) broken', MEASURED, re.M
    )
    assert f': {pairs} pairs judged' in hunt
    assert f'{places} placements judged' in hunt
    rows = re.findall(r'^\| [A-Zs][^|]+ \| ([\d.e+]+|inf) \|', hunt, re.M)
    assert len(rows) > 25
    assert sum(float(worst) > 1.0 for worst in rows) == int(broken)


@pytest.mark.parametrize('scene', ['two arms', '1000 bodies'])
def test_round_trips_are_those_of_the_performance_page(scene):
    page = (ROOT / 'docs/performance.md').read_text()
    row = rf'^\| {scene}, (\d+) pairs per answer, (\d+) Hz.* \| (.*) \|'
    ((pairs, rate, told),) = re.findall(row, MEASURED, re.M)
    figures = re.findall(
        rf'^\| {scene} \| {rate} \| {pairs} \|' + r' ([\d.]+) \|' * 4 + r' (\S+) ', page, re.M
    )
    assert figures == [(*re.findall(r'[\d.]+', told), 'none')]


def test_links_lead_somewhere():
    links = re.findall(r'\]\(([^)#]+)\)', README)
    assert len(links) > 20
    report(link for link in links if not (ROOT / link).exists())
