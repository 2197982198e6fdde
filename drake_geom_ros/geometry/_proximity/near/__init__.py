"""The neighbour list: which pairs are near enough to be looked at.

Enters: a world, the filters, a cutoff [m]. Leaves: pairs (k, 2) with i < j, less the filtered,
each with the slot in which its last answer is kept. Grids for many bodies, all pairs for few;
skins let a list stand for many cycles. Imports ``world``, ``filters`` and ``runtime``.
"""
