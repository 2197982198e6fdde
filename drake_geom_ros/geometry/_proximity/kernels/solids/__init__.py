"""Bodies that a mesh bounds, dents, holes and all: trees of boxes over their triangles."""
