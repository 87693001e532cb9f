"""The millipede's ready experiments."""
