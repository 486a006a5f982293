"""Reads and writes captures with other people's libraries, for the tests of the peers.

    peers.py read READER FILE     prints a line per frame
    peers.py write WRITER FILE    writes the frames whose lines come on standard input

    NANOSECONDS CHANNEL FRAME[ Rx| Tx]

FRAME is candump's notation. python-can reckons times in floating point, which holds microseconds of our days.
"""
import sys
from collections import namedtuple
from pathlib import Path

EXT, RTR, ERR = 0x8000_0000, 0x4000_0000, 0x2000_0000
SECOND = 10**9

# can_id has SocketCAN's flags; fd is None or BRS 1, ESI 2; direction is "Rx", "Tx" or "".
Frame = namedtuple("Frame", "t channel can_id length data fd direction")


def shown(f):
    number = f.can_id & 0x1FFF_FFFF
    ident = f"{number | ERR:08X}" if f.can_id & ERR else f"{number:08X}" if f.can_id & EXT else f"{number:03X}"
    body = f"R{f.length or ''}" if f.can_id & RTR else f.data.hex().upper()
    fd = "" if f.fd is None else f"#{4 | f.fd:X}"
    return f"{f.t} {f.channel} {ident}#{fd}{body} {f.direction}".rstrip()


def parsed(line):
    t, channel, frame, direction = (line.split() + [""])[:4]
    ident, body = frame.split("#", 1)
    can_id, fd, data, length = int(ident, 16), None, b"", 0
    if len(ident) == 8 and not can_id & ERR:
        can_id |= EXT
    if body.startswith("#"):
        fd, body = int(body[1], 16) & 3, body[2:]
    if body.startswith("R"):
        can_id, length = can_id | RTR, int(body[1:] or 0)
    else:
        data = bytes.fromhex(body)
        length = len(data)
    return Frame(int(t), channel, can_id, length, data, fd, direction)


# python-can


def of_message(m, first_channel):
    """Channels are names, or numbers that python-can counts from 0 where the file counts from 1."""
    can_id = m.arbitration_id | (EXT if m.is_extended_id else 0) | (RTR if m.is_remote_frame else 0)
    if m.is_error_frame:
        # One of which a file tells nothing is a bus error, as python-can's own logs have it.
        can_id |= ERR | (0 if m.arbitration_id else 0x80)
    channel = m.channel + first_channel if isinstance(m.channel, int) else m.channel or "1"
    fd = m.bitrate_switch | m.error_state_indicator << 1 if m.is_fd else None
    way = "Rx" if m.is_rx else "Tx"
    return Frame(round(m.timestamp * 1e6) * 1000, channel, can_id, m.dlc, bytes(m.data), fd, way)


def to_message(f, channel):
    import can

    return can.Message(
        timestamp=f.t / 1e9, channel=channel, arbitration_id=f.can_id & 0x1FFF_FFFF,
        # An error frame's class is 29 bits wide here.
        is_extended_id=bool(f.can_id & (EXT | ERR)), is_remote_frame=bool(f.can_id & RTR),
        is_error_frame=bool(f.can_id & ERR), is_fd=f.fd is not None, bitrate_switch=bool((f.fd or 0) & 1),
        error_state_indicator=bool((f.fd or 0) & 2), dlc=f.length, data=f.data, is_rx=f.direction != "Tx")


def python_can(reader, first_channel=1, **options):
    def read(path):
        import can

        with getattr(can, reader)(path, **options) as messages:
            for message in messages:
                yield of_message(message, first_channel)
    return read


def python_can_writer(writer, numbered=True, **options):
    def write(path, frames):
        import can

        with getattr(can, writer)(path, **options) as out:
            for f in frames:
                out.on_message_received(to_message(f, int(f.channel.removeprefix("can")) if numbered else f.channel))
    return write


def write_sqlite(path, frames):
    import can, time

    with can.SqliteWriter(path) as out:
        for f in frames:
            out.on_message_received(to_message(f, None))
        # The writer's thread drops what it has not taken from its queue when it ends.
        while not out.buffer.empty():
            time.sleep(0.01)


# MCAP

CLASSICAL, FD = "can_msgs/msg/Frame", "ros2_socketcan_msgs/msg/FdFrame"
TYPES = {
    CLASSICAL: "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\nuint8 dlc\n"
               "uint8[8] data\n",
    FD: "std_msgs/Header header\nuint32 id\nbool is_extended\nbool is_error\nuint8 len\nuint8[<=64] data\n",
}
HEADER = (
    f"{'=' * 80}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n")


def of_ros(topic, message, log_time):
    t = message.header.stamp.sec * SECOND + message.header.stamp.nanosec
    assert t == log_time, f"stamp {t}, log time {log_time}"
    fd = 0 if topic.endswith("/fd") else None
    length = message.dlc if fd is None else message.len
    can_id = message.id | (EXT if message.is_extended else 0) | (ERR if message.is_error else 0)
    if fd is None and message.is_rtr:
        can_id |= RTR
    data = b"" if can_id & RTR else bytes(message.data)[:length]
    return Frame(t, topic.removeprefix("/").removesuffix("/fd"), can_id, length, data, fd, "")


def topic_of(f):
    return f"/{f.channel}" + ("" if f.fd is None else "/fd")


def ros_fields(f):
    fields = {"id": f.can_id & 0x1FFF_FFFF, "is_extended": bool(f.can_id & EXT), "is_error": bool(f.can_id & ERR)}
    if f.fd is None:
        # What is beyond the length is stale in bridges that copy a whole can_frame.
        return fields | {"is_rtr": bool(f.can_id & RTR), "dlc": f.length, "data": f.data + b"\xEE" * (8 - len(f.data))}
    return fields | {"len": f.length, "data": f.data}


def read_mcap(path):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        count = reader.get_summary().statistics.message_count
        for n, (_, channel, message, ros) in enumerate(reader.iter_decoded_messages(log_time_order=False), 1):
            yield of_ros(channel.topic, ros, message.log_time)
        assert n == count, f"{n} messages, the summary says {count}"


def mcap_writer(compression):
    def write(path, frames):
        from mcap.writer import CompressionType
        from mcap_ros2.writer import Writer

        with open(path, "wb") as file:
            writer = Writer(file, chunk_size=20_000, compression=CompressionType[compression])
            schemas = {name: writer.register_msgdef(name, text + HEADER) for name, text in TYPES.items()}
            for f in frames:
                header = {"stamp": {"sec": f.t // SECOND, "nanosec": f.t % SECOND}, "frame_id": f.channel}
                message = {"header": header} | ros_fields(f)
                writer.write_message(topic_of(f), schemas[CLASSICAL if f.fd is None else FD], message, f.t, f.t)
            writer.finish()
    return write


def typestore():
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in TYPES.items():
        store.register(get_types_from_msg(text, name))
    return store


def read_rosbags(path):
    from rosbags.highlevel import AnyReader

    # Without a type store of our own: the types come out of the file.
    with AnyReader([Path(path)]) as reader:
        for connection, log_time, data in reader.messages():
            yield of_ros(connection.topic, reader.deserialize(data, connection.msgtype), log_time)


def write_rosbags(path, frames):
    import numpy
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = typestore()
    folder = Path(path).with_suffix(".bag")
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {}
        for f in frames:
            name, topic = CLASSICAL if f.fd is None else FD, topic_of(f)
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            stamp = store.types["builtin_interfaces/msg/Time"](sec=f.t // SECOND, nanosec=f.t % SECOND)
            header = store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="can")
            fields = ros_fields(f)
            fields["data"] = numpy.frombuffer(fields["data"], dtype=numpy.uint8)
            message = store.types[name](header=header, **fields)
            writer.write(connections[topic], f.t, store.serialize_cdr(message, name))
    (bag,) = folder.glob("*.mcap")
    bag.rename(path)


READERS = {
    "candump": python_can("CanutilsLogReader"),
    "asc": python_can("ASCReader", relative_timestamp=False),
    "trc": python_can("TRCReader", first_channel=0),
    "csv": python_can("CSVReader"),
    "blf": python_can("BLFReader"),
    "mf4": python_can("MF4Reader", first_channel=0),
    "mcap": read_mcap,
    "rosbags": read_rosbags,
}
WRITERS = {
    "candump": python_can_writer("CanutilsLogWriter", numbered=False),
    "asc": python_can_writer("ASCWriter"),
    "trc": python_can_writer("TRCWriter"),
    "csv": python_can_writer("CSVWriter"),
    "blf": python_can_writer("BLFWriter"),
    "mf4": python_can_writer("MF4Writer"),
    "sqlite": write_sqlite,
    "mcap-zstd": mcap_writer("ZSTD"),
    "mcap-lz4": mcap_writer("LZ4"),
    "mcap-plain": mcap_writer("NONE"),
    "rosbags": write_rosbags,
}

if __name__ == "__main__":
    way, name, path = sys.argv[1:]
    if way == "read":
        for frame in READERS[name](path):
            print(shown(frame))
    else:
        WRITERS[name](path, [parsed(line) for line in sys.stdin])
