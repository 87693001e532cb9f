"""The checks of plugins against their contracts: a pytest plugin, and tests for each kind.

`gaitsim plugins check NAME` runs the tests in `gaitsim_testing.checks`. A package runs them with
its own tests if its `pyproject.toml` names the plugins:

    [tool.pytest.ini_options]
    gaitsim = ["."]

A name is that of a plugin, of a package, or of a folder with a package, which need not be
installed. `pytest --gaitsim NAME` does the same on the command line, and `--gaitsim-options
'{"mass": 5.0}'` sets options of the plugins. A broken rule fails a test; advice is a warning,
`Advice`, which `pytest -W error::gaitsim_testing.finding.Advice` turns into a failure.

Rules of all kinds: every option has a help text, bounds, and a default within them, and is
unchanged after it is written to an experiment file and read back. Results are bit-identical in a
repeated call and in another process. Arguments are not modified, nothing is printed, and the
global random generator is not used.

- Body: genomes belong to their space. Channels exist, are declared and finite, and have the
  declared axes. Each individual moves identically alone, in another order, in chunks and, if
  declared, in threads. Skeleton, rig, measures and `play` are valid. A steered body moves
  identically however frames are split into calls, and repeats a drive from its options. A world is
  validated, and its nominal values change nothing. A lost leg changes neither the genome space nor
  the shapes of channels. The speed is measured with a population of 100, or with three individuals
  if the body is slow and loops over them.
- Fitness: terms have the right shape and constant names. Only the channels in `needs` are read.
  Scores of individuals are independent.
- Search: the names and dtypes of the state are constant. Results are the same after the state is
  stored and loaded. Genomes belong to the space, and their number is right. Equal, huge and −∞
  scores cause no error. Start points and the optional methods are valid.
- Selection: indices are valid for random, equal, huge and −∞ scores, and parents are better than
  the average.
- Crossover, mutation: results are new arrays of the right shape and dtype for each space in
  `spaces`, with real, periodic and binary genes. Schedules are valid.
- Reflex: state and inputs change in place, stay finite, and have the population as their first
  axis, also if observations outside `needs` are missing. Options may be arrays. The C code reads
  only options, state and observations that exist.
- Plot, exporter: declarations are complete, no option has the name of an option of the command,
  and the product made twice has the same bytes.
- Preset: the file can be read, its first individuals move, and a second population can be bred.
- Command: it has a name of its own, and prints its help.
"""
