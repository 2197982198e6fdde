"""True signed distances, from mpmath and searches over directions: no kernel takes part."""
