"""The files of a run, one module per format, with bounded reads and atomic writes."""
