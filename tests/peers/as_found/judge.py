"""Whether canvass leaves the device as it was found: what the user sees before and after, and what was sent meanwhile."""

import dataclasses
import re
import tempfile

from acting import COMMANDED, OWN, POSITION, offence
from lockstep import Lockstep, Network
from situation import COURSE, prepare
from subject import Silent, Subject


@dataclasses.dataclass(frozen=True)
class Trial:
    """A run of canvass on a device."""

    model: str
    situation: str
    allow: tuple
    allowed: str
    """The same in a word: none, all, or the words themselves."""
    select: tuple = ()
    interrupt: int | None = None
    """Ctrl-C at this frame."""
    kill: int | None = None
    """SIGKILL at this frame, then `canvass restore`."""

    @property
    def end(self):
        return "killed" if self.kill else "interrupted" if self.interrupt else "complete"

    def command(self):
        """What does it again."""
        words = ["--model", self.model, "--situation", self.situation, "--allow", self.allowed]
        words += ["--select", ",".join(self.select)] if self.select else []
        words += ["--interrupt", str(self.interrupt)] if self.interrupt else []
        words += ["--kill", str(self.kill)] if self.kill else []
        return "cargo xtask as-found " + " ".join(words)


@dataclasses.dataclass(frozen=True)
class Difference:
    """Something is not as it was."""

    when: str
    """`now`, or `power-on`: after the supply was off."""
    what: str
    at: tuple | None
    before: object
    after: object

    def __str__(self):
        told = lambda value: value.hex(" ") if isinstance(value, bytes) else str(value)
        return f"{self.when}: {self.what}: {told(self.before)} -> {told(self.after)}"

    @property
    def kind(self):
        return f"{self.when}: {self.what}"


@dataclasses.dataclass
class Outcome:
    """What became of a trial."""

    trial: Trial
    told: dict
    """What the run, or `restore`, has told."""
    differences: list
    offences: list
    """Writes of objects that act: sent to put the device back, or printed for the user to do so."""
    named: list = dataclasses.field(default_factory=list)
    """Differences that can't be put back, and that the user was told of."""
    frames: int = 0
    cases: list = dataclasses.field(default_factory=list)

    @property
    def claims(self):
        """Whether the user was told that all is as it was; None where nothing was told."""
        return self.told.get("is_as_found")

    @property
    def is_good(self):
        return not self.offences and not self.differences


class Bench:
    """One model in one situation, to which each trial goes back."""

    def __init__(self, program, models, model, situation):
        self.model, self.situation = model, situation
        self._lockstep = Lockstep(program)
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as course:
            course.write(COURSE)
            course.flush()
            device = self._lockstep.ask("device", address=f"sim:{model}~csv={course.name}")
        self._network = Network(self._lockstep)
        self._subject = Subject(self._network, device["node"], f"{models}/{model}.eds")
        self.settings = prepare(self._subject, model, situation)
        self._lockstep.ask("keep", name="found")
        self._found, self._stored = self._look()
        self._moving = self._moves_by_itself()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._network.bus.shutdown()
        self._lockstep.close()

    def run(self, trial):
        """A complete or interrupted run."""
        self._back("found")
        told = self._lockstep.ask(
            "run", allow=trial.allow, select=trial.select, interrupt=trial.interrupt, kill=[]
        )
        told["is_as_found"] = told.get("summary", {}).get("is_as_found", told.get("is_as_found"))
        outcome = self._judge(trial, told, told["closing"])
        outcome.frames, outcome.cases = told["frames"], told["cases"]
        return outcome

    def kill(self, trial, frames):
        """The run is killed at each of these frames, and the device is restored each time."""
        self._back("found")
        self._lockstep.ask("run", allow=trial.allow, select=trial.select, interrupt=None, kill=frames)
        for frame in frames:
            self._back(f"kill {frame}")
            self._network.hear(2)
            told = self._lockstep.ask("restore")
            if "failed" in told:
                # What the user does with a device that does not answer.
                self._power_cycle()
                told = self._lockstep.ask("restore") | {"after_power_cycle": True}
            yield self._judge(dataclasses.replace(trial, kill=frame), told, told["sent"])

    def _judge(self, trial, told, sent):
        try:
            found, stored = self._look()
        except Silent as silent:
            differences = [Difference("now", "the device does not answer", None, "answers", str(silent))]
        else:
            differences = self._compare("now", self._found, found) + self._compare("power-on", self._stored, stored)
        text = told.get("lines", []) + told.get("notices", [])
        named = [difference for difference in differences if is_named(difference, text, trial.end)]
        left = [difference for difference in differences if difference not in named]
        return Outcome(trial, told, left, self._offences(trial, told, sent), named)

    def _look(self):
        """What is there, and what is there after the supply was off."""
        found = self._subject.look()
        self._power_cycle()
        return found, self._subject.look()

    def _moves_by_itself(self):
        """What is another value after a while in which nobody did anything."""
        self._back("found")
        self._network.hear(90)
        found, stored = self._look()
        pairs = [(self._found, found), (self._stored, stored)]
        return {at for before, after in pairs for at in before.values if before.values[at] != after.values[at]}

    def _compare(self, when, before, after):
        differences = []
        if None not in (before.state, after.state) and before.state != after.state:
            differences.append(Difference(when, "NMT state", None, before.state, after.state))
        for at, value in before.values.items():
            if value != after.values[at] and at not in self._moving and at[0] not in OWN:
                what = f"{at[0]:04X}h:{at[1]:02X} {self._subject.description.get_variable(*at).name}"
                differences.append(Difference(when, what, at, value, after.values[at]))
        return differences

    def _offences(self, trial, told, sent):
        node = self._subject.node.id
        written = [write for frame in sent if (write := sdo_write(frame, node))]
        printed = [write for command in told.get("commands", ()) if (write := printed_write(command))]
        found = []
        for how, writes in [("sent", written), ("printed", printed)]:
            reasons = (offence(self.model, *write, trial.allow) for write in writes)
            found += [f"{how}: {reason}" for reason in reasons if reason]
        return sorted(set(found))

    def _power_cycle(self):
        self._lockstep.ask("power-cycle")
        self._network.hear(3)

    def _back(self, name):
        self._lockstep.ask("go-back", name=name)
        self._network.bus.forget()


def is_named(difference, text, end):
    """Whether that can't be put back, and the user was told of it."""
    index = difference.at[0] if difference.at else None
    if index in COMMANDED:
        # Another command would move the zero point once more.
        return any(f"{index:04X}h" in line for line in text)
    if end != "killed" or index not in POSITION:
        return False
    lines = [line for line in text if "zero point" in line.lower()]
    return any(abs(_moved(difference)) == int(number) for line in lines for number in re.findall(r"\d+", line))


def _moved(difference):
    number = lambda value: int.from_bytes(value, "little", signed=True)
    return number(difference.after) - number(difference.before)


def sdo_write(frame, node):
    """Index, sub-index and value of a download that this frame begins."""
    identifier, _, data = frame.partition("#")
    if int(identifier, 16) != 0x600 + node or data.startswith("R"):
        return None
    data = bytes.fromhex(data)
    is_download = data[0] & 0xE0 == 0x20 or data[0] & 0xE1 == 0xC0
    return (data[1] | data[2] << 8, data[3], data[4:8]) if is_download else None


PRINTED = re.compile(r"sdo write \S+ \d+ (?:0x)?([0-9A-Fa-f]{4})h?(?::([0-9A-Fa-f]{2}))? (\S+)")


def printed_write(command):
    """The same of a command that the user shall give."""
    match = PRINTED.search(command)
    if not match:
        return None
    index, sub, value = match.groups()
    is_bytes = re.fullmatch(r"(?:[0-9A-Fa-f]{2})+", value)
    return int(index, 16), int(sub or "0", 16), bytes.fromhex(value) if is_bytes else value.encode()
