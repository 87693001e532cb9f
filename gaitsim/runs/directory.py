"""A run on disk: made and found, written generation by generation, read back."""

from gaitsim.runs.folder import create_run, find_run, list_runs
from gaitsim.runs.reader import Run, versions
from gaitsim.runs.writer import RunWriter, restored

__all__ = ["Run", "RunWriter", "create_run", "find_run", "list_runs", "restored", "versions"]
