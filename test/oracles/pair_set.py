"""Collision filters as plain sets of pairs: slow, and short enough to be seen to be right.

Statements are (excludes, set_a, set_b) of keys; *within* a set is between it and itself.
Groups and cliques are excluded pairs like others; ``masks_filter`` is Drake's bit test.
"""


def pairs_between(set_a, set_b):
    """Return the unordered pairs between two sets."""
    return {frozenset((a, b)) for a in set_a for b in set_b if a != b}


class PairSet:
    """Keys with their bodies, what is excluded for good, and a history on top of it."""

    def __init__(self):
        self.bodies, self.excluded, self.history, self.off = {}, set(), {}, set()

    def apply(self, statements):
        self.excluded = self._after(self.excluded, statements)

    def current(self):
        excluded = self.excluded
        for statements in self.history.values():
            excluded = self._after(excluded, statements)
        return excluded

    def flatten(self):
        self.excluded, self.history = self.current(), {}

    def remove(self, key):
        """Take a key out of everything that was said."""
        del self.bodies[key]
        self.off.discard(key)
        self.excluded = {pair for pair in self.excluded if key not in pair}
        self.history = {
            number: [(excludes, a - {key}, b - {key}) for excludes, a, b in statements]
            for number, statements in self.history.items()
        }

    def possible(self):
        """Return the pairs that the invariants leave."""
        keys = self.bodies
        return {p for p in pairs_between(keys, keys) if len({self.bodies[k] for k in p}) == 2}

    def candidates(self):
        """Return the pairs that may be reported."""
        return {p for p in self.possible() - self.current() if not p & self.off}

    @staticmethod
    def _after(excluded, statements):
        for excludes, set_a, set_b in statements:
            pairs = pairs_between(set_a, set_b)
            excluded = excluded | pairs if excludes else excluded - pairs
        return excluded


def masks_filter(membership_a, ignore_a, membership_b, ignore_b):
    """Return whether Drake's groups filter a pair: either belongs to what the other ignores."""
    return bool(membership_a & ignore_b or membership_b & ignore_a)
