"""The hunt: a search that evolves pairs of shapes towards a broken promise of their answers."""
