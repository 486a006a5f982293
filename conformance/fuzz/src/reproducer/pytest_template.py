"""@property@: @title@ (@rule@).

Expected: @expected@
Clause: @clause@
Found: @actual@
@start@
By canvass @version@ with seed @seed@. Needs the packages pytest and canopen. The bus is that of python-can's
configuration: its file, or CAN_INTERFACE, CAN_CHANNEL and CAN_BITRATE in the environment.
"""

import time

import can
import canopen
import pytest

NODE = @node@
PATIENCE = @patience@  # seconds after the last frame of the sequence


def frame(can_id, data="", extended=False, remote=None):
    return can.Message(
        arbitration_id=can_id,
        is_extended_id=extended,
        data=None if remote is not None else bytes.fromhex(data),
        is_remote_frame=remote is not None,
        dlc=remote,
    )


# Each frame with its time in seconds.
PRELUDE = [@before@]
PRELUDE_TIME = @begin@
SEQUENCE = [@sequence@]


class Heard(can.Listener):
    """The frames of the other nodes."""

    def __init__(self):
        self.frames = []

    def on_message_received(self, msg):
        if msg.is_rx:
            self.frames.append((time.monotonic(), msg))

    def since(self, begun, can_id):
        return [(at, msg) for at, msg in self.frames if at > begun and msg.arbitration_id == can_id]


class Device:
    """The device on its bus."""

    def __init__(self, network, heard):
        self.network, self.heard = network, heard

    def play(self, frames, length):
        """Sends the frames at their times. Returns the time of the last one."""
        begun = last = time.monotonic()
        for at, message in frames:
            time.sleep(max(0, begun + at - time.monotonic()))
            last = time.monotonic()
            self.network.bus.send(message)
        time.sleep(max(0, begun + length - time.monotonic()))
        return last

    def reset(self):
        """Resets the node. Returns whether it starts within ten seconds."""
        begun = time.monotonic()
        self.network[NODE].nmt.send_command(0x81)
        while time.monotonic() < begun + 10:
            if any(bytes(msg.data) == b"\0" for _, msg in self.heard.since(begun, 0x700 + NODE)):
                return True
            time.sleep(0.005)
        return False


@pytest.fixture
def device():
    heard, network = Heard(), canopen.Network()
    network.listeners.append(heard)
    network.connect()
    network.add_node(canopen.RemoteNode(NODE, canopen.ObjectDictionary()))
    yield Device(network, heard)
    network.disconnect()


def test_@name@(device):
@begins@    begun = time.monotonic()
    last = device.play(SEQUENCE, @until@ + PATIENCE)
@assertion@