"""The gates of a node: those of its parameter, and those of its scene file."""

from __future__ import annotations

from collections.abc import Sequence

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.scene_files import Gate, SceneDescription, gates_of_text, shared_topic

_PARAMETER = 'gate'


def gates_of_parameter(text: str) -> tuple[Gate, ...]:
    """Return the gates of the parameter ``gate``; raises SceneFileError."""
    return gates_of_text(text, _PARAMETER) if text.strip() else ()


def all_gates(text: str, described: SceneDescription | None) -> tuple[Gate, ...]:
    """Return the gates of the parameter ``gate``, and of a scene file.

    One that both give alike counts once, as in a scene that was saved with that of a parameter.
    Raises ArgumentError for two that have a topic in common.
    """
    gates = list(gates_of_parameter(text))
    for gate in () if described is None else described.gates:
        if gate not in gates:
            refuse_shared_topic(gate, gates)
            gates.append(gate)
    return tuple(gates)


def refuse_shared_topic(gate: Gate, others: Sequence[Gate]) -> None:
    """Raise ArgumentError where a gate has a topic of another one."""
    for other in others:
        if shared := shared_topic(gate, other):
            raise ArgumentError(
                f'{gate.where}: the {gate.in_words()} has the topic {shared!r} of the '
                f'{other.in_words()} ({other.where}): a command passes one gate, and each gate '
                'has an output of its own; leave one of the two out'
            )
