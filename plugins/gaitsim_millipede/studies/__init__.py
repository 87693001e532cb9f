"""The millipede's ready studies."""
