"""`suggest-filters`: pairs of links by what they do in sampled configurations."""

from itertools import combinations

import pytest
from lxml import etree
from oracles.panda import URDF

from drake_geom_ros.command_line.program import main
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene, read_scene


def link(name, shape='<sphere radius="0.1"/>', at='0 0 0'):
    return (
        f'<link name="{name}"><collision><origin xyz="{at}"/><geometry>{shape}</geometry>'
        '</collision></link>'
    )


def joint(name, parent, child, at, kind='revolute'):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="0 0 1"/>'
        '<limit lower="-3" upper="3" velocity="1"/></joint>'
    )


# An arm that turns about z: its tip reaches the post, the cap always is in the base.
ROBOT = (
    '<robot name="arm">'
    + link('base')
    + link('upper', at='0.3 0 0')
    + link('cap')
    + link('post', at='0 0.6 0')
    + link('tip')
    + link('far', at='0 0 9')
    + joint('turn', 'base', 'upper', '0 0 0')
    + joint('cap_joint', 'upper', 'cap', '0 0 0.05', 'continuous')
    + joint('post_joint', 'base', 'post', '0 0 0', 'fixed')
    + joint('tip_joint', 'cap', 'tip', '0.6 0 0', 'continuous')
    + joint('far_joint', 'tip', 'far', '0 0 0', 'continuous')
    + '</robot>'
)


@pytest.fixture
def robot(tmp_path):
    path = tmp_path / 'arm.urdf'
    path.write_text(ROBOT)
    return path


def suggested(text):
    root = etree.fromstring(text.encode())
    return {
        frozenset((e.get('link1'), e.get('link2'))): e.get('reason')
        for e in root.iterfind('disable_collisions')
    }


def test_pairs_are_told_by_what_they_do(robot, capsys):
    assert main(['suggest-filters', str(robot), '--states', '300']) == 0
    done = capsys.readouterr()
    found = suggested(done.out)
    assert found[frozenset(('base', 'cap'))] == 'Always'
    assert found[frozenset(('base', 'far'))] == 'Never'
    assert found[frozenset(('base', 'upper'))] == 'Adjacent'
    assert frozenset(('post', 'tip')) not in found
    assert 'arm: adjacent 5, always 1, never' in done.err
    assert 'less than 1 % of all' in done.err


def test_an_srdf_and_filters_load_and_leave_those_pairs_out(robot, tmp_path):
    for name in ('arm.srdf', 'filters.yaml'):
        command = ['suggest-filters', str(robot), '--states', '50', '--without-never']
        assert main([*command, '--out', str(tmp_path / name)]) == 0
    with_srdf = read_scene(robot, srdf=tmp_path / 'arm.srdf')
    assert with_srdf.warnings == ()
    text = (tmp_path / 'filters.yaml').read_text()
    scene = read_scene(f'robots: [{{name: arm, urdf: {robot}}}]\n{text}')
    assert len(scene.filters) > len(read_scene(robot).filters)
    assert 'never' not in text.partition('\n')[2]


@pytest.mark.parametrize(
    ('kinds', 'flange'),
    [
        (('fixed', 'revolute'), '<link name="flange"/>'),
        (('fixed', 'revolute'), link('flange')),
        (('revolute', 'fixed'), '<link name="flange"/>'),
        (('fixed', 'fixed'), '<link name="flange"/>'),
        (('fixed', 'fixed'), link('flange')),
        (('revolute', 'revolute'), link('flange')),
        (('floating', 'revolute'), link('flange')),
    ],
)
def test_adjacent_links_are_those_that_loading_filters(tmp_path, capsys, kinds, flange):
    """a - flange - b: with a bare flange between a fixed and a moving joint, as in pydrake."""
    path = tmp_path / 'arm.urdf'
    joints = [
        joint('i', 'a', 'flange', '0.1 0 0', kinds[0]),
        joint('j', 'flange', 'b', '0 0 0', kinds[1]),
    ]
    joints.append(joint('k', 'b', 'far', '0 0 9'))  # so that each robot can move
    links = link('a') + flange + link('b') + link('far')
    path.write_text(f'<robot name="arm">{links}{"".join(joints)}</robot>')
    assert main(['suggest-filters', str(path), '--states', '10']) == 0
    found = suggested(capsys.readouterr().out)
    scene_graph = SceneGraph()
    loaded = load_scene(path, scene_graph)
    candidates = scene_graph.model_inspector().GetCollisionCandidates()
    kept = {frozenset(id.get_value() for id in pair) for pair in candidates}
    ids = {frame: id.get_value() for (_, frame, _), id in loaded.geometries.items()}
    filtered = {
        frozenset((a, b))
        for a, b in combinations(ids, 2)
        if frozenset((ids[a], ids[b])) not in kept
    }
    assert {pair for pair, reason in found.items() if reason == 'Adjacent'} == filtered
    # They overlap in each state, so that no pair of links is lost.
    near = [frame for frame in ids if frame != 'far']
    assert kinds[0] == 'floating' or set(map(frozenset, combinations(near, 2))) <= set(found)


def test_a_panda_is_filtered_as_its_srdf_has_it(capsys):
    """That of MoveIt's assistant; what it calls never is what it saw, as for us."""
    panda, share = URDF.with_name('panda.urdf'), URDF.parents[4]
    command = ['suggest-filters', str(panda), '--package-root', str(share)]
    assert main([*command, '--states', '300']) == 0
    found = suggested(capsys.readouterr().out)
    theirs = suggested((panda.parents[1] / 'srdf/panda.srdf').read_text())
    assert theirs.items() <= found.items()
    assert {found[pair] for pair in found.keys() - theirs.keys()} <= {'Never'}


def test_seeds_give_the_same(robot, capsys):
    texts = []
    for seed in (1, 1):
        assert main(['suggest-filters', str(robot), '--states', '50', '--seed', str(seed)]) == 0
        texts.append(capsys.readouterr().out)
    assert texts[0] == texts[1]


@pytest.mark.parametrize(
    ('arguments', 'word'),
    [(['--robot', 'leg'], "--robot 'leg' is none"), (['--out', 'a.txt'], '.srdf')],
)
def test_what_cannot_be_is_refused_in_one_line(robot, capsys, arguments, word):
    assert main(['suggest-filters', str(robot), *arguments]) == 2
    assert word in capsys.readouterr().err
