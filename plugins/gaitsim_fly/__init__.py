"""The fly: a rigid body with two wings, controlled by a neural network."""
