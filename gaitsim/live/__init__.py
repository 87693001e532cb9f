"""A run that evolves in its own process, which other processes control and watch.

    RunProcess, in any    commands, one JSON object per line ──▶ a Unix   python -m gaitsim.live RUN
    number of programs    ◀── snapshots, one JSON object per line socket

The process detaches from its parent, outlives it, and accepts commands from any client of its
socket, which is in a private folder of the user (`gaitsim.storage.background`). A new client first
receives a snapshot with all keys but `rows`, `events` and `error`; the rows are in the folder of
the run. A client that disconnects, or does not read for two seconds, does not affect the run.

Commands:

    {"do": "pause"}                                    pause after the current generation
    {"do": "go"}                                       continue after a pause
    {"do": "step"}                                     evolve one generation, then pause
    {"do": "set", "values": {"fitness.yaw_weight": 8}} change options between two generations, as
                                                       a stage; "typed" instead of "values" holds
                                                       strings in the syntax of --set
    {"do": "stop"}                                     save and stop after the current generation

SIGTERM acts as `stop`. SIGINT is ignored, because Ctrl-C in a terminal is meant for the program in
the foreground. Lines that are not commands are ignored.

A snapshot is written after each change, at most twenty times a second. Its keys are as follows;
those after `scored` appear only if they have changed:

    state         preparing, running, paused, or queued while one run per core is evolving; at the
                  end finished, stopped or failed
    reason        reason why the run is finished; '' otherwise
    generation    last finished generation; 0 before the first. It is on disk when a pause
                  or the end is reported, and otherwise half a second later at the latest
    generations   number of planned generations
    stage         number of the stage, counted from 1
    scored_from   first generation whose scores are comparable with the current ones
    evaluations   number of individuals evaluated so far
    evaluations_per_second, generations_per_second  current speed; 0 while the search is idle
    scored        share of the next generation that is scored, from 0 to 1; 0 in quick generations
    rows          history of the generations since the last snapshot: {column: [numbers]}; for a
                  slow reader the oldest rows are omitted; the run's folder holds all
    top           best individuals of the last generation, best first:
                  [{"generation", "score", "terms": {term: number}}]
    islands       best score of each island in the last generation: [numbers]; only with several
                  islands
    champion      best individual so far: {"generation", "score", "genome": [numbers]}
    events        events since the last snapshot: [{"generation", "kind", "text"}]; kinds are best,
                  kept, stage and warning
    error         {"what", "where", "key", "allowed", "remedy"}; the error of an experiment also has
                  "noun", and a list "problems" of the same form. With the state `failed`, the error
                  ended the process. Otherwise, a change was rejected, and the run continues as
                  before.

Numbers that are not finite are null. The exit code is 0, or 2 after an `error`.
"""
