"""Scene model: sources, frames, geometries, properties, sets and filter declarations.

Records are found by id, and versions count their changes. The model has neither current poses nor
queries.
"""
