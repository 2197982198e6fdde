"""Decides about proximity rules once more, pair by pair and rule by rule, in plain Python.

Shares nothing with the package but the record of a rule: what rules mean is written here a second
time, as ``docs/proximity_rules.md`` says it.
"""

import math


class Referee:
    """The state of one rule."""

    def __init__(self, rule, members):
        """``members(pattern)`` are the geometries that a name or a pattern stands for."""
        self.rule = rule
        self.set_a = set().union(*(members(p) for p in rule.set_a))
        everything = members('*')
        outside = everything - self.set_a
        self.set_b = set().union(*(members(p) for p in rule.set_b)) if rule.set_b else outside
        self.is_entered, self.changed_at, self.near_since = False, -math.inf, None
        self.sequence = 0  # of the event by which it was entered last: told by who numbers them
        self.acknowledged_at, self.cleared_at = None, None  # of this entering
        self.awaits = False

    def concerns(self, a, b):
        return (a in self.set_a and b in self.set_b) or (b in self.set_a and a in self.set_b)

    def acknowledge(self, sequence):
        """Return whether the last entering can be acknowledged by this number."""
        may = self.rule.acknowledge and self.is_entered and sequence == self.sequence
        if may and self.acknowledged_at is None:
            self.acknowledged_at, self.cleared_at, self.awaits = 'now', None, False
        return may

    def look(self, now, pairs, reported, stale, absent, unpredicted=frozenset()):
        """Return whether the rule changed; ``pairs``: (a, b, lower bound, closing speed)."""
        rule = self.rule
        mine = [pair for pair in pairs if self.concerns(*pair[:2])]
        lowest = min((lower for _, _, lower, _ in mine), default=math.inf)
        times = [max(lower, 0.0) / speed for _, _, lower, speed in mine if speed > 0.0]
        soonest = min(times, default=math.inf)
        needed = {g for pair in reported if self.concerns(*pair) for g in pair}
        blind = bool(needed & stale) or bool(needed & absent)
        near = lowest < rule.enter or soonest < rule.min_time_to_contact
        if not near:
            self.near_since = None
        elif self.near_since is None:
            self.near_since = now
        if not self.is_entered:
            long_near = near and now - self.near_since >= rule.enter_after
            changes = long_near or (blind and rule.enters_when_stale)
            self.acknowledged_at = self.cleared_at = None
        else:
            clear = lowest >= rule.leave and soonest >= rule.min_time_to_contact and not blind
            clear &= not (rule.min_time_to_contact and needed & unpredicted)
            long_near = near and now - self.near_since >= rule.enter_after
            if self.cleared_at is not None and (long_near or (blind and rule.enters_when_stale)):
                self.acknowledged_at = self.cleared_at = None  # another cause, that nobody saw
            if clear and self.acknowledged_at and self.cleared_at is None:
                self.cleared_at = now
            is_held = rule.acknowledge and not self.acknowledged_at
            changes = clear and now - self.changed_at >= rule.hold and not is_held
            self.awaits = bool(clear and is_held)
        if changes:
            self.is_entered, self.changed_at = not self.is_entered, now
            self.awaits = False
        return changes
