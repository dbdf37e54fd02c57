"""Optuna as an optimiser of `ductloop tune`: JSON lines on standard input and output, as docs/tuning.md tells.

One objective: TPE, which knows of the constraints; several: NSGA-II. What an earlier call proposed is asked for once more before it is told,
so that the sampler comes to where it was: what it proposes next is what it would have proposed without the interruption.
"""

import json
import math
import sys
import warnings

import optuna
from optuna.distributions import FloatDistribution, IntDistribution
from optuna.trial import TrialState

optuna.logging.set_verbosity(optuna.logging.WARNING)
# What is experimental or to go in a later version of Optuna is nothing that whoever tunes can do something about.
warnings.simplefilter("ignore", FutureWarning)
warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
# The usual 50 would be most of a study's budget.
POPULATION = 20
# Values are told with six digits.
ROUNDING = 1e-5


class Optimiser:
    def __init__(self, begin):
        self.parameters = begin["parameters"]
        self.distributions = {parameter["path"]: distribution(parameter) for parameter in self.parameters}
        self.is_single = len(begin["objectives"]) == 1
        constraints, seed = (lambda trial: [trial.user_attrs.get("violation", 0.0)]), begin["seed"]
        if self.is_single:
            # A generation is asked for at a time: those under way count as bad ones, which keeps them apart.
            sampler = optuna.samplers.TPESampler(seed=seed, constant_liar=True, constraints_func=constraints)
        else:
            sampler = optuna.samplers.NSGAIISampler(seed=seed, population_size=POPULATION, constraints_func=constraints)
        self.study = optuna.create_study(directions=["minimize"] * len(begin["objectives"]), sampler=sampler)
        self.pending = []

    def ask(self, count):
        self.pending = [self.study.ask(self.distributions) for _ in range(count)]
        return [trial.params for trial in self.pending]

    def tell(self, trials):
        if trials[0]["is_replayed"]:
            self.ask(len(trials))
        for told in trials:
            if told["trial"] == 0:
                # The default: known where all scenarios agree on it and it is within the ends.
                if told["values"] and all(p["from"] <= told["values"][p["path"]] <= p["to"] for p in self.parameters):
                    self.finish(self.known(told["values"]), told)
                continue
            trial = self.pending.pop(0)
            if all(math.isclose(trial.params[path], value, rel_tol=ROUNDING) for path, value in told["values"].items()):
                self.finish(trial, told)
            else:
                # Proposed by another version of Optuna.
                self.study.tell(trial, state=TrialState.FAIL)
                self.finish(self.known(told["values"]), told)
        for trial in self.pending:
            self.study.tell(trial, state=TrialState.FAIL)
        self.pending = []

    def known(self, values):
        self.study.enqueue_trial(values)
        return self.study.ask(self.distributions)

    def finish(self, trial, told):
        trial.set_user_attr("violation", told["violation"])
        if None in told["costs"]:
            self.study.tell(trial, state=TrialState.FAIL)
        elif told["is_full"]:
            self.study.tell(trial, told["costs"])
        else:
            # A share of its runs: an intermediate value, never put beside those of all.
            trial.report(told["costs"][0], step=1)
            self.study.tell(trial, state=TrialState.PRUNED)


def distribution(parameter):
    kind, number = (IntDistribution, int) if parameter["whole"] else (FloatDistribution, float)
    return kind(number(parameter["from"]), number(parameter["to"]), log=parameter["scale"] == "log")


def say(message):
    print(json.dumps(message), flush=True)


def main():
    optimiser = Optimiser(json.loads(sys.stdin.readline()))
    say({"ready": f"Optuna {optuna.__version__}, {type(optimiser.study.sampler).__name__}"})
    for line in sys.stdin:
        message = json.loads(line)
        if message["message"] == "ask":
            say({"candidates": optimiser.ask(message["count"])})
        elif message["message"] == "tell":
            optimiser.tell(message["trials"])
        elif message["message"] == "end":
            return


main()
