"""One query from top to bottom.

Enters: a world, filters, what is asked. Leaves: arrays that no later change reaches, and the
report of what was done. The only room that ``geometry.queries`` needs for queries of now; imports
all rooms below.
"""
