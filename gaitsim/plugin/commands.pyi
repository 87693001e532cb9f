"""Commands: their options and their output."""

from gaitsim.actions.action import Action as Action
from gaitsim.actions.action import argument as argument
from gaitsim.actions.action import choose_format as choose_format
from gaitsim.actions.action import ChosenIndividual as ChosenIndividual
from gaitsim.actions.action import DASK as DASK
from gaitsim.actions.action import GENERATIONS as GENERATIONS
from gaitsim.actions.action import JSON as JSON
from gaitsim.actions.action import not_combinable as not_combinable
from gaitsim.actions.action import POPULATION as POPULATION
from gaitsim.actions.action import RUN_OR_CODE as RUN_OR_CODE
from gaitsim.actions.action import SET as SET
from gaitsim.actions.action import WORKERS as WORKERS
from gaitsim.actions.steer import SteeredBody as SteeredBody
from gaitsim.cli.tui import check_terminal as check_terminal
from gaitsim.cli.tui import Root as Root
from gaitsim.cli.tui import run_app as run_app
from gaitsim.cli.tui import ThemeName as ThemeName
from gaitsim.console import INTERRUPTED as INTERRUPTED
from gaitsim.console.cluster import cluster as cluster
from gaitsim.console.cluster import warn as warn_of_cluster
from gaitsim.console.codes import read_individual as read_individual
from gaitsim.console.interrupts import all_or_nothing as all_or_nothing
from gaitsim.console.interrupts import interruptible as interruptible
from gaitsim.console.printing import as_json as as_json
from gaitsim.console.printing import echo as echo
from gaitsim.console.printing import errors as errors
from gaitsim.console.printing import notice as notice
from gaitsim.console.printing import output as output
from gaitsim.console.printing import print_facts as print_facts
from gaitsim.console.printing import print_json as print_json
from gaitsim.console.printing import print_record as print_record
from gaitsim.console.printing import print_table as print_table
from gaitsim.console.printing import report_files as report_files
from gaitsim.console.printing import status as status
from gaitsim.console.progress_bar import Progress as Progress
from gaitsim.console.streams import machine_readable as machine_readable
from gaitsim.console.streams import results as results

__all__ = [
    "Action",
    "all_or_nothing",
    "argument",
    "as_json",
    "check_terminal",
    "choose_format",
    "ChosenIndividual",
    "cluster",
    "DASK",
    "echo",
    "errors",
    "GENERATIONS",
    "INTERRUPTED",
    "interruptible",
    "JSON",
    "machine_readable",
    "not_combinable",
    "notice",
    "output",
    "POPULATION",
    "print_facts",
    "print_json",
    "print_record",
    "print_table",
    "Progress",
    "read_individual",
    "report_files",
    "results",
    "Root",
    "run_app",
    "RUN_OR_CODE",
    "SET",
    "status",
    "SteeredBody",
    "ThemeName",
    "warn_of_cluster",
    "WORKERS",
]
