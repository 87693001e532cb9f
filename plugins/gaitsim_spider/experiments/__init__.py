"""The spider's presets."""
