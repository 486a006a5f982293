"""How the user has set up the device before canvass comes."""

import dataclasses
import itertools

from canopen.objectdictionary import datatypes

from acting import of_the_bus, why_acting


@dataclasses.dataclass(frozen=True)
class Situation:
    """What the user did before."""

    is_stored: bool
    """Values were given to all settings and a preset, and stored."""
    is_working: bool
    """Other values were given to them later, and not stored."""
    state: str | None
    """The NMT state that was commanded."""
    has_profile: bool = True
    """Objects of the profile and the manufacturer are among the settings, not only those of the communication."""
    is_scaled: bool = True
    """The scaling is among them."""
    has_zero_point: bool = False
    """A preset was given after that: the first reset would lose the zero point."""
    has_switch: bool = False
    """The user gives canvass a command that switches the supply of the device."""
    turns: bool = False
    """The shaft turns slowly while canvass is there."""

    @property
    def zero_point_is_stored(self):
        """What the user says to canvass."""
        return self.is_stored and not self.has_zero_point

    @property
    def rests_at(self):
        """The second after power-on from which on the shaft is at rest for ever."""
        return TURNED if self.turns else MOVED


OPERATIONAL = "OPERATIONAL"
SITUATIONS = {
    "working": Situation(is_stored=False, is_working=True, state=None, is_scaled=False),
    "stored": Situation(is_stored=True, is_working=False, state=OPERATIONAL),
    "both": Situation(is_stored=True, is_working=True, state=OPERATIONAL, has_switch=True),
    "preset": Situation(is_stored=True, is_working=True, state=OPERATIONAL, has_zero_point=True),
    "turning": Situation(is_stored=True, is_working=True, state=None, has_switch=True, turns=True),
    "communication": Situation(is_stored=True, is_working=True, state=OPERATIONAL, has_profile=False),
}

FORGETFUL = {
    "tr-c65": "reset node sets its profile to defaults, whatever is stored: set up otherwise, it is not tested",
    "tr-lmp30": "as tr-c65",
}
"""Models on which a run begins only if their profile is as delivered, and why."""


def situations_of(model):
    """The situations of a model; in the one without profile only models that need it."""
    return [name for name, situation in SITUATIONS.items() if situation.has_profile or model in FORGETFUL]


MOVES, MOVED = 25, 27
"""Seconds after power-on: the device is set up before, and the run comes after."""

TURNED = 1_500
"""When a shaft that turns during the run is at rest: no run takes longer."""

BEGIN, END = 0.6, 0.97
"""Where the shaft is before and after, in revolutions or millimetres: a preset that is written again is then another one."""


def course(name):
    """The motion of the shaft: seconds, and revolutions or millimetres."""
    points = [(0, BEGIN), (MOVES, BEGIN), (MOVED, END)]
    if SITUATIONS[name].turns:
        points += [(MOVED + 1, END), (TURNED, END + 0.05)]
    return _lines(points)


def turned():
    """The motion of a shaft that has turned before its device was switched on."""
    return _lines([(0, END), (1, END)])


def _lines(points):
    return "".join(f"{seconds}, {position}\n" for seconds, position in points)


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
    (0x1800, 3): Pair(40, 30),
    (0x1800, 5): Pair(700, 500),
    (0x1801, 2): Pair(3, 5),
    (0x1802, 2): Pair(4, 6),
    (0x1802, 3): Pair(20, 10),
    (0x6200, 0): Pair(400, 300),
    (0x1020, 1): Pair(0x3000, 0x2FFF),
    (0x1020, 2): Pair(0x5000, 0x4FFF),
}

MAPPING = 2
"""The TPDO whose mapping is changed, by its number from 1."""

SCALING = (0x6000, 0x6001, 0x6002)
PRESETS = {0x6003: Pair(1_500, 700), 0x3010: Pair(1, 1)}


LEAST = 3
"""With fewer settings nothing would show."""


class Unfit(Exception):
    """The device took too little of what was written: nothing would show."""


def prepare(subject, model, name):
    """Sets the device up and lets the shaft turn."""
    situation = SITUATIONS[name]
    began = subject.network.now()
    subject.network.hear(3)
    taken = 0
    if situation.is_stored:
        taken += _write_all(subject, model, lambda pair: pair.stored, situation, situation.has_profile)
        subject.node.store()
        subject.network.hear(4)
    if situation.is_working:
        taken += _write_all(subject, model, lambda pair: pair.working, situation, situation.has_zero_point)
    if taken < LEAST:
        raise Unfit(f"{model} took only {taken} settings")
    if subject.network.now() - began >= MOVES:
        raise Unfit(f"{model} was not set up before its shaft began to turn")
    if situation.state:
        subject.node.nmt.state = situation.state
    subject.network.hear(MOVED + 1 - (subject.network.now() - began))


def _write_all(subject, model, of, situation, has_zero_point):
    """Gives each setting the one or the other value; how many the device took."""
    settings = [(at, of(pair)) for at, pair in _settings(subject, model) if situation.has_profile or at[0] < 0x2000]
    written = [(at, value) for at, value in settings if situation.is_scaled or at[0] not in SCALING]
    taken = sum(subject.write(*at, subject.encode(at, value)) for at, value in written)
    taken += _map(subject, of(Pair(-1, -2)))
    presets = [(index, of(pair)) for index, pair in PRESETS.items() if why_acting(model, index)]
    for index, value in presets if has_zero_point else []:
        if index in subject.description:
            taken += subject.write(index, 0, subject.encode((index, 0), value))
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
        at
        for at, var in known.items()
        if at[0] >= 0x2000 and var.pdo_mappable and var.readable and len(var) in (8, 16, 32)
    ]
    at = mappable[which % len(mappable)]
    cob_id = subject.read(communication, 1)
    off = bytes(cob_id[:3]) + bytes([cob_id[3] | 0x80])
    entry = subject.encode((mapping, 1), at[0] << 16 | at[1] << 8 | len(known[at]))
    steps = [
        (communication, 1, off),
        (mapping, 0, b"\0"),
        (mapping, 1, entry),
        (mapping, 0, b"\1"),
        (communication, 1, cob_id),
    ]
    return all([subject.write(*step) for step in steps])
