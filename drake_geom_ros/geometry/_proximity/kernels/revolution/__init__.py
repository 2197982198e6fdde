"""Depths of bodies of revolution, where a ring of directions is almost as good as the best."""
