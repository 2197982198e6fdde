"""Live scene of a node, behind its lock: names, poses and their ages, filters, rules, maps.

It takes poses and changes that ``conversions`` has checked, and gives snapshots that no later
change alters.
"""
