"""Experiments, evaluation, runs and their individuals."""

from gaitsim.api import Run as Run, evolve as evolve
from gaitsim.evaluating import evaluate as evaluate
from gaitsim.evaluation import (
    Evaluator as Evaluator,
    Executor as Executor,
    evaluate as evaluate_experiment,
)
from gaitsim.evaluation.evaluator import IN_CACHE as IN_CACHE
from gaitsim.evaluation.executors import WorkerLostError as WorkerLostError, cores as cores
from gaitsim.evaluation.playing import play as play, require_play as require_play
from gaitsim.evaluation.processes import OnWarning as OnWarning, ProcessExecutor as ProcessExecutor
from gaitsim.evaluation.scoring import (
    LARGEST_SCORE as LARGEST_SCORE,
    check_motion as check_motion,
    move_genomes as move_genomes,
)
from gaitsim.evaluation.streams import Purpose as Purpose, stream as stream
from gaitsim.evaluation.values import values_of as values_of
from gaitsim.evaluation.worlds import parse_world as parse_world
from gaitsim.evolution.repeats import evolve_repeats as evolve_repeats
from gaitsim.evolution.searching import ask as ask, initial_state as initial_state, tell as tell
from gaitsim.experiment import (
    WORLD as WORLD,
    Experiment as Experiment,
    Overrides as Overrides,
    load_experiment as load_experiment,
    parse_assignments as parse_assignments,
    read_outline as read_outline,
    with_overrides as with_overrides,
)
from gaitsim.experiment.combination import compatible as compatible
from gaitsim.experiment.loading import (
    parse_experiment as parse_experiment,
    read_file as read_file,
    reader_of as reader_of,
    readers as readers,
)
from gaitsim.experiment.model import space_of as space_of, starts_of as starts_of
from gaitsim.experiment.overrides import (
    COMMAND_LINE as COMMAND_LINE,
    Problems as Problems,
    Typed as Typed,
    invalid_value as invalid_value,
    missing_option as missing_option,
)
from gaitsim.individual import (
    Choice as Choice,
    Individual as Individual,
    Member as Member,
    Numbered as Numbered,
    Which as Which,
    mark_of as mark_of,
    standing_skeleton as standing_skeleton,
)
from gaitsim.optimiser import Optimiser as Optimiser
from gaitsim.sharing.challenge import Challenge as Challenge, code_of as code_of
from gaitsim.sharing.code import dictionary as dictionary
from gaitsim.storage.compare_runs import (
    differences as differences,
    scoring_warning as scoring_warning,
)
from gaitsim.storage.compatibility import versions as versions
from gaitsim.storage.creation import create_run as create_run, find_individual as find_individual
from gaitsim.storage.files.atomic import (
    draft_folder as draft_folder,
    replacing as replacing,
    sweep as sweep,
    sync_folder as sync_folder,
    write_bytes as write_bytes,
    writing as writing,
)
from gaitsim.storage.files.checkpoint import Champion as Champion
from gaitsim.storage.files.folder import (
    ADAPTATIONS as ADAPTATIONS,
    CHECKPOINT as CHECKPOINT,
    EXPERIMENT as EXPERIMENT,
    EXPORTS as EXPORTS,
    check_links as check_links,
    check_out_folder as check_out_folder,
    check_root as check_root,
    command as command,
    create_folder as create_folder,
    create_out_folder as create_out_folder,
    create_subfolder as create_subfolder,
    exports_folder as exports_folder,
    free_name as free_name,
    holds_run as holds_run,
    list_runs as list_runs,
    numbered_names as numbered_names,
    unfinished_error as unfinished_error,
)
from gaitsim.storage.files.history import (
    COLUMNS as COLUMNS,
    FIGURE as FIGURE,
    MEAN as MEAN,
    SCORES as SCORES,
    figures_of as figures_of,
    terms_of as terms_of,
)
from gaitsim.storage.files.schema import EXACT_KEYS as EXACT_KEYS, first_problem as first_problem
from gaitsim.storage.files.tables import line as table_line
from gaitsim.storage.lock import RunLock as RunLock, is_locked as is_locked
from gaitsim.storage.manage import read_note as read_note, read_tags as read_tags
from gaitsim.storage.replaying import Bred as Bred, breed_again as breed_again
from gaitsim.storage.settings import editing as editing
from gaitsim.storage.snapshot import RunSnapshot as RunSnapshot
from gaitsim.storage.verification import (
    FileDifference as FileDifference,
    Verdict as Verdict,
    compare_folders as compare_folders,
    file_results as file_results,
)
from gaitsim.verifying import Verifier as Verifier, check_no_atlas as check_no_atlas

__all__ = [
    "ADAPTATIONS",
    "CHECKPOINT",
    "COLUMNS",
    "COMMAND_LINE",
    "EXACT_KEYS",
    "EXPERIMENT",
    "EXPORTS",
    "FIGURE",
    "IN_CACHE",
    "LARGEST_SCORE",
    "MEAN",
    "SCORES",
    "WORLD",
    "Bred",
    "Challenge",
    "Champion",
    "Choice",
    "Evaluator",
    "Executor",
    "Experiment",
    "FileDifference",
    "Individual",
    "Member",
    "Numbered",
    "OnWarning",
    "Optimiser",
    "Overrides",
    "Problems",
    "ProcessExecutor",
    "Purpose",
    "Run",
    "RunLock",
    "RunSnapshot",
    "Typed",
    "Verdict",
    "Verifier",
    "Which",
    "WorkerLostError",
    "ask",
    "breed_again",
    "check_links",
    "check_motion",
    "check_no_atlas",
    "check_out_folder",
    "check_root",
    "code_of",
    "command",
    "compare_folders",
    "compatible",
    "cores",
    "create_folder",
    "create_out_folder",
    "create_run",
    "create_subfolder",
    "dictionary",
    "differences",
    "draft_folder",
    "editing",
    "evaluate",
    "evaluate_experiment",
    "evolve",
    "evolve_repeats",
    "exports_folder",
    "figures_of",
    "file_results",
    "find_individual",
    "first_problem",
    "free_name",
    "holds_run",
    "initial_state",
    "invalid_value",
    "is_locked",
    "list_runs",
    "load_experiment",
    "mark_of",
    "missing_option",
    "move_genomes",
    "numbered_names",
    "parse_assignments",
    "parse_experiment",
    "parse_world",
    "play",
    "read_file",
    "read_note",
    "read_outline",
    "read_tags",
    "reader_of",
    "readers",
    "replacing",
    "require_play",
    "scoring_warning",
    "space_of",
    "standing_skeleton",
    "starts_of",
    "stream",
    "sweep",
    "sync_folder",
    "table_line",
    "tell",
    "terms_of",
    "unfinished_error",
    "values_of",
    "versions",
    "with_overrides",
    "write_bytes",
    "writing",
]
