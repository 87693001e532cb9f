"""Studies and comparisons of experiments, over repeats."""
