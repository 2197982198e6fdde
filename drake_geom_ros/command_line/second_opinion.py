"""Option ``check --cross-check``: compare each pair of a posed scene with python-fcl."""

from __future__ import annotations

import math

from drake_geom_ros.command_line.posed_scene import PosedScene
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
from drake_geom_ros.geometry import GeometryError, GeometryId


def cross_checked(scene: PosedScene) -> tuple[list[str], bool]:
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
