"""Decodes frames by a CAN database with cantools, for the tests of the peers.

    signals.py DBC      frames as ID#DATA on standard input, ID of eight digits for 29 bits

prints for each frame a JSON object: sender, and signals as a list of [name, value, unit, comment].
"""
import json
import sys

import cantools

database = cantools.database.load_file(sys.argv[1], strict=True)
for line in sys.stdin:
    ident, data = line.split("#")
    message = next(m for m in database.messages
                   if m.frame_id == int(ident, 16) and m.is_extended_frame == (len(ident) == 8))
    values = message.decode(bytes.fromhex(data))
    signals = [[s.name, float(values[s.name]), s.unit or "", s.comment] for s in message.signals]
    print(json.dumps({"name": message.name, "senders": message.senders, "length": message.length, "signals": signals}))
