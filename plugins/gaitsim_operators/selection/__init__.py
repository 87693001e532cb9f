"""Selection operators, which choose parents."""
