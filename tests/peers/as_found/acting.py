"""What is done by a write, and what a device changes by itself. Both lists were reviewed against the manuals of the devices
and CiA 301, 302 and 406; they know nothing of how canvass puts a device back."""

ANY = ""

ACTING = {
    # index: (models, by the beginning of their id, and why a write of it is no setting)
    0x1003: (ANY, "writing 0 deletes the error history"),
    0x1010: (ANY, "a signature writes the non-volatile memory"),
    0x1011: (ANY, "a signature restores the factory defaults"),
    0x1013: (ANY, "writing it sets the device's clock"),
    0x1023: (ANY, "executes a command of the operating system"),
    0x1024: (ANY, "clears or aborts the commands of the operating system"),
    0x1025: (ANY, "executes a command of the debugger"),
    0x1F50: (ANY, "downloads a program"),
    0x1F51: (ANY, "starts, stops or clears a program"),
    0x1F82: (ANY, "requests an NMT command"),
    0x1F83: (ANY, "requests guarding"),
    0x6003: (ANY, "the position takes that value where the shaft is now"),
    0x6009: (ANY, "the position takes that value where the shaft is now"),
    0x600E: (ANY, "the position takes that value where the shaft is now"),
    0x6010: ("reference-406", "the position of a channel takes that value where the shaft is now"),
    0x2040: ("reference-301", "a command"),
    # Lika has limit switches at that index.
    0x2105: ("kuebler-sendix", "a signature stores node-ID, bit rate and termination"),
    0x3010: ("kuebler-", "the angle becomes 0 as the housing hangs now"),
}

SAVE = b"save"

OF_THE_BUS = {
    # Written, the device is not found any more after the next reset.
    "kuebler-sendix": (0x2100, 0x2101),
    "kuebler-c100": (0x3000, 0x3001),
    "kuebler-d125": (0x3000, 0x3001),
    "lika": (0x3000, 0x3001),
    "tr-": (0x100B,),
}

OWN = {
    0x1001: "the error register shows what happens",
    0x1002: "the status register shows what happens",
    0x1003: "the error history holds what happened",
    0x1013: "a clock",
    0x2020: "the clock of reference-301",
    0x2021: "the last emergency that reference-301 has received",
    0x2125: "measured: the voltage of the battery",
    0x2126: "measured: a temperature",
    0x2150: "measured: a temperature",
    0x6508: "a clock of operating hours",
}

POSITION = {
    0x6004: "position",
    0x6008: "position in high precision",
    0x6509: "offset",
    0x6020: "position of a draw-wire encoder",
    0x5000: "angle of a draw-wire encoder",
}


COMMANDED = {
    # These hold what was commanded last. It can't be given back to them without the command being carried out again.
    0x6003,
    0x6009,
    0x600E,
    0x6010,
    0x3010,
}


FOLLOWS_POSITION = {0x6300, 0x6400}
"""States that a device derives from its position: cams, work areas."""


def of_the_bus(model):
    return {index for prefix, indices in OF_THE_BUS.items() if model.startswith(prefix) for index in indices}


def why_acting(model, index):
    """Why a write of the object acts; None where it is a setting."""
    prefix, reason = ACTING.get(index, (None, None))
    return reason if prefix is not None and model.startswith(prefix) else None


def offence(model, index, sub, value, allowed):
    """Why nobody should have written that to put a device back; None where it may be written."""
    reason = why_acting(model, index)
    if reason and index == 0x1010 and value == SAVE and "nvm" in allowed:
        return None
    return reason and f"{index:04X}h:{sub:02X} is written: {reason}"
