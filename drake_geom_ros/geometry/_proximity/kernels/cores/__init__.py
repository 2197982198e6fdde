"""Convex pairs without a closed form, and hulls: GJK, EPA, Newton's method on normals."""
