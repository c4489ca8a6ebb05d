"""What pictures are made of: selections, curves, words, panels, marks."""
