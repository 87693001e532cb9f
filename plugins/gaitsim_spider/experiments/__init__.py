"""The spider's ready experiments."""
