"""Commands: their options and their output."""

from gaitsim.actions.action import (
    DASK as DASK,
    EXPERIMENT as EXPERIMENT,
    GENERATIONS as GENERATIONS,
    JSON as JSON,
    POPULATION as POPULATION,
    RUN_OR_CODE as RUN_OR_CODE,
    SET as SET,
    WORKERS as WORKERS,
    Action as Action,
    ChosenIndividual as ChosenIndividual,
    argument as argument,
    choose_format as choose_format,
    not_combinable as not_combinable,
    parse_pairs as parse_pairs,
)
from gaitsim.actions.evolve import EvolveNew as EvolveNew
from gaitsim.cli.tui import (
    Root as Root,
    ThemeName as ThemeName,
    check_terminal as check_terminal,
    run_app as run_app,
)
from gaitsim.console import INTERRUPTED as INTERRUPTED
from gaitsim.console.cluster import cluster as cluster, warn as warn_of_cluster
from gaitsim.console.codes import read_individual as read_individual
from gaitsim.console.evolving import starting_individual as starting_individual
from gaitsim.console.interrupts import (
    all_or_nothing as all_or_nothing,
    interruptible as interruptible,
)
from gaitsim.console.printing import (
    as_json as as_json,
    echo as echo,
    errors as errors,
    notice as notice,
    output as output,
    print_facts as print_facts,
    print_json as print_json,
    print_record as print_record,
    print_table as print_table,
    report_files as report_files,
    status as status,
)
from gaitsim.console.progress_bar import Progress as Progress
from gaitsim.console.streams import machine_readable as machine_readable, results as results

__all__ = [
    "DASK",
    "EXPERIMENT",
    "GENERATIONS",
    "INTERRUPTED",
    "JSON",
    "POPULATION",
    "RUN_OR_CODE",
    "SET",
    "WORKERS",
    "Action",
    "ChosenIndividual",
    "EvolveNew",
    "Progress",
    "Root",
    "ThemeName",
    "all_or_nothing",
    "argument",
    "as_json",
    "check_terminal",
    "choose_format",
    "cluster",
    "echo",
    "errors",
    "interruptible",
    "machine_readable",
    "not_combinable",
    "notice",
    "output",
    "parse_pairs",
    "print_facts",
    "print_json",
    "print_record",
    "print_table",
    "read_individual",
    "report_files",
    "results",
    "run_app",
    "starting_individual",
    "status",
    "warn_of_cluster",
]
