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


def eventually(condition, seconds=10):
    """Whether that becomes so."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)
    return condition()


def connected(interface):
    network = canopen.Network()
    network.connect(channel=interface, interface="socketcan")
    network.check()
    return network


def master(interface, eds):
    """Everything that a master does with a device: reference-301 at node 10."""
    network = connected(interface)
    node = network.add_node(10, eds)
    node.sdo.RESPONSE_TIMEOUT = 3
    sdo_transfers(node)
    states(node)
    pdos(network, node)
    emergency(network, node)
    node.nmt.state = "RESET"
    node.nmt.wait_for_bootup(timeout=10)
    good("reset", True)
    layer_settings(network)
    network.disconnect()


def sdo_transfers(node):
    """Expedited, segmented and in blocks, both ways, and an abort."""
    device_type = int.from_bytes(node.sdo.upload(0x1000, 0), "little")
    good("expedited upload", device_type & 0xFFFF == 401, hex(device_type))
    node.sdo.download(0x1017, 0, (100).to_bytes(2, "little"))
    good("expedited download", node.sdo.upload(0x1017, 0) == b"\x64\x00")
    name = node.sdo.upload(0x1008, 0)
    good("segmented upload", name == b"canvass reference 301", name)
    place = b"third hall, second row, at the conveyor"
    node.sdo.download(0x2011, 0, place)
    good("segmented download", node.sdo.upload(0x2011, 0) == place, node.sdo.upload(0x2011, 0))
    # More than one block of 127 segments, and a last segment that is not full.
    program = bytes(n * 7 % 251 for n in range(2000))
    with node.sdo.open(0x2010, 0, "wb", size=len(program), block_transfer=True) as stream:
        stream.write(program)
    good("block download", node.sdo.upload(0x2010, 0) == program)
    with node.sdo.open(0x2010, 0, "rb", block_transfer=True) as stream:
        found = stream.read()
    good("block upload", found == program, len(found))
    try:
        node.sdo.upload(0x5000, 0)
        good("abort", False, "no abort")
    except canopen.SdoAbortedError as error:
        good("abort", error.code == 0x06020000, error)


def states(node):
    """NMT commands, whose effect the heartbeats tell."""
    for command in ["OPERATIONAL", "STOPPED", "PRE-OPERATIONAL", "OPERATIONAL"]:
        node.nmt.state = command
        # python canopen takes for granted that the node has done it, until a heartbeat says what is.
        node.nmt.wait_for_heartbeat(timeout=5)
        state = node.nmt.wait_for_heartbeat(timeout=5)
        good(f"state {command}", state == command, state)


def pdos(network, node):
    """Outputs by RPDO 1 come back as inputs, which TPDO 1 carries when they change; TPDO 2 is asked for by SYNC."""
    node.rpdo.read()
    node.tpdo.read()
    received = []
    node.tpdo[1].add_callback(lambda pdo: received.append(pdo[0].raw))
    node.rpdo[1][0].raw = 0x5A
    node.rpdo[1].transmit()
    good("pdo", eventually(lambda: 0x5A in received), received)
    node.tpdo[2].trans_type = 1
    node.tpdo[2].save()
    synchronous = []
    node.tpdo[2].add_callback(synchronous.append)
    network.sync.transmit()
    good("sync", eventually(lambda: synchronous), "no TPDO 2")


def emergency(network, node):
    """An RPDO that is too short is answered by an EMCY (8210h)."""
    network.send_message(0x200 + 10, b"\x01")
    good("emcy", eventually(lambda: any(error.code == 0x8210 for error in node.emcy.log)), node.emcy.log)


def layer_settings(network):
    """LSS with the only device on the bus, then Fastscan once it has no node-ID."""
    lss = network.lss
    lss.RESPONSE_TIMEOUT = 1
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    parts = [canopen.lss.CS_INQUIRE_VENDOR_ID, canopen.lss.CS_INQUIRE_PRODUCT_CODE,
             canopen.lss.CS_INQUIRE_REVISION_NUMBER, canopen.lss.CS_INQUIRE_SERIAL_NUMBER]
    address = [lss.inquire_lss_address(part) for part in parts]
    good("lss inquire", (address[3], lss.inquire_node_id()) == (301001, 10), address)
    lss.configure_bit_timing(2)
    lss.configure_node_id(255)
    lss.send_switch_state_global(lss.WAITING_STATE)
    found = lss.send_switch_state_selective(*address)
    good("lss selective", found, address)
    lss.send_switch_state_global(lss.WAITING_STATE)
    # The device takes its new node-ID, which is none, when its communication is reset.
    network.nmt.send_command(0x82)
    time.sleep(1)
    lss.RESPONSE_TIMEOUT = 0.05
    scanned = lss.fast_scan()
    good("lss fastscan", scanned == (True, address), (scanned, address))
    lss.RESPONSE_TIMEOUT = 1
    lss.configure_node_id(11)
    lss.send_switch_state_global(lss.WAITING_STATE)
    booted = network.add_node(11)
    good("lss node-ID", eventually(lambda: booted.nmt.timestamp is not None), "no boot-up message of node 11")


def device(interface):
    """A LocalNode with a small dictionary, as node 5."""
    # Nobody reads what it thinks of the requests, and a full pipe would stop it.
    logging.disable(logging.CRITICAL)
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
    for sub, name, value in [(0, "Highest sub-index", 4), (1, "Vendor-ID", 1), (2, "Product code", 1),
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
