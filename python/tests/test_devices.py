"""Simulated devices: conformance, fuzzing, python-can and python-canopen."""

import copy
import pickle
import socket
import subprocess
import sys
import threading
import time

import can
import canopen
import canvass
import pytest
from canvass.bridge import Bridge, line_of, message
from canvass.results import TestRun

MODEL = "kuebler-sendix-58x8"


@pytest.fixture(params=[True, False], ids=["real time", "virtual time"])
def network(request):
    """A python-canopen network with a simulated encoder as node 63."""
    bus = can.Bus(interface="canvass", channel=f"sim:{MODEL}", real_time=request.param)
    network = canopen.Network(bus)
    network.connect()
    yield network
    network.disconnect()


def test_python_canopen_is_the_master(network):
    node = network.add_node(63, canopen.ObjectDictionary())
    assert node.sdo.upload(0x1018, 1) == (19).to_bytes(4, "little")
    # A segmented upload.
    assert node.sdo.upload(0x1008, 0) == b"Kuebler Sendix Encoder"
    node.sdo.download(0x1017, 0, (100).to_bytes(2, "little"))
    assert node.sdo.upload(0x1017, 0) == b"\x64\0"
    with pytest.raises(canopen.SdoAbortedError) as abort:
        node.sdo.upload(0x5FFF, 0)
    assert abort.value.code == 0x06020000
    node.nmt.state = "OPERATIONAL"
    assert node.nmt.wait_for_heartbeat(timeout=5) == "OPERATIONAL"


def test_pdos_and_emergencies_come(network):
    bus, node = network.bus, network.add_node(63, canopen.ObjectDictionary())
    seen = []
    network.subscribe(0x80 + 63, lambda can_id, data, timestamp: seen.append(bytes(data)))
    bus.simulation.set_error(0x4310, True)
    node.sdo.upload(0x1000, 0)
    deadline = time.monotonic() + 5
    while not seen and time.monotonic() < deadline:
        node.sdo.upload(0x1001, 0)
    assert seen and seen[0][:2] == b"\x10\x43"
    history = node.sdo.upload(0x1003, 1)
    assert history[:2] == b"\x10\x43"


def test_layer_setting():
    bus = can.Bus(interface="canvass", channel=f"sim:{MODEL}:255", real_time=False)
    network = canopen.Network(bus)
    network.connect()
    found, identity = network.lss.fast_scan()
    assert found and identity[0] == 19
    network.lss.configure_node_id(17)
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    assert bus.simulation.devices == [(17, MODEL)]
    network.disconnect()


def test_virtual_time_waits_for_nobody():
    with canvass.Device(MODEL, real_time=False).bus() as bus:
        began = time.monotonic()
        bus.send(can.Message(arbitration_id=0x63F, data=bytes.fromhex("2B171000E8030000"), is_extended_id=False))
        heartbeats = []
        while len(heartbeats) < 100:
            received = bus.recv(timeout=10)
            if received.arbitration_id == 0x73F and received.data != b"\0":
                heartbeats.append(received.timestamp)
        distances = [later - earlier for earlier, later in zip(heartbeats, heartbeats[1:])]
        assert all(0.99 < distance < 1.01 for distance in distances)
        assert time.monotonic() - began < 20, "100 s of the device"


def test_a_device_is_changed_while_it_runs():
    device = canvass.Device(MODEL, faults=["boot-up-twice"], real_time=False)
    with device.bus(receive_own_messages=True) as bus:
        boot_ups = [bus.recv(1).arbitration_id for _ in range(2)]
        assert boot_ups == [0x73F, 0x73F]
        device.power_cycle()
        assert bus.recv(5).data == b"\0"
    with pytest.raises(KeyError, match="node-ID 5"):
        device.simulation.power_cycle(5)
    with pytest.raises(ValueError, match="boot-up-twice meant"):
        canvass.Device(MODEL, faults=["boot-up-twise"])
    assert (MODEL, 63) == (device.model, device.node) and MODEL in dict(canvass.models())


def test_ctrl_c_ends_the_wait_for_a_frame():
    """A silent bus without a timeout, in both kinds of time."""
    for real_time in (True, False):
        code = (
            "import can, signal, threading, os\n"
            f"bus = can.Bus(interface='canvass', channel='sim:{MODEL}:255', real_time={real_time})\n"
            "threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
            "try:\n    while True: bus.recv()\n"
            "except KeyboardInterrupt: print('interrupted')\n"
        )
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=30)
        assert done.stdout == "interrupted\n", done.stderr


def test_own_messages_and_wrong_frames():
    with can.Bus(interface="canvass", channel=f"sim:{MODEL}", receive_own_messages=True, real_time=False) as bus:
        bus.send(can.Message(arbitration_id=0, data=[1, 63], is_extended_id=False))
        received = [bus.recv(1), bus.recv(1)]
        own = next(frame for frame in received if frame.arbitration_id == 0)
        assert not own.is_rx and bytes(own.data) == b"\x01\x3f"
        with pytest.raises(can.CanOperationError, match="classical"):
            bus.send(can.Message(arbitration_id=1, data=bytes(12), is_fd=True, is_extended_id=False))


def test_conformance_and_fuzzing():
    good = canvass.test(f"sim:{MODEL}", select="301/boot-up")
    assert good.passed and good.why == "" and good.case("301/boot-up/every-time").passed
    wrong = canvass.test(f"sim:{MODEL}+boot-up-twice", select=["301/boot-up", "301/nmt/back-to-back"])
    assert not wrong.passed and wrong.failures[0].clause.startswith("CiA 301 7.2.8")
    assert "boot-up" in wrong.failures[0].why and "73F" in wrong.failures[0].frames()
    assert canvass.fuzz("sim:reference-301", runs=100, seed=1).passed
    broken = canvass.fuzz("sim:reference-301+sdo-stray-segment-silent", runs=3000, seed=1)
    assert not broken.passed and "expected a download segment without its transfer" in broken.why
    with pytest.raises(canvass.CanvassError, match="expected a device description"):
        canvass.test("sim:kuebler-sendix-58x9")


def test_an_undecided_device_has_not_passed():
    """No case fails on this firmware, and one can't be decided."""
    selected = "301/tpdo/sync-count-restarts,301/boot-up/every-time"
    undecided = canvass.test(f"sim:{MODEL}+sdo-silent-when-operational", select=selected)
    assert not undecided.failures and undecided.case("301/boot-up/every-time").passed
    assert [case.id for case in undecided.inconclusive] == ["301/tpdo/sync-count-restarts"]
    assert not undecided.passed and undecided.status == 1 and "sync-count-restarts" in undecided.why
    decided = TestRun({"cases": [], "cancelled": False, "notices": []}, 0)
    assert not decided.passed and decided.why == "no case passed"
    inconclusive = {"id": "301/sdo/x", "verdict": "inconclusive", "reason": "no answer"}
    undecided = TestRun({"cases": [inconclusive], "cancelled": False, "notices": ["1017h was left changed"]}, 1)
    assert not undecided.passed
    assert undecided.why == "inconclusive 301/sdo/x: no answer\n1017h was left changed"
    assert copy.deepcopy(undecided) == undecided == pickle.loads(pickle.dumps(undecided))


def verdicts(result):
    return {case.id: case.verdict for case in result.cases}


def test_a_python_can_bus_gives_the_same_verdicts():
    selected = "301/boot-up,301/sdo/abort"
    natively = verdicts(canvass.test(f"sim:{MODEL}", select=selected))
    device = canvass.Device(MODEL)
    bridged = canvass.test(device, node=63, device=MODEL, select=selected)
    assert bridged.bus.startswith("slcan:tcp://127.0.0.1:"), "it is this device that was tested"
    assert verdicts(bridged) == natively and "pass" in natively.values()
    with pytest.raises(ValueError, match="virtual time"):
        canvass.test(canvass.Device(MODEL, real_time=False), node=63)


def pump(source, sink, ended):
    while not ended.is_set():
        frame = source.recv(0.05)
        if frame is not None:
            sink.send(frame)


@pytest.mark.parametrize(
    "interface, channel",
    [("virtual", "canvass"), ("udp_multicast", "239.74.163.2")],
)
def test_buses_of_python_can(interface, channel):
    """A simulated encoder on the other end of a bus of python-can, reached through the bridge."""
    settings = {"interface": interface, "channel": channel}
    with canvass.Device(MODEL).bus() as device, can.Bus(**settings) as far, can.Bus(**settings) as near:
        ended = threading.Event()
        threads = [threading.Thread(target=pump, args=(*pair, ended)) for pair in ((device, far), (far, device))]
        for thread in threads:
            thread.start()
        try:
            result = canvass.test(near, node=63, device=MODEL, select="301/nmt/back-to-back,301/sdo/abort/multiplexer")
        finally:
            ended.set()
            for thread in threads:
                thread.join()
    natively = verdicts(canvass.test(f"sim:{MODEL}", select="301/nmt/back-to-back,301/sdo/abort/multiplexer"))
    assert verdicts(result) == natively


def test_the_program_opens_buses_of_python_can(monkeypatch):
    """`python:canvass:sim:MODEL`: the program, a bridge, and the interface of this package."""
    monkeypatch.setenv("CANVASS_PYTHON", sys.executable)
    result = canvass.test(f"python:canvass:sim:{MODEL}", node=63, device=MODEL, select="301/nmt/back-to-back")
    assert result.passed and result.bus == f"python:canvass:sim:{MODEL}"
    with pytest.raises(canvass.CanvassError, match="python-can can't open nothing") as error:
        canvass.test("python:nothing:0", node=5)
    assert error.value.status == 3
    with pytest.raises(canvass.CanvassError, match="expected python:INTERFACE:CHANNEL"):
        canvass.test("python:kvaser", node=5)


def test_lines_of_the_bridge():
    frame = can.Message(arbitration_id=0x18FF1234, data=[1, 2], is_extended_id=True, timestamp=61.5)
    assert line_of(frame, True) == b"T18FF12342010205DC\r"
    assert line_of(frame, False) == b"T18FF123420102\r"
    remote = message(b"r7054")
    assert remote.is_remote_frame and remote.dlc == 4 and line_of(remote, False) == b"r7054\r"
    for line in (b"t60584000100000000000", b"T0000060520A0B"):
        assert line_of(message(line), False) == line + b"\r"


def test_the_bridge_serves_one_program_after_the_other():
    with canvass.Device(MODEL).bus() as bus, Bridge(bus) as bridge:
        port = int(bridge.address.rsplit(":", 1)[1])
        for _ in range(2):
            with socket.create_connection(("127.0.0.1", port)) as program:
                program.settimeout(5)
                program.sendall(b"\rO\rt63F84018100100000000\r")
                received = b""
                while b"t5BF8" not in received:
                    received += program.recv(4096)
                assert b"t5BF84318100113000000\r" in received


def test_the_program_is_found(monkeypatch):
    done = subprocess.run([canvass.path(), "--version"], capture_output=True, check=True)
    assert done.stdout.decode().strip() == f"canvass {canvass.__version__}"
    monkeypatch.setenv("CANVASS_PROGRAM", "/no/such/program")
    with pytest.raises(OSError):
        canvass.run(["--version"])
