"""Query engine: one query from broad phase to results.

Takes a world, filters and the query's parameters. Returns arrays that no later change alters, and
a report of the work that was done.
"""
