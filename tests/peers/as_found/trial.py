"""A run of canvass on a device, and what became of it."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Trial:
    """A run of canvass on a device."""

    model: str
    situation: str
    allow: tuple
    allowed: str
    """The same in a word: none, all, or the words themselves."""
    select: tuple = ()
    """The cases; without one: all."""
    interrupt: int | None = None
    """Ctrl-C at this frame."""
    kill: int | None = None
    """SIGKILL at this frame, then `canvass restore`."""
    seconds: float | None = None
    """SIGKILL of a process this long after its first case began, then `canvass restore`."""

    @property
    def end(self):
        if self.seconds is not None:
            return "killed process"
        return "killed" if self.kill else "interrupted" if self.interrupt else "complete"

    def command(self):
        """What does it again."""
        words = ["--model", self.model, "--situation", self.situation, "--allow", self.allowed]
        for option, value in [("--interrupt", self.interrupt), ("--kill", self.kill), ("--seconds", self.seconds)]:
            words += [option, str(value)] if value else []
        words += ["--select", ",".join(self.select)] if self.select else []
        return "cargo xtask as-found " + " ".join(words)


@dataclasses.dataclass(frozen=True)
class Difference:
    """Something is not as it was."""

    when: str
    """`now`, or `power-on`: after the supply was off."""
    what: str
    at: tuple | None
    """Index and sub-index, where it is an object."""
    before: object
    after: object

    @property
    def kind(self):
        return f"{self.when}: {self.what}"

    def __str__(self):
        return f"{self.kind}: {_shown(self.before)} -> {_shown(self.after)}"


def _shown(value):
    return value.hex(" ") if isinstance(value, bytes) else str(value)


@dataclasses.dataclass
class Outcome:
    """What became of a trial."""

    trial: Trial
    claims: bool | None
    """Whether the user was told that all is as it was; None where nothing was told."""
    text: list
    """What the user was told."""
    differences: list
    named: list
    """Differences that can't be put back, and that the user was told of."""
    offences: list
    """Writes of objects that act: sent to put the device back, or printed for the user to do so."""
    began: bool = True
    """Whether a case began: a device that could not be put back is not tested."""
    frames: int = 0
    """How many the run took."""
    cases: list = dataclasses.field(default_factory=list)
    """Of each case: id, the number of the frame before it and of its last one, verdict."""

    @property
    def is_good(self):
        return not self.offences and not self.differences

    @property
    def complaints(self):
        return [str(difference) for difference in self.differences] + self.offences
