"""Penetration depths of bodies of revolution, whose best directions form rings.

For cores that are round about an axis, or nearly so. A ring of directions is then almost as good
as the best one, and EPA would need very many faces.
"""
