"""Commands: each is a model of its options, with the function that carries it out.

The command line, the forms of the terminal UI and the reference of commands are generated from the
models. At its top, a module imports only what declares its options, and modules that load quickly:
no NumPy and no plugins.
"""
