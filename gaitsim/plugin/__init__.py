"""The parts of plugins: contracts, options, errors, and the plugins of other packages.

Packages import this module, those beside it and `gaitsim.screen`, and nothing deeper. Its stub
lists the names, which are imported at first use.
"""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
