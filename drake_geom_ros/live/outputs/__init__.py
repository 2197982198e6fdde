"""Content of outputs: results of cycles, surfaces, markers, events of rules, replay files."""
