"""What measures and judges our answers."""
