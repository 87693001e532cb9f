"""The files of a run, one module a file format; each is read with bounds and written atomically."""
