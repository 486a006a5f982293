"""Does canvass leave a device as it was found? Judged by python-canopen, which knows nothing of how canvass does it.

`cargo xtask as-found` builds what it needs and starts it; docs/testing.md describes it.
"""

import argparse
import logging
import multiprocessing
import sys

import live
import proof
from lockstep import Lockstep
from matrix import SAMPLE, WHOLE, try_all
from situation import FORGETFUL, SITUATIONS, situations_of
from stand import Stand
from table import in_full, shortest, table
from trial import Trial


def arguments():
    parser = argparse.ArgumentParser(prog="as-found")
    parser.add_argument("--lockstep", required=True, help="the program with the simulated devices")
    parser.add_argument("--canvass", help="the program, for runs of real processes, which are part of --all")
    parser.add_argument("--descriptions", default="conformance/device/models", help="the folder of the models' EDS")
    parser.add_argument("--all", action="store_true", help="the whole matrix instead of a sample")
    parser.add_argument("--seed", type=int, default=1, help="of all random choices")
    parser.add_argument("--model", action="append", help="only this one")
    parser.add_argument("--situation", choices=SITUATIONS, help="with --allow: one run, told in full")
    parser.add_argument("--allow", help="words with commas between them, all or none")
    parser.add_argument("--select", default="", help="cases with commas between them")
    parser.add_argument("--interrupt", type=int, help="Ctrl-C at this frame of the run")
    parser.add_argument("--kill", type=int, help="SIGKILL at this frame of the run, then restore")
    parser.add_argument("--seconds", type=float, help="SIGKILL of a process after these seconds, then restore")
    return parser.parse_args()


def main():
    logging.disable(logging.ERROR)
    options = arguments()
    lockstep = Lockstep(options.lockstep)
    catalogue = lockstep.ask("catalogue")
    lockstep.close()
    if options.allow is not None:
        outcome = one(options, catalogue["words"])
        print(in_full(outcome))
        return 0 if outcome.is_good else 1
    unseen = proof.unseen(options.lockstep, options.descriptions)
    if unseen:
        print("the judge does not see: " + "; ".join(unseen))
        return 2
    models = options.model or catalogue["models"]
    outcomes = matrix(options, catalogue, models)
    if options.all and options.canvass:
        outcomes += live.kills(options.canvass, options.descriptions, catalogue, models, options.seed)
    idle = [model for model in models if not any(outcome.began for outcome in outcomes if outcome.trial.model == model)]
    if idle:
        print(f"nothing is known: no run began on {', '.join(idle)}")
        return 2
    bad = [outcome for outcome in outcomes if not outcome.is_good]
    print(table(outcomes, models), shortest(bad), sep="\n\n")
    print(
        f"seed {options.seed}: {len(outcomes)} runs, {len(outcomes) - len(bad)} left the device as it was found,",
        end=" ",
    )
    print(f"{len(bad)} did not")
    return 1 if bad else 0


def one(options, words):
    """A single trial."""
    allow = {"all": words, "none": []}.get(options.allow, options.allow.split(","))
    select = tuple(filter(None, options.select.split(",")))
    [model] = options.model
    trial = Trial(
        model, options.situation, tuple(allow), options.allow, select, options.interrupt, None, options.seconds
    )
    if trial.seconds is not None:
        return live.kill(options.canvass, options.descriptions, trial)
    with Stand(options.lockstep, options.descriptions, trial.model, trial.situation) as stand:
        [outcome] = stand.kill(trial, [options.kill]) if options.kill else [stand.run(trial)]
    return outcome


def matrix(options, catalogue, models):
    """All trials, on all processors."""
    extent = WHOLE if options.all else SAMPLE
    jobs = [
        (options.lockstep, options.descriptions, model, situation, catalogue, extent, options.seed)
        for number, model in enumerate(models)
        for situation in (situations_of(model) if options.all else sampled(model, number + options.seed))
    ]
    with multiprocessing.Pool() as pool:
        return [outcome for outcomes in pool.imap(try_all, jobs, chunksize=1) for outcome in outcomes]


def sampled(model, number):
    """Two situations, one of them with a switch: some devices are not tested without. A model that begins in one only has
    that one."""
    if model in FORGETFUL:
        return [name for name in situations_of(model) if not SITUATIONS[name].has_profile]
    known = situations_of(model)
    kinds = [[name for name in known if SITUATIONS[name].has_switch is has] for has in (True, False)]
    return [names[number % len(names)] for names in kinds]


if __name__ == "__main__":
    sys.exit(main())
