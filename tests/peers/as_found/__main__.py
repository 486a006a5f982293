"""Does canvass leave a device as it was found? Judged by python-canopen, which knows nothing of how canvass does it.

    python tests/peers/as_found --lockstep target/debug/lockstep [--all] [--seed N] [--model ID]...
    python tests/peers/as_found --lockstep ... --model ID --situation S --allow nvm [--select CASE] [--interrupt N | --kill N]
"""

import argparse
import collections
import logging
import multiprocessing
import sys

from judge import Bench, Trial
from lockstep import Lockstep
from matrix import SAMPLE, WHOLE, try_all
from situation import SITUATIONS


def arguments():
    parser = argparse.ArgumentParser(prog="as_found")
    parser.add_argument("--lockstep", required=True, help="the program with the simulated devices")
    parser.add_argument("--canvass", help="the program, for runs of real processes with --all")
    parser.add_argument("--models", default="conformance/device/models", help="the folder of their descriptions")
    parser.add_argument("--all", action="store_true", help="the whole matrix instead of a sample")
    parser.add_argument("--seed", default="1")
    parser.add_argument("--model", action="append", help="only this one")
    parser.add_argument("--situation", choices=SITUATIONS, help="with --allow: one trial, told in full")
    parser.add_argument("--allow", help="words with commas between them, all or none")
    parser.add_argument("--select", default="", help="cases with commas between them")
    parser.add_argument("--interrupt", type=int, help="Ctrl-C at this frame of the run")
    parser.add_argument("--kill", type=int, help="SIGKILL at this frame, then restore")
    return parser.parse_args()


def main():
    logging.disable(logging.ERROR)
    options = arguments()
    lockstep = Lockstep(options.lockstep)
    catalogue = lockstep.ask("catalogue")
    lockstep.close()
    if options.allow is not None:
        return one(options, catalogue)
    models = options.model or catalogue["models"]
    outcomes = matrix(options, catalogue, models)
    print(table(outcomes, models))
    bad = [outcome for outcome in outcomes if not outcome.is_good]
    print(findings(bad))
    print(f"{len(outcomes)} runs, {len(outcomes) - len(bad)} left the device as it was found, {len(bad)} did not (seed {options.seed})")
    return 1 if bad else 0


def one(options, catalogue):
    """A single trial, told in full."""
    words = {"all": catalogue["words"], "none": []}.get(options.allow, options.allow.split(","))
    select = tuple(filter(None, options.select.split(",")))
    trial = Trial(options.model[0], options.situation, tuple(words), options.allow, select, options.interrupt)
    with Bench(options.lockstep, options.models, trial.model, trial.situation) as bench:
        [outcome] = bench.kill(trial, [options.kill]) if options.kill else [bench.run(trial)]
    for key, value in outcome.told.items():
        if key not in ("cases", "closing", "sent"):
            print(f"{key}: {value}" if not isinstance(value, list) else f"{key}:" + "".join(f"\n  {line}" for line in value))
    for difference in outcome.named:
        print(f"differs, as the user was told: {difference}")
    for difference in outcome.differences:
        print(f"DIFFERS {difference}")
    for offence in outcome.offences:
        print(f"ACTS {offence}")
    print("as it was found" if outcome.is_good else "NOT as it was found")
    return 0 if outcome.is_good else 1


def matrix(options, catalogue, models):
    """All trials, on all processors."""
    situations = list(SITUATIONS)
    extent = WHOLE if options.all else SAMPLE
    jobs = []
    for number, model in enumerate(models):
        # A sample sees each situation on every third model.
        chosen = situations if options.all else [situations[(number + hash_of(options.seed)) % len(situations)]]
        jobs += [
            (options.lockstep, options.models, model, situation, catalogue, extent, options.seed) for situation in chosen
        ]
    with multiprocessing.Pool() as pool:
        return [outcome for outcomes in pool.imap(try_all, jobs, chunksize=1) for outcome in outcomes]


def hash_of(seed):
    return sum(seed.encode())


def table(outcomes, models):
    """Model and what was allowed: runs, how many left all as it was, what differed first."""
    rows = [("model", "allowed", "runs", "as found", "different", "claimed as found", "first difference")]
    cells = collections.defaultdict(list)
    for outcome in outcomes:
        cells[outcome.trial.model, outcome.trial.allowed, outcome.trial.end].append(outcome)
    for (model, allowed, end), tried in sorted(cells.items(), key=lambda cell: models.index(cell[0][0])):
        bad = [outcome for outcome in tried if not outcome.is_good]
        claimed = sum(outcome.claims is True for outcome in bad)
        first = str((bad[0].differences + bad[0].offences)[0])[:70] if bad else ""
        kind = allowed if end == "complete" else f"{allowed}, {end}"
        rows.append((model, kind, len(tried), len(tried) - len(bad), len(bad), claimed, first))
    widths = [max(len(str(row[column])) for row in rows) for column in range(len(rows[0]))]
    return "\n".join("| " + " | ".join(str(cell).ljust(width) for cell, width in zip(row, widths)) + " |" for row in rows)


def findings(bad):
    """The shortest trial of each kind of difference."""
    shortest = {}
    for outcome in bad:
        for what in [difference.kind for difference in outcome.differences] + outcome.offences:
            key = (outcome.trial.end, what)
            rank = (not outcome.trial.select, outcome.frames or outcome.trial.kill or 0)
            count, best = shortest.get(key, (0, None))
            if best is None or rank < best[0]:
                best = (rank, outcome)
            shortest[key] = (count + 1, best)
    lines = [
        f"{count:5} {end}: {what}\n        {best.trial.command()}"
        for (end, what), (count, (_, best)) in sorted(shortest.items(), key=lambda item: -item[1][0])
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
