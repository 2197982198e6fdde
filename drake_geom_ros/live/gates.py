"""The gates of a node: those of its parameter, and those of its scene file; what they pass."""

from __future__ import annotations

from collections.abc import Sequence

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.velocity_gate import Decision, VelocityGate
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


def decide_gate(scene: HeldScene, robot: str, gate: VelocityGate, now: float) -> None:
    """Set the gate of a robot to what the rules of a scene allow at the time ``now`` [s].

    Where rules of level STOPPABLE are about the robot, its last command is proved: the base is
    swept along it, through reaction and braking. What passes is that command alone, times the
    largest share for which all of these stops are clear.
    """
    scale, why, stoppable = scene.rules.scale_about(robot)
    if not stoppable:
        gate.decide(Decision(scale, why), now)
        return
    command = gate.command()
    if command[2:5].any():
        why = 'of its command only x, y and the turn about z can be proved'
        gate.decide(Decision(0.0, why), now, command)
        return
    stops = scene.stopping.commanded(robot, command) if scale > 0.0 else {}
    if stops is None:
        why = f'{robot!r} is no robot whose braking proximity rule {stoppable[0]!r} could prove'
        gate.decide(Decision(0.0, why), now, command)
        return
    for name in stoppable if stops else ():
        stop = stops.get(name)
        if stop is None or stop.scale < scale:
            scale, why = 0.0 if stop is None else stop.scale, f'proximity rule {name!r}'
    gate.decide(Decision(scale, why), now, command)
