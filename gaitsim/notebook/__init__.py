"""gaitsim in Python: evolve in a loop, open runs, look at champions.

`import gaitsim as gs` has all of it; it is meant for notebooks and short scripts, and
stands on the same functions as the command line.
"""

from gaitsim.individual import Individual
from gaitsim.notebook.drawing import picture
from gaitsim.notebook.run import Run, load
from gaitsim.notebook.search import Search, evolve

__all__ = ["Individual", "Run", "Search", "evolve", "load", "picture"]
