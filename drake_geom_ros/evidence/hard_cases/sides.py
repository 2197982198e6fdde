"""Who is asked: this project and the installed peers, as functions of a case."""

from __future__ import annotations

from collections.abc import Callable

from drake_geom_ros.evidence.asking import PairScene
from drake_geom_ros.evidence.hard_cases.cases import Case
from drake_geom_ros.evidence.peers import SIGNED_DISTANCE, PairAnswer, installed, load

OURS = 'ours'
Asking = Callable[[Case], 'PairAnswer | None']


def names() -> tuple[str, ...]:
    """Return this project's name and those of the installed peers."""
    return (OURS, *installed())


def asking(name: str, query: str) -> Asking:
    """Return what asks one side a query about a case; a peer is imported here."""
    if name == OURS:
        return lambda case: ask_ours(case, query)
    peer = load(name)
    return lambda case: peer.pair(query, case.a.shape, case.b.shape)(case.a.pose, case.b.pose)


def ask_ours(case: Case, query: str) -> PairAnswer | None:
    """Return our answer in the form of a peer's."""
    scene = PairScene(case.a, case.b)
    if query == SIGNED_DISTANCE:
        row = scene.distance()
        distances = row.distance
    else:
        found = scene.penetration()
        if not len(found):
            return None
        row, distances = found, -found.depth
    return PairAnswer(float(distances[0]), row.nhat_BA_W[0], row.p_WCa[0], row.p_WCb[0])
