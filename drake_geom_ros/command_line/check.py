"""Command ``check``: load a scene file, list its contents, and compare with python-fcl."""

from __future__ import annotations

import argparse
import math
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from typing import Any

from drake_geom_ros.command_line.configurations import add_joints_to, pose_joints
from drake_geom_ros.command_line.contact_report import contact_lines, half_space_lines
from drake_geom_ros.command_line.exit_codes import DONE, NO
from drake_geom_ros.command_line.mesh_report import file_name, is_solid, mesh_lines
from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.command_line.scene_input import add_scene_options, check_readable
from drake_geom_ros.cross_check.asker import missing
from drake_geom_ros.cross_check.question import (
    DISAGREED,
    LOST,
    VERDICTS,
    QuestionBatch,
    counted,
    questions_of,
    shapes_of,
)
from drake_geom_ros.geometry import (
    Convex,
    GeometryError,
    GeometryId,
    HeightField,
    Mesh,
    Role,
    Shape,
)
from drake_geom_ros.scene_files import Member, SceneFileError, poses_in_parents
from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    DeactivationDescription,
    FilterDescription,
    GroupDescription,
)

# Reasons that hold in every scene: such pairs are counted, not listed.
_ALWAYS = {'anchored', 'same frame'}
_ROLE_NAMES = {
    Role.kProximity: 'proximity',
    Role.kIllustration: 'illustration',
    Role.kPerception: 'perception',
}


def add_to(commands: Any) -> None:
    """Add the command to an argument parser's commands."""
    parser = commands.add_parser(
        'check',
        description='Loads a scene and lists its frames, geometries, filters and the pairs that '
        'are filtered. Exit code 1 and file, line and reason on standard error where it is bad.',
    )
    parser.add_argument('scene', metavar='SCENE', help='scene file, model or mesh')
    add_scene_options(parser)
    add_joints_to(parser)
    parser.add_argument(
        '--all-pairs', action='store_true', help='list anchored and same-frame pairs too'
    )
    parser.add_argument(
        '--cross-check',
        action='store_true',
        help='ask python-fcl about each pair too; exit code 1 where it disagrees',
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check, list, and return the exit code."""
    check_readable(options.scene, options.srdf)
    try:
        scene = OpenedScene(options.scene, options.srdf, options.package_root, options.solid)
    except SceneFileError as error:
        print(f'drake_geom_ros: {error}', file=sys.stderr)
        return NO
    pose_joints(scene, options.joints)
    for line in _report(scene, options.scene, options.all_pairs):
        print(line)
    if not options.cross_check:
        return DONE
    lines, agreed = cross_checked(scene)
    print(*lines, sep='\n')
    return DONE if agreed else NO


def _report(scene: OpenedScene, file: str, all_pairs: bool) -> Iterator[str]:
    description, inspector = scene.description, scene.inspector
    yield (
        f'{file}: sources {len(description.sources)}, frames {len(description.frames)}, '
        f'geometries {inspector.num_geometries()}, filters {len(description.filters)}'
    )
    yield 'frames'
    X_PFs = poses_in_parents(scene.query)
    for frame in inspector.GetAllFrameIds():
        if frame != inspector.world_frame_id():
            place = 'waits for a pose'
            if frame in X_PFs:
                place = f'at {" ".join(f"{x:.6g}" for x in X_PFs[frame].translation())}'
            parent = scene.frame_name(inspector.GetParentFrame(frame))
            yield f'  {scene.frame_name(frame)} in {parent} {place}'
    yield 'geometries'
    for geometry in inspector.GetAllGeometryIds():
        roles = [name for role, name in _ROLE_NAMES.items() if _has_role(scene, geometry, role)]
        shape = inspector.GetShape(geometry)
        shown = _mesh(shape, is_solid(scene, geometry)) or repr(shape)
        yield f'  {scene.names[geometry]}: {shown}, {", ".join(roles) or "no role"}'
    yield from mesh_lines(scene)
    yield from contact_lines(scene)
    yield from half_space_lines(scene)
    yield 'filters'
    yield from (f'  {_filter(entry)}' for entry in description.filters)
    yield 'filtered pairs'
    yield from _pairs(scene, all_pairs)


def _mesh(shape: Shape, solid: bool) -> str:
    """Return a text on how queries treat a mesh; empty for other shapes."""
    if not isinstance(shape, (Convex, Mesh)) or isinstance(shape, HeightField):
        return ''
    name = file_name(shape)
    if solid and isinstance(shape, Mesh):
        return f'mesh {name} (as a solid, {len(shape.surface()[1])} triangles)'
    count = len(shape.hull_surface()[0])
    if isinstance(shape, Convex):
        return f'convex {name} ({count} vertices)'
    return f'mesh {name} (as its hull, {count} vertices)'


def _has_role(scene: OpenedScene, geometry: GeometryId, role: Role) -> bool:
    return scene.inspector.GetProperties(geometry, role) is not None


def _pairs(scene: OpenedScene, all_pairs: bool) -> Iterator[str]:
    """Yield a line for each filtered pair with the reasons, and one with counts."""
    manager = scene.scene_graph.collision_filter_manager()
    geometries = scene.inspector.GetAllGeometryIds(Role.kProximity)
    counts: Counter[str] = Counter()
    for a, b in combinations(geometries, 2):
        reasons = manager.explain(a, b)
        always = [reason for reason in reasons if reason in _ALWAYS]
        if not reasons:
            counts['reported'] += 1
        elif always and not all_pairs:
            counts[always[0]] += 1
        else:
            counts['listed'] += 1
            yield f'  {scene.names[a]} and {scene.names[b]}: {", ".join(reasons)}'
    yield (
        f'pairs {counts.total()}: reported {counts["reported"]}, anchored {counts["anchored"]}, '
        f'on one frame {counts["same frame"]}, filtered and listed above {counts["listed"]}'
    )


def _filter(entry: FilterDescription) -> str:
    """Return one line about a filter."""
    if isinstance(entry, GroupDescription):
        ignores = ', '.join(entry.ignores) or 'nothing'
        return f'group {entry.name} ({_members(entry.members)}) ignores {ignores}'
    if isinstance(entry, CliqueDescription):
        return f'clique {entry.name}: {_members(entry.members)}'
    if isinstance(entry, DeactivationDescription):
        return f'deactivated: {_members(entry.members)}'
    return '; then '.join(
        f'{statement.operation.value} '
        + ' and '.join(
            f'({_members(members)})' for members in (statement.set_a, statement.set_b) if members
        )
        for statement in entry.statements
    )


def _members(members: tuple[Member, ...]) -> str:
    return ', '.join(
        '/'.join(filter(None, (f'{member.source}::{member.frame}', member.geometry)))
        for member in members
    )


def cross_checked(scene: OpenedScene) -> tuple[list[str], bool]:
    """Return the lines of the report, and whether there was no disagreement.

    Raises GeometryError if python-fcl, or a package that judges it, is not installed.
    """
    if names := missing():
        raise GeometryError(
            f'--cross-check needs {" and ".join(names)}: pip install {" ".join(names)}, or this '
            "package with its extra 'cross_check'"
        )
    # Imported late, because other commands do not need the optional packages.
    from drake_geom_ros.cross_check.second_opinion import SecondOpinion

    query = scene.query
    results = query.ComputeSignedDistancePairwiseClosestPoints(math.inf)
    questions = questions_of(query, results, range(len(results)))
    ids = {value for question in questions for value in question.ids}
    opinion = SecondOpinion()
    try:
        verdicts = opinion.judge(QuestionBatch(0, questions, shapes_of(query, ids)))
    finally:
        opinion.close()
    counts = counted(verdicts)
    summary = ', '.join(f'{verdict} {counts[verdict]}' for verdict in VERDICTS)
    lines = [f'cross-checked by {opinion.library}: pairs {len(questions)}: {summary}']
    for question, verdict in zip(questions, verdicts, strict=True):
        if verdict.verdict in (DISAGREED, LOST):
            a, b = (scene.names[GeometryId(value)] for value in question.ids)
            lines.append(f'  {verdict.verdict}: {a} and {b}: {verdict.text}')
    return lines, not counts[DISAGREED]
