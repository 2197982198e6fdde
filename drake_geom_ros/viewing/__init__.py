"""Content of the viewer: scenes, answers, filters and motions as plain data to draw."""
