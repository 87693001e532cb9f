"""Experiments, evaluation, runs and their individuals."""

from gaitsim.api import Run as Run
from gaitsim.evaluating import evaluate as evaluate
from gaitsim.evaluation import Evaluator as Evaluator
from gaitsim.evaluation import Executor as Executor
from gaitsim.evaluation.evaluator import IN_CACHE as IN_CACHE
from gaitsim.evaluation.executors import cores as cores
from gaitsim.evaluation.executors import WorkerLostError as WorkerLostError
from gaitsim.evaluation.playing import play as play
from gaitsim.evaluation.playing import require_play as require_play
from gaitsim.evaluation.processes import OnWarning as OnWarning
from gaitsim.evaluation.processes import ProcessExecutor as ProcessExecutor
from gaitsim.evaluation.scoring import LARGEST_SCORE as LARGEST_SCORE
from gaitsim.evaluation.scoring import move_genomes as move_genomes
from gaitsim.evaluation.streams import Purpose as Purpose
from gaitsim.evaluation.streams import stream as stream
from gaitsim.evaluation.values import values_of as values_of
from gaitsim.evaluation.worlds import parse_world as parse_world
from gaitsim.evolution.repeats import evolve_repeats as evolve_repeats
from gaitsim.experiment import Experiment as Experiment
from gaitsim.experiment import load_experiment as load_experiment
from gaitsim.experiment import Overrides as Overrides
from gaitsim.experiment import parse_assignments as parse_assignments
from gaitsim.experiment import read_outline as read_outline
from gaitsim.experiment import with_overrides as with_overrides
from gaitsim.experiment.loading import parse_experiment as parse_experiment
from gaitsim.experiment.loading import read_file as read_file
from gaitsim.experiment.loading import reader_of as reader_of
from gaitsim.experiment.loading import readers as readers
from gaitsim.experiment.overrides import COMMAND_LINE as COMMAND_LINE
from gaitsim.experiment.overrides import invalid_value as invalid_value
from gaitsim.experiment.overrides import missing_option as missing_option
from gaitsim.experiment.overrides import Problems as Problems
from gaitsim.individual import Choice as Choice
from gaitsim.individual import Individual as Individual
from gaitsim.individual import Member as Member
from gaitsim.individual import standing_skeleton as standing_skeleton
from gaitsim.individual import Which as Which
from gaitsim.optimiser import Optimiser as Optimiser
from gaitsim.sharing.challenge import Challenge as Challenge
from gaitsim.sharing.challenge import code_of as code_of
from gaitsim.sharing.code import dictionary as dictionary
from gaitsim.steering import Drive as Drive
from gaitsim.storage.compare_runs import ComparedRun as ComparedRun
from gaitsim.storage.compare_runs import RunsReader as RunsReader
from gaitsim.storage.compare_runs import warning as warning
from gaitsim.storage.compatibility import versions as versions
from gaitsim.storage.creation import find_individual as find_individual
from gaitsim.storage.differences import differences as differences
from gaitsim.storage.differences import scoring_warning as scoring_warning
from gaitsim.storage.files.atomic import draft_folder as draft_folder
from gaitsim.storage.files.atomic import replacing as replacing
from gaitsim.storage.files.atomic import sweep as sweep
from gaitsim.storage.files.atomic import sync_folder as sync_folder
from gaitsim.storage.files.atomic import write_bytes as write_bytes
from gaitsim.storage.files.atomic import writing as writing
from gaitsim.storage.files.folder import ADAPTATIONS as ADAPTATIONS
from gaitsim.storage.files.folder import check_links as check_links
from gaitsim.storage.files.folder import check_out_folder as check_out_folder
from gaitsim.storage.files.folder import check_root as check_root
from gaitsim.storage.files.folder import CHECKPOINT as CHECKPOINT
from gaitsim.storage.files.folder import command as command
from gaitsim.storage.files.folder import create_folder as create_folder
from gaitsim.storage.files.folder import create_out_folder as create_out_folder
from gaitsim.storage.files.folder import create_subfolder as create_subfolder
from gaitsim.storage.files.folder import EXPERIMENT as EXPERIMENT
from gaitsim.storage.files.folder import EXPORTS as EXPORTS
from gaitsim.storage.files.folder import exports_folder as exports_folder
from gaitsim.storage.files.folder import find_run as find_run
from gaitsim.storage.files.folder import free_name as free_name
from gaitsim.storage.files.folder import holds_run as holds_run
from gaitsim.storage.files.folder import list_runs as list_runs
from gaitsim.storage.files.folder import numbered_names as numbered_names
from gaitsim.storage.files.folder import unfinished_error as unfinished_error
from gaitsim.storage.files.history import COLUMNS as COLUMNS
from gaitsim.storage.files.history import FIGURE as FIGURE
from gaitsim.storage.files.history import figures_of as figures_of
from gaitsim.storage.files.history import MEAN as MEAN
from gaitsim.storage.files.history import SCORES as SCORES
from gaitsim.storage.files.history import terms_of as terms_of
from gaitsim.storage.files.schema import EXACT_KEYS as EXACT_KEYS
from gaitsim.storage.files.schema import first_problem as first_problem
from gaitsim.storage.files.tables import line as table_line
from gaitsim.storage.lock import is_locked as is_locked
from gaitsim.storage.lock import RunLock as RunLock
from gaitsim.storage.manage import read_note as read_note
from gaitsim.storage.manage import read_tags as read_tags
from gaitsim.storage.settings import editing as editing
from gaitsim.storage.snapshot import RunSnapshot as RunSnapshot
from gaitsim.storage.verification import compare_folders as compare_folders
from gaitsim.storage.verification import file_results as file_results
from gaitsim.storage.verification import FileDifference as FileDifference
from gaitsim.storage.verification import populations as populations
from gaitsim.storage.verification import Verdict as Verdict
from gaitsim.verifying import check_no_atlas as check_no_atlas
from gaitsim.verifying import Verifier as Verifier

__all__ = [
    "ADAPTATIONS",
    "Challenge",
    "check_links",
    "check_no_atlas",
    "check_out_folder",
    "check_root",
    "CHECKPOINT",
    "Choice",
    "code_of",
    "COLUMNS",
    "command",
    "COMMAND_LINE",
    "compare_folders",
    "ComparedRun",
    "cores",
    "create_folder",
    "create_out_folder",
    "create_subfolder",
    "dictionary",
    "differences",
    "draft_folder",
    "Drive",
    "editing",
    "evaluate",
    "Evaluator",
    "evolve_repeats",
    "EXACT_KEYS",
    "Executor",
    "Experiment",
    "EXPERIMENT",
    "EXPORTS",
    "exports_folder",
    "FIGURE",
    "figures_of",
    "file_results",
    "FileDifference",
    "find_individual",
    "find_run",
    "first_problem",
    "free_name",
    "holds_run",
    "IN_CACHE",
    "Individual",
    "invalid_value",
    "is_locked",
    "LARGEST_SCORE",
    "list_runs",
    "load_experiment",
    "MEAN",
    "Member",
    "missing_option",
    "move_genomes",
    "numbered_names",
    "OnWarning",
    "Optimiser",
    "Overrides",
    "parse_assignments",
    "parse_experiment",
    "parse_world",
    "play",
    "populations",
    "Problems",
    "ProcessExecutor",
    "Purpose",
    "read_file",
    "read_note",
    "read_outline",
    "read_tags",
    "reader_of",
    "readers",
    "replacing",
    "require_play",
    "Run",
    "RunLock",
    "RunSnapshot",
    "RunsReader",
    "SCORES",
    "scoring_warning",
    "standing_skeleton",
    "stream",
    "sweep",
    "sync_folder",
    "table_line",
    "terms_of",
    "unfinished_error",
    "values_of",
    "Verdict",
    "Verifier",
    "versions",
    "warning",
    "Which",
    "with_overrides",
    "WorkerLostError",
    "write_bytes",
    "writing",
]
