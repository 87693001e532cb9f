"""Selection: the choice of parents."""
