"""Challenge codes: one individual with its experiment and its score, as a text to share."""
