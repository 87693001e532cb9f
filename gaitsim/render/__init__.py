"""Pictures of runs and gaits: plots, scenes, videos, and pictures in the terminal."""
