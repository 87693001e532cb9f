"""The error for robots that cannot be used."""

from gaitsim.errors import GaitsimError


class RobotError(GaitsimError):
    """A robot's file cannot be read, or the robot cannot be used."""
