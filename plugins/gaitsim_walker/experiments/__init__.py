"""The walker's presets."""
