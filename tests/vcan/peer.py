"""python canopen and python-can beside canvass; tests/vcan runs it."""

import logging
import os
import pty
import select
import sys
import threading
import time
import tty

import can
import canopen
from canopen import objectdictionary as od

logging.basicConfig(level=logging.ERROR)


def good(what, condition, found=""):
    print(f"{what} {'good' if condition else f'WRONG: {found}'}", flush=True)


def master(interface, eds):
    """Everything a master does with an encoder at node 63."""
    network = canopen.Network()
    network.connect(channel=interface, interface="socketcan")
    node = network.add_node(63, eds)
    node.sdo.RESPONSE_TIMEOUT = 3
    network.check()
    device_type = int.from_bytes(node.sdo.upload(0x1000, 0), "little")
    good("expedited", device_type == 0x00020196, hex(device_type))
    name = node.sdo.upload(0x1008, 0)
    good("segmented", name == b"Kuebler Sendix Encoder", name)
    try:
        node.sdo.upload(0x5000, 0)
        good("abort", False, "no abort")
    except canopen.SdoAbortedError as error:
        good("abort", error.code == 0x06020000, error)
    node.nmt.state = "OPERATIONAL"
    node.sdo.download(0x1017, 0, (100).to_bytes(2, "little"))
    state = node.nmt.wait_for_heartbeat(timeout=5)
    good("heartbeat", state == "OPERATIONAL", state)
    node.sdo.download(0x1017, 0, bytes(2))
    seen = threading.Event()
    network.subscribe(0x1BF, lambda *_: seen.set())
    node.sdo.download(0x1800, 5, (50).to_bytes(2, "little"))
    good("pdo", seen.wait(5), "no TPDO 1")
    node.nmt.state = "RESET"
    node.nmt.wait_for_bootup(timeout=10)
    good("nmt", True)
    network.lss.RESPONSE_TIMEOUT = 2
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    vendor = network.lss.inquire_lss_address(canopen.lss.CS_INQUIRE_VENDOR_ID)
    node_id = network.lss.inquire_node_id()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    good("lss", (vendor, node_id) == (0x13, 63), (vendor, node_id))
    network.disconnect()


def device(interface):
    """A LocalNode with a small dictionary, as node 5."""
    dictionary = od.ObjectDictionary()

    def variable(index, sub, name, data_type, access, value, parent=None):
        entry = od.ODVariable(name, index, sub)
        entry.data_type, entry.access_type, entry.default, entry.value = data_type, access, value, value
        # A record without entries counts as false.
        dictionary.add_object(entry) if parent is None else parent.add_member(entry)

    variable(0x1000, 0, "Device type", od.UNSIGNED32, "ro", 0)
    variable(0x1001, 0, "Error register", od.UNSIGNED8, "ro", 0)
    variable(0x1008, 0, "Manufacturer device name", od.VISIBLE_STRING, "ro", "python canopen LocalNode")
    variable(0x1017, 0, "Producer heartbeat time", od.UNSIGNED16, "rw", 0)
    identity = od.ODRecord("Identity object", 0x1018)
    for sub, name, value in [(0, "Highest sub-index", 4), (1, "Vendor-ID", 0), (2, "Product code", 1),
                             (3, "Revision number", 1), (4, "Serial number", 1)]:
        variable(0x1018, sub, name, od.UNSIGNED8 if sub == 0 else od.UNSIGNED32, "ro", value, identity)
    dictionary.add_object(identity)
    network = canopen.Network()
    network.connect(channel=interface, interface="slcan" if "/" in interface else "socketcan")
    node = canopen.LocalNode(5, dictionary)
    network.add_node(node)

    def restart(_, data, __):
        # Without this it does not boot after a reset: see docs/peers.md.
        if data[0] in (129, 130) and data[1] in (0, 5):
            node.sdo[0x1017].raw = 0
            node.nmt.state = "INITIALISING"
            node.nmt.state = "PRE-OPERATIONAL"

    network.subscribe(0, restart)
    node.nmt.state = "INITIALISING"
    node.nmt.state = "PRE-OPERATIONAL"
    print("ready", file=sys.stderr, flush=True)
    while True:
        time.sleep(1)


def slcan(port):
    """Asks node 63 for its device type through an SLCAN adapter."""
    bus = can.Bus(interface="slcan", channel=port, bitrate=250000)
    bus.send(can.Message(arbitration_id=0x63F, is_extended_id=False, data=[0x40, 0, 0x10, 0, 0, 0, 0, 0]))
    end = time.monotonic() + 5
    while time.monotonic() < end:
        message = bus.recv(timeout=1)
        if message is not None:
            print(f"{message.arbitration_id:03X}#{message.data.hex().upper()}", flush=True)
            if message.arbitration_id == 0x5BF:
                break
    bus.shutdown()


def line(*ends):
    """Two pseudo-terminals as the two ends of one serial line, under those names."""
    masters = []
    for end in ends:
        master, slave = pty.openpty()
        tty.setraw(slave)
        if os.path.lexists(end):
            os.unlink(end)
        os.symlink(os.ttyname(slave), end)
        masters.append(master)
    print("ready", file=sys.stderr, flush=True)
    while True:
        for ready in select.select(masters, [], [])[0]:
            os.write(masters[1 - masters.index(ready)], os.read(ready, 4096))


if __name__ == "__main__":
    globals()[sys.argv[1]](*sys.argv[2:])
