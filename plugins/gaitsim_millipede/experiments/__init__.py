"""The millipede's presets."""
