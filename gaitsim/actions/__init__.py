"""Actions on runs: each is a model of its options, and the function that carries it out.

The command line, the forms of the terminal UI and the reference of commands are generated from the
models. A module imports at its top only what declares its options.
"""
