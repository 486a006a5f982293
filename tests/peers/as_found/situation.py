"""How the user has set up the device before canvass comes."""

import dataclasses
import itertools

from canopen.objectdictionary import datatypes

from acting import of_the_bus, why_acting

REVOLUTIONS = 0.37
"""How far the shaft turns after the presets and before the run: a preset that is written again is then another one."""

MOVES = 60
"""Seconds after power-on at which it turns; after that it is at rest for ever."""

COURSE = f"""# seconds, revolutions or millimetres
0, 0.6
{MOVES}, 0.6
{MOVES + 5}, {0.6 + REVOLUTIONS}
"""

SITUATIONS = {
    # name: (is something stored, are there working values beside, NMT state)
    "working": (False, True, None),
    "stored": (True, False, "OPERATIONAL"),
    "both": (True, True, "OPERATIONAL"),
}


@dataclasses.dataclass(frozen=True)
class Pair:
    """The value of a setting that is stored, and the one that is in use without being stored."""

    stored: int
    working: int


CHOSEN = {
    # Before others, in this order: what the device compares other values with.
    (0x6000, 0): Pair(4, 5),
    (0x6002, 0): Pair(2048 * 8, 1000 * 8),
    (0x6001, 0): Pair(2048, 1000),
    (0x1006, 0): Pair(30_000, 20_000),
    (0x1015, 0): Pair(20, 10),
    (0x1016, 1): Pair(0x650320, 0x6504B0),
    (0x1017, 0): Pair(2_000, 1_000),
    (0x1029, 1): Pair(1, 2),
    (0x1029, 2): Pair(0, 2),
    (0x100C, 0): Pair(600, 500),
    (0x1800, 5): Pair(700, 500),
    (0x1801, 2): Pair(3, 5),
    (0x1802, 2): Pair(4, 6),
    (0x6200, 0): Pair(400, 300),
    (0x1020, 1): Pair(0x3000, 0x2FFF),
    (0x1020, 2): Pair(0x5000, 0x4FFF),
}

MAPPING = 2
"""The TPDO whose mapping is changed, by its number from 1."""

PRESETS = {0x6003: Pair(1_500, 700), 0x3010: Pair(1, 1)}


class Unfit(Exception):
    """The device took too little of what was written: nothing would show."""


def prepare(subject, model, name):
    """Sets the device up; gives how many settings it took."""
    is_stored, is_working, state = SITUATIONS[name]
    subject.network.hear(3)
    taken = 0
    if is_stored:
        taken += _write_all(subject, model, lambda pair: pair.stored)
        subject.node.store()
        subject.network.hear(4)
    if is_working:
        taken += _write_all(subject, model, lambda pair: pair.working)
    if taken < 4:
        raise Unfit(f"{model} took only {taken} settings")
    subject.network.hear(MOVES + 10)
    if state:
        subject.node.nmt.state = state
    return taken


def _write_all(subject, model, of):
    taken = sum(subject.write(*at, subject.encode(at, of(pair))) for at, pair in _settings(subject, model))
    taken += _map(subject, of(Pair(-1, -2)))
    taken += sum(
        subject.write(index, 0, subject.encode((index, 0), of(pair)))
        for index, pair in PRESETS.items()
        if index in subject.description and why_acting(model, index)
    )
    return taken


def _settings(subject, model):
    """The chosen ones, and every other of manufacturer and profile that is no command and does not take the device away."""
    known = {(var.index, var.subindex): var for var in subject.variables() if var.readable and var.writable}
    chosen = {at: pair for at, pair in CHOSEN.items() if at in known}
    left_out = of_the_bus(model)
    others = {
        at: pair
        for at, var in known.items()
        if at[0] >= 0x2000 and at not in chosen and at[0] not in left_out and not why_acting(model, at[0])
        if (pair := _other_values(subject, var)) is not None
    }
    return itertools.chain(chosen.items(), others.items())


def _other_values(subject, var):
    """Two more values of a setting, near the one that it has as delivered."""
    if var.data_type in datatypes.INTEGER_TYPES:
        low = var.min if var.min is not None else 0
        delivered = var.default if isinstance(var.default, int) else low
        high = var.max if var.max is not None else max(delivered, 1)
        near = [value for value in (delivered + 1, delivered + 2, delivered - 1, delivered - 2) if low <= value <= high]
        return Pair(*(near * 2)[:2]) if near else None
    if var.data_type in datatypes.FLOAT_TYPES:
        return Pair(1.5, 2.5)
    if var.data_type in (datatypes.VISIBLE_STRING, datatypes.OCTET_STRING, datatypes.DOMAIN):
        return Pair(b"north", b"south")
    return None


def _map(subject, which):
    """Maps another object into a TPDO, as CiA 301 says: -1 the first, -2 the second of those that can be mapped."""
    communication, mapping = 0x1800 + MAPPING - 1, 0x1A00 + MAPPING - 1
    known = {(var.index, var.subindex): var for var in subject.variables()}
    if not all((at in known and known[at].writable) for at in [(communication, 1), (mapping, 0), (mapping, 1)]):
        return False
    mappable = [
        at for at, var in known.items() if at[0] >= 0x2000 and var.pdo_mappable and var.readable and len(var) in (8, 16, 32)
    ]
    at = mappable[which % len(mappable)]
    cob_id = subject.read(communication, 1)
    off = bytes(cob_id[:3]) + bytes([cob_id[3] | 0x80])
    entry = subject.encode((mapping, 1), at[0] << 16 | at[1] << 8 | len(known[at]))
    steps = [(communication, 1, off), (mapping, 0, b"\0"), (mapping, 1, entry), (mapping, 0, b"\1"), (communication, 1, cob_id)]
    return all([subject.write(*step) for step in steps])
