"""Score populations in this thread, in several threads, or in worker processes."""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
