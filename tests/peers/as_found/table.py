"""What the trials found, in lines."""

import collections

HEADING = ("model", "allowed", "runs", "not begun", "as found", "different", "claimed as found", "what differed first")
WIDTH = 64


def table(outcomes, models):
    """A row for each model, what was allowed, and how the runs ended."""
    cells = collections.defaultdict(list)
    for outcome in outcomes:
        cells[outcome.trial.model, outcome.trial.allowed, outcome.trial.end].append(outcome)
    rows = [_row(*cell, tried) for cell, tried in sorted(cells.items(), key=lambda item: models.index(item[0][0]))]
    widths = [max(len(row[column]) for row in [HEADING, *rows]) for column in range(len(HEADING))]
    return "\n".join(
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |"
        for row in [HEADING, ["-" * width for width in widths], *rows]
    )


def _row(model, allowed, end, tried):
    bad = [outcome for outcome in tried if not outcome.is_good]
    kind = allowed if end == "complete" else f"{allowed}, {end}"
    claimed = sum(outcome.claims is True for outcome in bad)
    idle = sum(not outcome.began for outcome in tried)
    first = bad[0].complaints[0][:WIDTH] if bad else ""
    return [model, kind, *(str(count) for count in (len(tried), idle, len(tried) - len(bad), len(bad), claimed)), first]


def shortest(outcomes):
    """Of each kind of difference how often it was found, and the shortest trial that shows it."""
    found = collections.defaultdict(list)
    for outcome in outcomes:
        for kind in [difference.kind for difference in outcome.differences] + outcome.offences:
            found[outcome.trial.end, kind].append(outcome)
    lines = []
    for (end, kind), shown in sorted(found.items(), key=lambda item: -len(item[1])):
        least = min(shown, key=lambda outcome: (not outcome.trial.select, outcome.frames or outcome.trial.kill or 0))
        lines.append(f"{len(shown):5} {end}: {kind}\n      {least.trial.command()}")
    return "\n".join(lines)


def in_full(outcome):
    """One trial: what the user was told, and what the judge found."""
    verdicts = collections.Counter(verdict for *_, verdict in outcome.cases)
    lines = [f"{count} {verdict}" for verdict, count in verdicts.items()]
    lines += [f"told: {line}" for line in outcome.text]
    lines += [f"differs, as the user was told: {difference}" for difference in outcome.named]
    lines += [f"DIFFERS {complaint}" for complaint in outcome.complaints]
    claim = {True: "as it was found", False: "not as it was found", None: "nothing"}[outcome.claims]
    lines.append(f"claimed: {claim}; judged: {'as it was found' if outcome.is_good else 'NOT as it was found'}")
    return "\n".join(lines)
