"""The contracts of plugins: the base classes that plugins extend, and the types that they use.

The stub lists the names, which are imported at first use: declaring the options of a command needs
no NumPy.
"""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
