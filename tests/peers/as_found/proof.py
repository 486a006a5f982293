"""The judge is proved: what is done to a device on purpose has to be seen, and nothing where nothing was done."""

from judge import NOW, POWER_ON
from stand import Stand
from trial import Trial

MODEL, SITUATION = "reference-406", "preset"
"""It has all that can be disturbed."""


def _heartbeat(stand, milliseconds=50):
    stand.subject.write(0x1017, 0, milliseconds.to_bytes(2, "little"))


def _preset_again(stand):
    stand.subject.write(0x6003, 0, stand.subject.read(0x6003, 0))


def _store(stand):
    stand.subject.node.store()
    stand.network.hear(1)


def _stored_heartbeat(stand):
    in_use = int.from_bytes(stand.subject.read(0x1017, 0), "little")
    _heartbeat(stand)
    stand.subject.node.store(2)
    stand.network.hear(1)
    _heartbeat(stand, in_use)


def _nothing(stand):
    stand.network.hear(20)


DISTURBANCES = [
    # (what is done, what has to be seen of it)
    (_nothing, set()),
    (_heartbeat, {(NOW, (0x1017, 0))}),
    (_preset_again, {(NOW, (0x6004, 0)), (NOW, (0x6509, 0))}),
    (_store, {(POWER_ON, (0x1017, 0)), (POWER_ON, (0x6004, 0))}),
    (_stored_heartbeat, {(POWER_ON, (0x1017, 0))}),
    (lambda stand: stand.subject.node.sdo.download(0x1011, 1, b"load"), {(POWER_ON, (0x6001, 0))}),
    (lambda stand: setattr(stand.subject.node.nmt, "state", "STOPPED"), {(NOW, None)}),
    (lambda stand: setattr(stand.subject.node.nmt, "state", "PRE-OPERATIONAL"), {(NOW, None)}),
    (lambda stand: setattr(stand.subject.node.nmt, "state", "RESET"), {(NOW, None), (NOW, (0x6004, 0))}),
]

FORBIDDEN = [
    # (a frame of the tester, a line for the user, what has to be complained of)
    ("67F#2303600000000000", "", "6003h"),
    ("67F#2110100104000000", "", "1010h"),
    ("67F#C2501F0104000000", "", "1F50h"),
    ("67F#4003600000000000", "", ""),
    ("", "  canvass sdo write can0 127 6003:00 BC020000 --type bytes", "6003h"),
    ("", "  canvass sdo write can0 127 1017:00 E803 --type bytes", ""),
]


def unseen(program, descriptions):
    """What the judge does not see, or sees where it is not."""
    trial = Trial(MODEL, SITUATION, (), "none")
    found = []
    with Stand(program, descriptions, MODEL, SITUATION) as stand:
        for disturb, expected in DISTURBANCES:
            stand.go_back()
            disturb(stand)
            outcome = stand.judge(trial, None, {}, [])
            seen = {(difference.when, difference.at) for difference in outcome.differences}
            if not expected <= seen or bool(expected) != bool(seen):
                found.append(f"{disturb.__name__}: expected {sorted(expected, key=str)}, saw {sorted(seen, key=str)}")
        node_id = stand.subject.node.id
        for frame, line, expected in FORBIDDEN:
            stand.go_back()
            sent = [frame.replace("67F", f"{0x600 + node_id:03X}")] if frame else []
            offences = stand.judge(trial, None, {"lines": [line]}, sent).offences
            if bool(expected) != bool(offences) or not all(expected in offence for offence in offences):
                found.append(f"{frame}{line}: expected a complaint of {expected or 'nothing'}, got {offences}")
    return found
