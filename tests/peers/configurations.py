"""python-canopen reads a DCF, or writes it to a device.

values FILE NODE            prints INDEX:SUB BYTES for every configured value
write FILE NODE CHANNEL     writes the configuration to the device on an SLCAN port
"""

import sys

import canopen


def entries(dictionary):
    for obj in dictionary.values():
        yield from obj.values() if hasattr(obj, "values") else [obj]


def values(file, node):
    for entry in entries(canopen.import_od(file, node_id=int(node))):
        if entry.value is not None:
            print(f"{entry.index:04X}:{entry.subindex:02X} {entry.encode_raw(entry.value).hex().upper()}")


def write(file, node, channel):
    network = canopen.Network()
    network.connect(interface="slcan", channel=channel, bitrate=250000)
    try:
        remote = network.add_node(int(node), file)
        remote.sdo.RESPONSE_TIMEOUT = 2
        remote.load_configuration()
    finally:
        network.disconnect()


if __name__ == "__main__":
    {"values": values, "write": write}[sys.argv[1]](*sys.argv[2:])
