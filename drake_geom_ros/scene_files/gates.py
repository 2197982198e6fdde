"""Gates of scene files: which commands of velocity a node scales by its proximity rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.schema import check_schema, scene_schema
from drake_geom_ros.scene_files.yaml_text import Document, read_yaml

TWIST, TWIST_STAMPED = 'Twist', 'TwistStamped'
TYPES = (TWIST, TWIST_STAMPED)
_SECTION = 'gate'


@dataclass(frozen=True)
class Gate:
    """Two topics, and the robot whose commands of velocity go from the first to the second.

    - ``robot``: a name or pattern of a source, robot or frame, as sets of proximity rules have it.
    - ``type``: one of ``TYPES``; empty: that of whoever publishes or listens.
    - ``timeout``: the robot is stopped if no command comes for so long [s].
    """

    input: str
    output: str
    robot: str
    type: str = ''
    timeout: float = 0.5
    where: Location = field(default=Location('<scene>'), compare=False)

    def in_words(self) -> str:
        """Return its topics as a text."""
        return f'gate {self.input} -> {self.output}'


def read_gates(document: Document) -> tuple[Gate, ...]:
    """Return the gates of a document; raises SceneFileError for two with a topic in common."""
    plain: Any = document.value.get(_SECTION, ())
    if isinstance(plain, Mapping):
        return (_gate(plain, document.at(_SECTION)),)
    gates = [_gate(each, document.at(_SECTION, k)) for k, each in enumerate(plain)]
    for k, gate in enumerate(gates):
        for other in gates[:k]:
            if shared := shared_topic(gate, other):
                raise gate.where.error(
                    f'{shared!r} is a topic of another gate, too; a command passes one gate, and '
                    'each gate has an output of its own'
                )
    return tuple(gates)


def gates_of_text(text: str, called: str) -> tuple[Gate, ...]:
    """Return the gates of a YAML text as it stands below ``gate`` of a scene file.

    ``called`` is the name of the text in errors. Raises SceneFileError for an invalid one.

    >>> (gate,) = gates_of_text('{in: cmd_vel_in, out: cmd_vel, robot: base}', 'example')
    >>> gate.output, gate.timeout
    ('cmd_vel', 0.5)
    """
    document = read_yaml(text, called)
    lines = {(): 1, **{(_SECTION, *path): line for path, line in document.lines.items()}}
    whole = Document(document.file, {_SECTION: document.value}, lines)
    check_schema(whole, scene_schema())
    return read_gates(whole)


def shared_topic(gate: Gate, other: Gate) -> str:
    """Return a topic that two gates both take from, or both publish on; empty: none."""
    if gate.input == other.input:
        return gate.input
    return gate.output if gate.output == other.output else ''


def _gate(plain: Mapping[str, Any], where: Location) -> Gate:
    if plain['in'] == plain['out']:
        raise where.error(f'in and out are both {plain["in"]!r}; a gate has two topics')
    timeout = float(plain.get('timeout', Gate.timeout))
    return Gate(plain['in'], plain['out'], plain['robot'], plain.get('type', ''), timeout, where)


def plain_gates(gates: Sequence[Gate]) -> Any:
    """Return the plain form of gates, without defaults: a mapping, or a list of several."""
    plain = [
        {
            'in': gate.input,
            'out': gate.output,
            'robot': gate.robot,
            **({'type': gate.type} if gate.type else {}),
            **({'timeout': gate.timeout} if gate.timeout != Gate.timeout else {}),
        }
        for gate in gates
    ]
    return plain[0] if len(plain) == 1 else plain


def gates_left_out(gates: Sequence[Gate]) -> str:
    """Return a warning that these gates are not open here; empty where there are none."""
    if not gates:
        return ''
    names = ', '.join(gate.in_words() for gate in gates)
    return f'{gates[0].where}: {names}: a node opens gates, and here nothing is stopped by one'
