from gaitsim.evaluation.evaluator import Evaluator as Evaluator
from gaitsim.evaluation.executors import Executor as Executor
from gaitsim.evaluation.scoring import Evaluation as Evaluation, evaluate as evaluate
