"""Maps of designs: the best gaits of a body for many values of its dimensions."""
