"""Bodies to ask about: random ones, arms, grids, and near touches."""
