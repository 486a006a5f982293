"""Which trials there are of a model in a situation, and how they are counted."""

import dataclasses
import random

from situation import SITUATIONS, situations_of
from stand import Stand
from trial import Trial

RAN = {"pass", "tolerated", "deviation", "fail", "inconclusive", "error"}
"""Verdicts of cases that did something to the device."""


@dataclasses.dataclass(frozen=True)
class Extent:
    """How much of the matrix is tried."""

    alone: int | None
    """Cases that touch something, by themselves; None: all of them."""
    interrupts: int
    """Ctrl-C in each of these."""
    kills: int
    others: bool
    """Whether the cases that touch nothing run by themselves, too, each in one of the situations."""


WHOLE = Extent(alone=None, interrupts=3, kills=13, others=True)
"""Of each situation of a model."""
SAMPLE = Extent(alone=6, interrupts=1, kills=6, others=False)


def allowances(words):
    """Nothing, each word, all of them."""
    return [(), *((word,) for word in words), tuple(words)]


def name_of(allow, words):
    return "none" if not allow else "all" if len(allow) == len(words) else ",".join(allow)


class Matrix:
    """The trials of one model in one situation."""

    def __init__(self, stand, catalogue, extent, seed):
        self._stand, self._extent = stand, extent
        self._words = tuple(catalogue["words"])
        self._touches = {case["id"]: set(case["touches"]) for case in catalogue["cases"]}
        self._dice = random.Random(f"{seed} {stand.model} {stand.situation}")

    def outcomes(self):
        for allow in allowances(self._words):
            whole = self._run(allow)
            yield whole
        # The last one was allowed everything.
        ran = {case: (begin, end) for case, begin, end, verdict in whole.cases if verdict in RAN}
        acting = [case for case in ran if self._touches[case]]
        if self._extent.alone is not None:
            acting = self._dice.sample(acting, min(self._extent.alone, len(acting)))
        for case in acting:
            yield from self._alone(case)
        for case in self._others(ran) if self._extent.others else ():
            yield from self._with_interrupts((), case)
        moments = self._moments(whole.frames, [ran[case] for case in acting])
        yield from self._stand.kill(self._trial(self._words), moments)

    def _trial(self, allow, *select):
        return Trial(self._stand.model, self._stand.situation, allow, name_of(allow, self._words), select)

    def _run(self, allow, *select):
        return self._stand.run(self._trial(allow, *select))

    def _others(self, ran):
        """This situation's share of the cases that touch nothing. None where runs do not begin, and none where the shaft turns:
        to wait until it is at rest takes time."""
        kinds = {name: SITUATIONS[name] for name in situations_of(self._stand.model)}
        sharing = [name for name, each in kinds.items() if not each.turns and not each.has_zero_point]
        # What begins only with its profile as delivered has all of them there.
        sharing = [name for name in sharing if not kinds[name].has_profile] or sharing
        if self._stand.situation not in sharing:
            return []
        others = [case for case in ran if not self._touches[case]]
        return others[sharing.index(self._stand.situation) :: len(sharing)]

    def _alone(self, case):
        for allow in allowances(self._words):
            if self._touches[case] <= set(allow) and allow != self._words:
                yield self._run(allow, case)
        yield from self._with_interrupts(self._words, case)

    def _with_interrupts(self, allow, case):
        complete = self._run(allow, case)
        yield complete
        _, begin, end, _ = complete.cases[-1] if complete.cases else (case, 0, complete.frames, "")
        if end > begin + 1:
            for frame in self._draw(begin + 1, end, self._extent.interrupts):
                yield self._stand.run(dataclasses.replace(self._trial(allow, case), interrupt=frame))

    def _draw(self, first, last, count):
        return sorted(self._dice.sample(range(first, last + 1), min(count, last + 1 - first)))

    def _moments(self, frames, spans):
        """Half anywhere in the run, half in cases that touch something: those are short, and hard to come back from."""
        inside = [self._dice.randint(begin + 1, max(begin + 1, end)) for begin, end in self._pick(spans)]
        anywhere = self._draw(1, frames, self._extent.kills - len(inside))
        return sorted(set(inside + anywhere))

    def _pick(self, spans):
        return self._dice.sample(spans, min(self._extent.kills // 2, len(spans)))


def try_all(job):
    """One job of a pool: the outcomes of a model in a situation."""
    program, descriptions, model, situation, catalogue, extent, seed = job
    with Stand(program, descriptions, model, situation) as stand:
        return list(Matrix(stand, catalogue, extent, seed).outcomes())
