"""The walker's ready experiments."""
