"""The terminal of commands: their output, progress, exit codes and interruption."""

MISTAKE, INTERRUPTED = 2, 130  # exit codes
