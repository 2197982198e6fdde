"""Command ``suggest-filters``: suggest filters between links from sampled configurations."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.evaluation import evaluate
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.command_line.option_values import count, count_or_zero
from drake_geom_ros.command_line.scene_input import add_scene_options, read_and_warn
from drake_geom_ros.common.whole_files import check_outputs, whole_file
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import (
    DeclarationDescription,
    FilterDescription,
    LoadedScene,
    SceneDescription,
    SceneFileError,
    files_of,
    register,
)
from drake_geom_ros.scene_files.urdf_filters import adjacent_links

LinkPair = tuple[str, str]
_BLOCK = 1000  # states at once
_TURN = np.pi  # [rad] or [m] range of a joint without limits, in each direction
# With no collision in n states its probability is below 3 / n, at 95 % confidence.
_RULE_OF_THREE = 3.0


class Suggestion(NamedTuple):
    """A pair of links, the reason to filter it, and the number of states in which it collided."""

    links: LinkPair
    reason: str  # as in SRDF: Adjacent, Always, Default or Never
    collided: int


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'suggest-filters',
        description='Samples configurations of a robot within its joint limits, and writes the '
        'pairs of its links that are always, by default (at rest), or never in collision, and '
        'those that are adjacent (a joint connects them, or fixed joints hold them together), '
        'as SRDF or as filters of a scene file. That a pair was '
        'never in collision is what was seen, and no proof.',
    )
    parser.add_argument('scene', metavar='SCENE', help='scene file, model or mesh')
    add_scene_options(parser)
    parser.add_argument('--robot', metavar='NAME', help='which, where the scene has several')
    parser.add_argument(
        '--states', type=count, default=10_000, metavar='N', help='samples (default: 10000)'
    )
    parser.add_argument('--seed', type=count_or_zero, default=0, metavar='N', help='default: 0')
    parser.add_argument(
        '--without-never', action='store_true', help='go on looking at pairs that never collided'
    )
    parser.add_argument(
        '--out',
        '--output',
        dest='out',
        metavar='FILE',
        help='.srdf, or .yaml for filters; default: SRDF on the screen',
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Sample, write, and return the exit code; raises GeometryError or OSError for bad input."""
    output = Path(options.out) if options.out else None
    if output is not None and output.suffix not in ('.srdf', '.yaml', '.yml'):
        raise SceneFileError('--out ends with .srdf, .yaml or .yml', str(output))
    check_outputs({'--out': output}, [options.scene, options.srdf])
    description = read_and_warn(options.scene, options.srdf, options.package_root, options.solid)
    robot = _chosen(description, options.robot, options.scene)
    scene_graph = SceneGraph()
    loaded = register(scene_graph, _alone(description, robot))
    check_outputs({'--out': output}, files_of(scene_graph, description.robots))
    links = {frame for _, frame, _ in loaded.geometries}
    joined = _adjacent(loaded.robots[robot].tree.joints, links)  # type: ignore[union-attr]
    counts, at_rest = sampled(scene_graph, loaded, options.states, options.seed)
    suggestions = list(_suggested(scene_graph, loaded, joined, counts, at_rest, options.states))
    if options.without_never:
        suggestions = [each for each in suggestions if each.reason != 'Never']
    as_yaml = output is not None and output.suffix != '.srdf'
    reasons = Counter(each.reason for each in suggestions)
    summary = ', '.join(f'{name.lower()} {reasons[name]}' for name in sorted(reasons)) or 'none'
    chance = _RULE_OF_THREE / options.states
    note = (
        f'{options.states} configurations, seed {options.seed}. A pair that never collided in '
        f'them does so in less than {100 * chance:.2g} % of all, at 95 % confidence'
    )
    text = '\n'.join([*(_yaml if as_yaml else _srdf)(robot, suggestions, note), ''])
    if output is None:
        print(text, end='')
    else:
        with whole_file(output) as file:
            file.write(text)
    print(f'{robot}: {summary}; {note}', file=sys.stderr)
    return 0


def _adjacent(joints: Sequence[Any], links: set[str]) -> set[LinkPair]:
    """Return the pairs of links with shapes that are adjacent, as loading filters them."""
    sets = (each.links for each in adjacent_links(joints, links))
    return {_ordered(a, b) for each in sets for a, b in combinations(each, 2)}


def sampled(
    scene_graph: SceneGraph, loaded: LoadedScene, count: int, seed: int
) -> tuple[Counter[LinkPair], set[LinkPair]]:
    """Return the numbers of colliding states by pair of links, and the pairs that do at rest."""
    joints = Joints.of(loaded)
    lower = np.where(np.isfinite(joints.lower), joints.lower, -_TURN)
    upper = np.where(np.isfinite(joints.upper), joints.upper, _TURN)
    rng = np.random.default_rng(seed)
    rest = np.clip(0.0, joints.lower, joints.upper)[None]
    (at_rest,) = _colliding(scene_graph, loaded, joints, rest)
    counts: Counter[LinkPair] = Counter()
    for first in range(0, count, _BLOCK):
        rows = rng.uniform(lower, upper, (min(_BLOCK, count - first), joints.count))
        for pairs in _colliding(scene_graph, loaded, joints, rows):
            counts.update(pairs)
    return counts, at_rest


def _colliding(
    scene_graph: SceneGraph, loaded: LoadedScene, joints: Joints, states: NDArray[np.float64]
) -> Iterator[set[LinkPair]]:
    """Yield the pairs of links that collide in each state."""
    link_of = {id.get_value(): frame for (_, frame, _), id in loaded.geometries.items()}
    pairs: Any = evaluate(
        scene_graph, want='within', max_distance=0.0, states=states, joints=joints
    )
    for first, last in zip(pairs.offsets, pairs.offsets[1:], strict=False):
        deep = np.flatnonzero(pairs.distance[first:last] < 0.0) + first
        yield {_ordered(link_of[int(pairs.id_A[k])], link_of[int(pairs.id_B[k])]) for k in deep}


def _suggested(
    scene_graph: SceneGraph,
    loaded: LoadedScene,
    joined: set[LinkPair],
    counts: Counter[LinkPair],
    at_rest: set[LinkPair],
    states: int,
) -> Iterator[Suggestion]:
    """Yield the suggestions, in the order of the links."""
    manager = scene_graph.collision_filter_manager()
    by_link: dict[str, list[Any]] = {}
    for (_, frame, _), id in loaded.geometries.items():
        by_link.setdefault(frame, []).append(id)
    for a, b in combinations(by_link, 2):
        pair, count = _ordered(a, b), counts[_ordered(a, b)]
        reported = [not manager.explain(g, h) for g in by_link[a] for h in by_link[b]]
        if pair in joined:
            yield Suggestion((a, b), 'Adjacent', count)
        elif not any(reported):
            continue  # filtered already
        elif count == states:
            yield Suggestion((a, b), 'Always', count)
        elif pair in at_rest:
            yield Suggestion((a, b), 'Default', count)
        elif count == 0:
            yield Suggestion((a, b), 'Never', count)


def _srdf(robot: str, suggestions: list[Suggestion], note: str) -> Iterator[str]:
    yield '<?xml version="1.0"?>'
    yield f'<!-- {note} -->'
    yield f'<robot name={quoteattr(robot)}>'
    for (a, b), reason, collided in suggestions:
        links = f'link1={quoteattr(a)} link2={quoteattr(b)}'
        yield f'  <disable_collisions {links} reason="{reason}"/> <!-- {collided} -->'
    yield '</robot>'


def _yaml(robot: str, suggestions: list[Suggestion], note: str) -> Iterator[str]:
    yield f'# {note}'
    yield 'filters:' if suggestions else 'filters: []'
    for links, reason, collided in suggestions:
        a, b = (f'{{source: {_quoted(robot)}, frame: {_quoted(link)}}}' for link in links)
        yield f'- exclude_between: [[{a}], [{b}]]  # {reason.lower()}, in {collided} states'


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"


def _chosen(description: SceneDescription, name: str | None, file: str) -> str:
    """Return the name of the robot; raises SceneFileError for none, or for several."""
    names = [robot.name for robot in description.robots]
    if name is None and len(names) == 1:
        return names[0]
    if not names:
        raise SceneFileError('there is no robot, between whose links there could be filters', file)
    if name not in names:
        remedy = 'name one by --robot' if name is None else f'--robot {name!r} is none of them'
        raise SceneFileError(f'robots are {", ".join(names)}; {remedy}', file)
    return str(name)


def _alone(description: SceneDescription, robot: str) -> SceneDescription:
    """Return a scene of one robot, with the filters among its own links."""

    def own(entry: FilterDescription) -> bool:
        sets = (
            [entry.members]
            if not isinstance(entry, DeclarationDescription)
            else [members for each in entry.statements for members in (each.set_a, each.set_b)]
        )
        return all(member.source == robot for members in sets for member in members)

    return replace(
        description,
        sources=(robot,),
        robots=tuple(each for each in description.robots if each.name == robot),
        frames=tuple(frame for frame in description.frames if frame.source == robot),
        geometries=tuple(g for g in description.geometries if g.source == robot),
        filters=tuple(filter(own, description.filters)),
        cameras=(),
        awaited=(),
    )


def _ordered(a: str, b: str) -> LinkPair:
    return (a, b) if a <= b else (b, a)
