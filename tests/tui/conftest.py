"""Screens are driven in a temporary folder with runs of puppets."""

from tui_driver import config, drive, state_folder  # noqa: F401 (fixtures)
