"""The walker: a planar body on two or four legs in a rigid-body simulation."""
