"""MuJoCo without its log."""


def silence() -> None:
    """Keep MuJoCo from printing warnings and from writing them to the working directory.

    Robots that become unstable are failures of their individuals, with a reason.
    """
    import mujoco

    config = mujoco.MjLogConfig.get()
    config.logto_console = config.logto_file = False
    mujoco.MjLogConfig.set(config)
