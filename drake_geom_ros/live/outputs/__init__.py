"""Results of cycles, contact surfaces, markers, events of rules, and replay files."""
