"""The judgement: what the user sees before and after, what was sent to put the device back, and what the user was told."""

import re

from acting import COMMANDED, FOLLOWS_POSITION, OWN, POSITION, offence
from trial import Difference, Outcome

NOW, POWER_ON = "now", "power-on"

WHOLE_32_BITS = 1 << 32
"""What the value 0 of 6002h stands for."""


class Judge:
    """Knows how the device was found."""

    def __init__(self, model, node_id, description, found, later):
        """`found` and `later` are pairs of snapshots, of the device in use and after power-on: between the two pairs nobody
        did anything. What differs moves by itself."""
        self._model, self._node_id, self._description = model, node_id, description
        self._found = dict(zip((NOW, POWER_ON), found))
        self._moving = {
            at for one, other in zip(found, later) for at in one.values if one.values[at] != other.values[at]
        }

    def outcome(self, trial, claims, text, seen, sent, **more):
        """`seen` is a pair as before, or says why the device does not answer; `sent` are the tester's frames."""
        if isinstance(seen, str):
            differences = [Difference(NOW, "the device does not answer", None, "answers", seen)]
        else:
            differences = [difference for pair in zip((NOW, POWER_ON), seen) for difference in self._compare(*pair)]
        named = named_of(differences, text, trial)
        left = [difference for difference in differences if difference not in named]
        return Outcome(trial, claims, text, left, named, self._offences(trial, text, sent), **more)

    def _compare(self, when, after):
        before = self._found[when]
        if None not in (before.state, after.state) and before.state != after.state:
            yield Difference(when, "NMT state", None, before.state, after.state)
        for at, value in before.values.items():
            if value == after.values[at] or at in self._moving or at[0] in OWN or is_same_offset(at, before, after):
                continue
            what = f"{at[0]:04X}h:{at[1]:02X} {self._description.get_variable(*at).name}"
            yield Difference(when, what, at, value, after.values[at])

    def _offences(self, trial, text, sent):
        written = [("sent", write) for frame in sent if (write := sdo_write(frame, self._node_id))]
        printed = [("printed", write) for line in text if (write := printed_write(line))]
        found = {
            f"{how}: {reason}"
            for how, write in written + printed
            if (reason := offence(self._model, *write, trial.allow))
        }
        return sorted(found)


def is_same_offset(at, before, after):
    """6509h counts as the same if it moved by whole measuring ranges: the position is the same then."""
    if at != (0x6509, 0) or before.values.get((0x6004, 0)) != after.values.get((0x6004, 0)):
        return False
    moved = abs(_number(after.values[at]) - _number(before.values[at]))
    number = lambda index: _number(before.values.get((index, 0), b""), signed=False)
    ranges = (number(0x6002) or WHOLE_32_BITS, number(0x6501) * number(0x6502))
    return any(moved % whole == 0 for whole in ranges if whole)


def named_of(differences, text, trial):
    """Those that can't be put back and that the user was told of, with what follows from them."""
    named = [difference for difference in differences if is_named(difference, text, trial)]
    moved = {difference.when for difference in named if difference.at[0] in POSITION}
    follows = lambda difference: difference.at and difference.at[0] in FOLLOWS_POSITION and difference.when in moved
    return named + [difference for difference in differences if follows(difference)]


def is_named(difference, text, trial):
    """Whether that can't be put back, and the user was told of it."""
    index = difference.at[0] if difference.at else None
    if index in COMMANDED:
        # To give it back would carry it out once more, and move the zero point.
        return any(f"{index:04X}h" in line for line in text)
    if not trial.end.startswith("killed") or index not in POSITION:
        return False
    moved = abs(_number(difference.after) - _number(difference.before))
    lines = [line for line in text if "zero point" in line.lower()]
    return any(moved == int(number) for line in lines for number in re.findall(r"\d+", line))


def _number(value, signed=True):
    return int.from_bytes(value, "little", signed=signed) if isinstance(value, bytes) else 0


def sdo_write(frame, node_id):
    """Index, sub-index and value of the download that this frame begins, if it does."""
    identifier, _, data = frame.partition("#")
    if int(identifier, 16) != 0x600 + node_id or data.startswith("R"):
        return None
    data = bytes.fromhex(data)
    is_download = data[0] & 0xE0 == 0x20 or data[0] & 0xE1 == 0xC0
    return (data[1] | data[2] << 8, data[3], data[4:8]) if is_download else None


PRINTED = re.compile(r"sdo write \S+ \d+ (?:0x)?([0-9A-Fa-f]{4})h?(?::([0-9A-Fa-f]{2}))? (\S+)")


def printed_write(line):
    """The same of a command that the user shall give."""
    match = PRINTED.search(line)
    if not match:
        return None
    index, sub, value = match.groups()
    is_bytes = re.fullmatch(r"(?:[0-9A-Fa-f]{2})+", value)
    return int(index, 16), int(sub or "0", 16), bytes.fromhex(value) if is_bytes else value.encode()
