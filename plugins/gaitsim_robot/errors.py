"""The error of a robot that cannot be used."""

from gaitsim.errors import GaitsimError


class RobotError(GaitsimError):
    """A robot's file cannot be read, or its robot cannot be used."""
