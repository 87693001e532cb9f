"""The millipede's studies."""
