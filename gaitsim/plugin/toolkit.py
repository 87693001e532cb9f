"""Parts of bodies and operators: portable arithmetic, encodings, networks, what legs share."""

from gaitsim.surface import offer

__getattr__, __dir__ = offer(__name__, __file__)
