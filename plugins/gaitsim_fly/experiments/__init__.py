"""The fly's ready experiments."""
