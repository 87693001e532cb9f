"""Disable MuJoCo's log."""


def disable_log() -> None:
    """Keep MuJoCo from printing warnings and from writing them to the working directory.

    gaitsim reports unstable robots as failed individuals, with a reason.
    """
    import mujoco

    config = mujoco.MjLogConfig.get()
    config.logto_console = config.logto_file = False
    mujoco.MjLogConfig.set(config)
