"""Bodies to ask about: random ones, arms, grids, tori, and near touches."""
