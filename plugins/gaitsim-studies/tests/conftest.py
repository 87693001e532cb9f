"""Fixtures that drive the app's screens."""

from driving import config, drive, state_folder

__all__ = ["config", "drive", "state_folder"]
