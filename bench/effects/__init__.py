"""What scenes of a ladder cost: imported, compiled, allocated, computed, published."""
