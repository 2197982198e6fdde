"""Services about proximity rules: the live scene, a request, a response. RuntimeError refuses."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.live.conversions.proximity_rules import rule_from_message
from drake_geom_ros.live.conversions.request_types import (
    AcknowledgeRuleRequest,
    AddRuleRequest,
    EmptyRequest,
    NamedRequest,
)
from drake_geom_ros.live.scene.change import Change, unchanged
from drake_geom_ros.live.scene.held_scene import HeldScene
from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.scene.rule_states import fill_rule_states
from drake_geom_ros.proximity_rules import RuleError


def add_proximity_rule(live: LiveScene, request: AddRuleRequest, response: Any) -> None:
    """Add a rule that some pair of the scene can enter."""
    rule = rule_from_message(request.rule)

    def first(scene: HeldScene) -> None:
        if rule.min_time_to_contact and not scene.poses.watches_motion:
            raise RuleError(
                f'proximity rule {rule.name[:80]!r}: min_time_to_contact needs twists, and nobody '
                'watches how bodies move; set the parameter closing_speeds'
            )

    def then(scene: HeldScene, _: None) -> str:
        scene.bind_rules()
        scene.stopping.refuse(rule)
        state = scene.rules.add([rule])
        response.pairs, response.left_out_pairs = state.pairs, state.left_out
        scene.log.notes.append(f'proximity rule {rule.name!r} watches {state.pairs} pairs')
        return '; '.join(scene.maps.finer_rules(rule.name))

    change = Change(unchanged, first, then, rules=[rule], same_content=True)
    response.message = live.change(change)


def remove_proximity_rule(live: LiveScene, request: NamedRequest, response: Any) -> None:
    """Remove a rule; the message says so where nobody acknowledged that it was entered."""
    name = request.name

    def then(scene: HeldScene, _: None) -> str:
        scene.bind_rules()
        event = scene.rules.unacknowledged().get(name)
        scene.rules.remove(name)
        scene.log.notes.append(f'proximity rule {name!r} removed')
        if event is None:
            return ''
        note = f'proximity rule {name!r} was entered by event {event}, and nobody acknowledged it'
        scene.log.warnings.append(f'{note}; it was removed')
        return note

    change = Change(unchanged, then=then, rules_gone=[name], same_content=True)
    response.message = live.change(change)


def acknowledge_rule(live: LiveScene, request: AcknowledgeRuleRequest, response: Any) -> None:
    """Let a latched rule be left that was entered by the event that the request names."""
    with live.editing() as scene:
        scene.bind_rules()
        waiting = {s.rule.name for s in scene.rules.states() if s.awaits_acknowledgement}
        is_clear = request.name in waiting
        scene.rules.acknowledge(request.name, request.sequence)
        scene.log.notes.append(
            f'proximity rule {request.name!r}: event {request.sequence} was acknowledged'
        )
        if request.name not in {rule.name for rule in scene.rules.rules}:
            response.message = 'it has ended: nothing is left of what it was about'
        elif is_clear:
            response.message = 'it is left by the next decision'
        else:
            response.message = 'its cause persists; it is left when that has gone'


def list_proximity_rules(live: LiveScene, request: EmptyRequest, response: Any) -> None:
    """Report the rules and their states."""
    with live.reading() as scene:
        fill_rule_states(response.states, scene)
