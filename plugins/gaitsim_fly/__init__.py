"""The fly: a rigid body with two wings, steered by a network, for gaitsim."""
