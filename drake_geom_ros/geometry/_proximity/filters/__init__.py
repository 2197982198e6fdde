"""Which pairs may be reported, and why not.

Enters: declarations, groups, what is anchored. Leaves: one bit a pair, and the reasons of each.
The log is what was said, in order; the matrix follows from it. Imports ``runtime`` only.
"""
