"""Other programs as judges: python-can reads the same frames, cantools the same values, and shares a hub."""

import socket
import subprocess
import threading

import can
import canopen
import cantools
import canvass
import polars
import pytest
from canvass.bridge import line_of, message
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as some

SAMPLES = sorted((ROOT / "traces/samples").glob("python-can*.*"))
SAMPLES = [path for path in SAMPLES if path.suffix in (".asc", ".blf", ".csv", ".db", ".log", ".trc")]


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.name)
def test_python_can_reads_the_same_frames(path):
    with can.LogReader(str(path)) as reader:
        theirs = [frame for frame in reader if not frame.is_error_frame]
    ours = [frame for frame in canvass.read(path) if not frame.is_error]
    assert [whole(frame, frame.data, frame.can_id) for frame in ours] == [
        whole(frame, frame.data, frame.arbitration_id) for frame in theirs
    ]
    # Formats with times from the start and from 1970 are read alike; what they count from differs.
    distances = [(frame.time - ours[0].time) - (other.timestamp - theirs[0].timestamp) for frame, other in zip(ours, theirs)]
    assert theirs and all(abs(distance) < 2e-6 for distance in distances)


def whole(frame, data, can_id):
    # python-can takes an empty CAN FD frame of an ASC file for a remote one, which CAN FD does not have.
    is_remote = frame.is_remote if hasattr(frame, "is_remote") else frame.is_remote_frame and not frame.is_fd
    is_extended = frame.is_extended if hasattr(frame, "is_extended") else frame.is_extended_id
    return can_id, is_extended, is_remote, b"" if is_remote else bytes(data)


def test_cantools_finds_the_same_values(tmp_path, rising):
    description, pdos = tmp_path / "encoder.eds", tmp_path / "pdos.dbc"
    canvass.run(["eds", "from-device", "sim:kuebler-sendix-58x8:5", "--node", "5", "-o", description])
    canvass.run(["eds", "convert", description, pdos, "--node", "5"])
    database = cantools.database.load_file(pdos)
    theirs = []
    with can.LogReader(str(rising)) as reader:
        for frame in reader:
            for name, value in database.decode_message(frame.arbitration_id, bytes(frame.data), scaling=False).items():
                theirs.append((frame.timestamp, name, value))
    signals = polars.DataFrame(canvass.read(rising, device={5: description}).signals)
    assert signals.height == len(theirs) == 200
    assert sorted(signals["raw"].to_list()) == sorted(value for _, _, value in theirs)


@given(
    can_id=some.integers(0, (1 << 29) - 1),
    is_extended=some.booleans(),
    is_remote=some.booleans(),
    data=some.binary(max_size=8),
    stamp=some.floats(0, 2e9),
)
def test_a_frame_comes_through_the_bridge_as_it_is(can_id, is_extended, is_remote, data, stamp):
    frame = can.Message(
        arbitration_id=can_id if is_extended else can_id & 0x7FF,
        is_extended_id=is_extended,
        is_remote_frame=is_remote,
        dlc=len(data),
        data=None if is_remote else data,
        timestamp=stamp,
    )
    line = line_of(frame, False)
    assert line.endswith(b"\r") and message(line[:-1]).equals(frame, timestamp_delta=None)
    stamped = line_of(frame, True)
    assert stamped.startswith(line[:-1]) and message(stamped[:-1]).equals(frame, timestamp_delta=None)
    if stamp:
        assert int(stamped[len(line) - 1 : -1], 16) == int(stamp * 1000) % 60000


def test_two_programs_share_a_hub():
    """python-canopen reads an object of a simulated device; a second program sees the request and the answer."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [canvass.path(), "simulate", "kuebler-sendix-58x8", f"slcan:listen://127.0.0.1:{port}", "--node", "5"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as device:
        try:
            assert f":{port}" in next(device.stderr), "it says where it waits as soon as it does"
            channel = f"socket://127.0.0.1:{port}"
            master = can.Bus(interface="slcan", channel=channel, bitrate=250000, sleep_after_open=0)
            watcher = can.Bus(interface="slcan", channel=channel, bitrate=250000, sleep_after_open=0)
            network = canopen.Network(master)
            network.connect()
            node = network.add_node(5, canopen.ObjectDictionary())
            seen, ended = [], threading.Event()
            watches = threading.Thread(target=watch, args=(watcher, seen, ended))
            watches.start()
            # The encoder boots when the first program connects.
            node.sdo.MAX_RETRIES = 20
            assert node.sdo.upload(0x1018, 1) == (19).to_bytes(4, "little")
            ended.wait(5)
            watches.join()
            network.disconnect()
            watcher.shutdown()
        finally:
            device.kill()
    assert [(0x605, b"\x40\x18\x10\x01\0\0\0\0"), (0x585, b"\x43\x18\x10\x01\x13\0\0\0")] == seen[-2:]


def watch(bus, seen, ended):
    """Receive requests until one is answered."""
    while (not seen or seen[-1][0] != 0x585) and (frame := bus.recv(5)) is not None:
        if frame.arbitration_id in (0x605, 0x585):
            seen.append((frame.arbitration_id, bytes(frame.data)))
    ended.set()
