"""How children come from pairs of parents."""
