"""An eight-legged spider."""
