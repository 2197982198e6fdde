"""Which pairs may be reported, and why not.

The log is what was said, in order; the matrix follows from it.

In: declarations, groups, what is anchored.
Out: one bit a pair, and the reasons of each.
May import: ``math``, ``_proximity``, ``runtime``; numpy.
"""
