"""A run that evolves in a process of its own, controlled and watched from other ones.

    a program             commands, a JSON object a line ──▶ stdin  python -m gaitsim.live RUN
                          ◀── snapshots, a JSON object a line stdout

    RunProcess, in        commands ──▶ a Unix socket    python -m gaitsim.live --listen RUN
    any number of places  ◀── snapshots

With `--listen` the process leaves the one that began it: it outlives it, and takes commands from
any client of its socket, which lies in a private folder of the user (`gaitsim.runs.background`).
A client that joins first gets a snapshot with everything but the rows; they are in the run's
folder. One that leaves, or does not read for two seconds, does not matter to the run.

Commands:

    {"do": "pause"}                                    after the current generation
    {"do": "go"}                                       continue after a pause
    {"do": "step"}                                     one generation, then pause
    {"do": "set", "values": {"mutation.rate": 0.1}}    between two generations, as a stage;
                                                       "typed" instead has texts as for --set
    {"do": "stop"}                                     after this generation, saved

SIGTERM is a `stop`, too, and so is the end of standard input. SIGINT is ignored, as Ctrl-C in a
terminal is meant for the program in front. A line that is not a command is ignored.

A snapshot is written when something happens, at most twenty times a second. Its keys; those
after `generations_per_second` only where they have changed:

    state         preparing, running, paused; with `--listen` also queued, as no more runs evolve
                  at once than there are cores; at the end finished, stopped or failed
    reason        why the run is finished; ''
    generation    the last one that is on the disk; 0 before the first
    generations   as many as are planned
    stage         from 1
    scored_from   the first generation whose scores can be compared with the present ones
    evaluations   individuals so far
    evaluations_per_second, generations_per_second  of late; 0 where it rests
    rows          of the generations since the last snapshot: {column of the history: [numbers]};
                  for a slow reader the oldest are left out; the run has them
    top           of the last generation: [{"score": number, "terms": {term: number}}], best first
    islands       the best score of each island in the last generation: [numbers]; only where
                  there are several
    champion      the best so far: {"generation", "score", "genome": [numbers]}
    events        what happened: [{"generation", "kind", "text"}]; kinds are best, kept, stage
                  and warning
    error         {"what", "where", "allowed", "remedy"}, with "problems", a list of such, where
                  there are several. With the state `failed` it ended the process. Otherwise a
                  change was refused, and the run continues as before.

Numbers that are not finite are null. The process ends with 0, or 2 where it failed by an `error`.
"""
