"""Whether an answer is right, for us and for peers by the same measure.

An answer may be off by what the law allows to others. Where the distance is that near to 0 a
contact may be reported or not. Normal and witness points, where a peer gives any, are held to the
same.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.cross_check.judging import allowed_to_others
from drake_geom_ros.cross_check.lost_process import ANSWER, EXCEPTION, QuestionOutcome
from drake_geom_ros.cross_check.surfaces import off_surfaces
from drake_geom_ros.math.array_types import Floats
from truth.hard_cases.cases import Case
from truth.judging import laws
from truth.peers import PENETRATION, PairAnswer, Unsupported
from truth.tolerances import JUDGED_TURN, JUDGED_UNIT

VERDICTS = ('pass', 'wrong', 'NaN', 'exception', 'crash', 'hang', 'unsupported')


class CaseVerdict(NamedTuple):
    """One of VERDICTS, what was wrong, and by how much of what is allowed."""

    verdict: str
    text: str = ''
    excess: float = 0.0


def judged(case: Case, query: str, outcome: QuestionOutcome) -> CaseVerdict:
    """Return the verdict on how a question about a case ended."""
    if outcome.end == EXCEPTION:
        kind = 'unsupported' if isinstance(outcome.value, Unsupported) else 'exception'
        return CaseVerdict(kind, str(outcome.value).strip().split('\n')[0][:80])
    if outcome.end != ANSWER:
        return CaseVerdict(outcome.end, str(outcome.value))
    off = allowed_to_others(case) + case.tolerance
    if outcome.value is None:
        depth = max(-case.distance, 0.0)
        if depth <= off:
            return CaseVerdict('pass')
        return CaseVerdict('wrong', f'no contact for {-depth:.6g}', depth / off)
    if query == PENETRATION and case.distance > off:
        return CaseVerdict('wrong', f'contact for {case.distance:.6g}', case.distance / off)
    return _of_answer(case, outcome.value, off)


def _may_be(case: Case, nhat_BA_W: Floats, off: float) -> bool:
    """Return whether a unit normal attains the distance; of solids, whether it is an expected one.

    Along the normal of a body with dents its hull tells nothing.
    """
    if case.has_solid:
        return case.normals is None or laws.turned(nhat_BA_W, case.normals) <= JUDGED_TURN
    return laws.lacking(case, case.distance, nhat_BA_W) <= off + JUDGED_UNIT * case.extent


def _of_answer(case: Case, answer: PairAnswer, off: float) -> CaseVerdict:
    given = [x for x in (answer.nhat_BA_W, answer.p_WCa, answer.p_WCb) if x is not None]
    if not (math.isfinite(answer.distance) and np.isfinite(given).all()):
        what = 'distance' if not math.isfinite(answer.distance) else 'normal or witness'
        return CaseVerdict('NaN', what)
    error = abs(answer.distance - case.distance)
    if not error <= off:
        text = f'{answer.distance:.6g} for {case.distance:.6g}'
        return CaseVerdict('wrong', text, error / off)
    if answer.nhat_BA_W is not None:
        if laws.off_unit(answer.nhat_BA_W) > JUDGED_UNIT:
            length = math.hypot(*answer.nhat_BA_W)
            return CaseVerdict('wrong', f'normal of length {length:.3g}', 1.0)
        if not _may_be(case, answer.nhat_BA_W, off):
            shown = ', '.join(f'{x:.3g}' for x in answer.nhat_BA_W)
            return CaseVerdict('wrong', f'normal ({shown})', 1.0)
    if answer.p_WCa is not None and answer.p_WCb is not None:
        gap = abs(math.hypot(*(answer.p_WCa - answer.p_WCb)) - abs(case.distance))
        aside = max(gap, off_surfaces(case, answer.p_WCa, answer.p_WCb))
        if not aside <= 2.0 * off:
            return CaseVerdict('wrong', f'witness points off by {aside:.2g} m', aside / off)
    return CaseVerdict('pass')
