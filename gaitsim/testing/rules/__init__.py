"""The rules of the conformance check, one module per topic."""
