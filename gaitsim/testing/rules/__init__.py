"""The rules of the conformance check, a file for each kind of plugin."""
