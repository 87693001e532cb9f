"""What results mean: statistics over repeats."""
