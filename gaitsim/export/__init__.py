"""What leaves a run: gait files and plots."""
