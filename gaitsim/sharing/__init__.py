"""Challenge codes: texts to share that hold one individual with its experiment and score."""
