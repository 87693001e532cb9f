"""Score populations in this thread, in several threads, or in worker processes."""

from gaitsim.evaluation.evaluator import Evaluator
from gaitsim.evaluation.executors import Executor
from gaitsim.evaluation.scoring import Evaluation, evaluate

__all__ = ["Evaluation", "Evaluator", "Executor", "evaluate"]
