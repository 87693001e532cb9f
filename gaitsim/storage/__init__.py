"""Runs on disk: safe checkpoints and how their files are written."""
