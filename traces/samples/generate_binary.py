#!/usr/bin/env python3
"""Makes the binary sample captures and, beside each, what another program reads in it (`*.frames`).

Written by text2pcap, editcap and mergecap (Wireshark), python-can, and the Python packages mcap, rosbags and asammdf;
read back by tshark and python-can. Nothing here is written or read by canvass.

    pip install python-can mcap rosbags zstandard lz4 asammdf
    ./generate_binary.py
"""
import base64, json, struct, subprocess, sys
from pathlib import Path

HERE = Path(__file__).parent
EXT, RTR, ERR = 0x8000_0000, 0x4000_0000, 0x2000_0000
START = 1_700_000_000_000_000_000  # 2023-11-14 22:13:20 UTC


class F:
    """A frame: time (ns), bus, identifier with SocketCAN's flags, data, CAN FD flags or None."""

    def __init__(self, ms, bus, can_id, data=b"", fd=None, dlc=None):
        self.t = START + int(ms * 1_000_000)
        self.bus, self.id, self.data, self.fd = bus, can_id, bytes(data), fd
        self.dlc = len(self.data) if dlc is None else dlc

    def wire(self, order=">"):
        """As in a packet of link type 227 (order ">"), or of a machine of that byte order."""
        size, flags = (8, 0) if self.fd is None else (64, 4 | self.fd)
        return struct.pack(order + "IBBBB", self.id, self.dlc, flags, 0, 0) + self.data.ljust(size, b"\0")

    def shown(self, channel, t=None, direction=""):
        return show(self.t if t is None else t, channel, self.id, self.data, self.fd, self.dlc, direction)


def show(t, channel, can_id, data, fd, dlc, direction=""):
    number = can_id & 0x1FFF_FFFF
    ident = f"{number | ERR:08X}" if can_id & ERR else f"{number:08X}" if can_id & EXT else f"{number & 0x7FF:03X}"
    body = "" if fd is None else f"#{4 | fd:X}"
    body += f"R{dlc if dlc else ''}" if can_id & RTR else data.hex().upper()
    return f"{t // 10**9}.{t % 10**9:09} {channel} {ident}#{body} {direction}".rstrip()


def b(text):
    return bytes.fromhex(text)


TRAFFIC = [
    F(0.000, 0, 0x000, b("0100")),
    F(1.250, 0, 0x77F, b("00")),
    F(1.750, 0, 0x63F, b("4000600000000000")),
    F(2.125, 0, 0x5BF, b("4B00600004000000")),
    F(3.001, 0, 0x080),
    F(3.002, 1, 0x080, b("07")),
    F(3.500, 0, 0x1BF, b("0102030405060708")),
    F(4.000, 1, 0x18FEF1FE | EXT, b("FFFFFF0102")),
    F(4.500, 1, 0x00000181 | EXT, b("AA")),
    F(5.000, 0, 0x73F | RTR, dlc=1),
    F(5.250, 0, 0x73F, b("85")),
    F(6.000, 1, 0x1ABCDEF0 | EXT | RTR, dlc=0),
    F(7.000, 0, 0x004 | ERR, b("0008000000006000")),
    F(8.000, 1, 0x0BF, b("0081110000000000")),
    F(9.000, 0, 0x7E5, b("0400000000000000")),
    F(10.000, 1, 0x123, b("DEADBEEF"), fd=0),
    F(10.500, 1, 0x124, bytes(range(64)), fd=1),
    F(11.000, 1, 0x1234567 | EXT, bytes(range(20)), fd=3),
    F(11.500, 0, 0x77F, b("05")),
    F(12.000, 0, 0x63F, b("2F17100000000000")),
    F(12.123, 0, 0x5BF, b("6017100000000000")),
    F(1012.0, 0, 0x77F, b("7F")),
    F(2012.0, 0, 0x77F, b("7F")),
    F(2013.0, 1, 0x7FF, b("")),
]
CLASSICAL = [f for f in TRAFFIC if f.fd is None]


def write(name, content):
    (HERE / name).write_bytes(content)


def expect(name, lines):
    (HERE / f"{name}.frames").write_text("".join(line + "\n" for line in lines))


def hexdump(frames, encode):
    """For text2pcap, with the time in front of each packet."""
    out = []
    for f in frames:
        data = encode(f)
        out.append(f"{f.t // 10**9}.{f.t % 10**9:09}\n000000 " + " ".join(f"{byte:02x}" for byte in data) + "\n")
    return "".join(out).encode()


def text2pcap(name, frames, link, encode, *options):
    run = ["text2pcap", "-q", "-t", "%s.%f", "-l", str(link), *options, "-", str(HERE / name)]
    subprocess.run(run, input=hexdump(frames, encode), check=True, capture_output=True)


def sll(f, order="<"):
    protocol = 0x0C if f.fd is None else 0x0D
    kind = 4 if f.bus else 0
    return struct.pack(">HHHQH", kind, 280, 0, 0, protocol) + f.wire(order)


def sll2(f, order="<"):
    protocol = 0x0C if f.fd is None else 0x0D
    return struct.pack(">HHIHBBQ", protocol, 0, 3 + f.bus, 280, 4 if f.bus else 0, 0, 0) + f.wire(order)


def tshark(name, channel=None, direction=None):
    """What tshark reads: time, interface, identifier, flags, payload."""
    fields = "frame.time_epoch frame.interface_name frame.packet_flags_direction can.id can.flags.xtd can.flags.rtr " \
        "can.flags.err can.len data.data canfd.flags.brs canfd.flags.esi can.err.ctrl frame.protocols sll.pkttype sll.ifindex"
    run = ["tshark", "-r", str(HERE / name), "--disable-protocol", "autosar-nm", "-T", "fields", "-E", "separator=|"]
    for field in fields.split():
        run += ["-e", field]
    lines = []
    rows = subprocess.run(run, check=True, capture_output=True, text=True).stdout.splitlines()
    for packet, row in enumerate(rows):
        t, iface, way, ident, xtd, rtr, err, length, data, brs, esi, ctrl, protocols, kind, index = row.split("|")
        if not t:  # a block that tshark does not know
            continue
        seconds, nanos = t.split(".")
        # Of an error frame tshark shows the class as a flag of its own: here always "controller problem".
        can_id = (4 if ctrl == "1" else int(ident, 0)) | (EXT if xtd == "1" else 0) | (RTR if rtr == "1" else 0) | (ERR if err == "1" else 0)
        fd = None if "canfd" not in protocols and not brs else (brs == "1") | (esi == "1") << 1
        if fd is not None:
            can_id &= ~(RTR | ERR)
        payload = b"" if can_id & RTR else bytes.fromhex(data)
        if can_id & ERR:  # dissected further, so not shown as data: taken from the bytes
            payload = error_data(name, packet)
        where = channel or (f"if{index}" if index else iface)
        way = {"1": "Rx", "2": "Tx", "0x00000001": "Rx", "0x00000002": "Tx"}.get(way, "")
        if kind:
            way = "Tx" if kind == "4" else "Rx"
        lines.append(show(int(seconds) * 10**9 + int(nanos), where, can_id, payload, fd, int(length), way))
    return lines


def error_data(name, index):
    run = ["tshark", "-r", str(HERE / name), "-T", "jsonraw", "-J", "frame", "-x"]
    packets = json.loads(subprocess.run(run, check=True, capture_output=True, text=True).stdout)
    return bytes.fromhex(packets[index]["_source"]["layers"]["frame_raw"][0])[-8:]


def pcap(name, frames, magic, order, link, encode, fraction, snaplen=0):
    out = struct.pack(order + "IHHiIII", magic, 2, 4, 0, 0, snaplen, link)
    for f in frames:
        data = encode(f)
        out += struct.pack(order + "IIII", f.t // 10**9, f.t % 10**9 // fraction, len(data), len(data)) + data
    write(name, out)


def make_pcap():
    text2pcap("tcpdump-us.pcap", TRAFFIC, 227, F.wire, "-F", "pcap")
    text2pcap("tcpdump-ns.pcap", TRAFFIC, 227, F.wire, "-F", "nsecpcap")
    # Big-endian, and upper bits in the link type, as machines in the field write them.
    pcap("big-endian.pcap", TRAFFIC, 0xA1B2C3D4, ">", 227, F.wire, 1000)
    pcap("cooked-big-endian.pcap", TRAFFIC, 0xA1B23C4D, ">", 113, lambda f: sll(f, ">"), 1)
    text2pcap("cooked.pcap", TRAFFIC, 113, sll, "-F", "pcap")
    text2pcap("cooked-v2.pcap", TRAFFIC, 276, sll2, "-F", "pcap")
    for name in ["tcpdump-us.pcap", "tcpdump-ns.pcap", "big-endian.pcap", "cooked.pcap", "cooked-big-endian.pcap"]:
        expect(name, tshark(name, channel="can0"))
    expect("cooked-v2.pcap", tshark("cooked-v2.pcap"))


def unclean(f):
    """As a program sends it that does not clear `struct can_frame`: garbage in the filling."""
    wire = bytearray(f.wire("<"))
    if f.fd is None:
        wire[5:8] = [(f.t // 1000) & 0xFF | 4, (f.t // 250_000) & 1, 12]
        wire[8 + len(f.data):] = bytes(8 - len(f.data) if f.id & RTR else [0xCC] * (8 - len(f.data)))
    return sll(f)[:16] + bytes(wire)


def make_unclean():
    pcap("unclean-filling.pcap", TRAFFIC, 0xA1B23C4D, "<", 113, unclean, 1)
    # The protocol tells that these are classical frames.
    expect("unclean-filling.pcap", [f.shown("can0", direction="Tx" if f.bus else "Rx") for f in TRAFFIC])


def make_pcapng():
    for bus in (0, 1):
        text2pcap(f"bus{bus}.tmp", [f for f in TRAFFIC if f.bus == bus], 227, F.wire, "-N", f"can{bus}", "-F", "pcapng")
    subprocess.run(["mergecap", "-F", "pcapng", "-w", str(HERE / "two-interfaces.pcapng"), str(HERE / "bus0.tmp"),
                    str(HERE / "bus1.tmp")], check=True, capture_output=True)
    for bus in (0, 1):
        (HERE / f"bus{bus}.tmp").unlink()
    expect("two-interfaces.pcapng", tshark("two-interfaces.pcapng"))
    sections = b"".join(section(*each) for each in [
        ("<", TRAFFIC[:8], 9, 0, 227), (">", TRAFFIC[8:16], 6, 0, 113), ("<", TRAFFIC[16:], 0x80 | 30, 1_600_000_000, 227)])
    write("three-sections.pcapng", sections)
    expect("three-sections.pcapng", tshark("three-sections.pcapng"))


def block(order, kind, body):
    length = 12 + len(body)
    return struct.pack(order + "II", kind, length) + body + struct.pack(order + "I", length)


def option(order, code, value):
    return struct.pack(order + "HH", code, len(value)) + value + bytes(-len(value) % 4)


def section(order, frames, resolution, offset, link):
    """One section with an interface per bus, an unknown block, and the direction in the flags."""
    out = block(order, 0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1))
    for bus in (0, 1):
        options = option(order, 2, f"can{bus}".encode()) + option(order, 9, bytes([resolution]))
        options += option(order, 14, struct.pack(order + "q", offset)) if offset else b""
        out += block(order, 1, struct.pack(order + "HHI", link, 0, 0) + options + bytes(4))
    out += block(order, 0x0BAD, b"unknown!")
    for f in frames:
        data = f.wire() if link == 227 else sll(f, order)
        nanos = f.t - offset * 10**9
        units = (nanos << (resolution & 0x7F)) // 10**9 if resolution & 0x80 else nanos // 10 ** (9 - resolution)
        if resolution & 0x80:
            units += 1  # so that the nanosecond, rounded down again, is the same
        body = struct.pack(order + "IIIII", f.bus, units >> 32, units & 0xFFFFFFFF, len(data), len(data))
        body += data + bytes(-len(data) % 4) + option(order, 2, struct.pack(order + "I", 1 + f.bus)) + bytes(4)
        out += block(order, 6, body)
    return out


TYPES = {
    "can_msgs/msg/Frame": "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\nuint8 dlc\n"
                          "uint8[8] data\n",
    "ros2_socketcan_msgs/msg/FdFrame": "std_msgs/Header header\nuint32 id\nbool is_extended\nbool is_error\nuint8 len\n"
                                       "uint8[<=64] data\n",
    # As vendors make them: a header of their own, constants, the frame inside, the time beside it.
    "vendor_msgs/msg/Raw": "uint32 can_id\nuint8 MAX_LENGTH=8\nbool extended\nbool rtr\nbool err\nuint8 datalen\n"
                           "uint8[] payload\n",
    "vendor_msgs/msg/CanEvent": "string<=16 device\nuint16[3] versions\nfloat64 load\n"
                                "builtin_interfaces/Time stamp\nvendor_msgs/Raw frame\nstring[] notes\n",
}
STALE = bytes(range(0xF0, 0xF8))


def typestore(release):
    from rosbags.typesys import get_typestore, get_types_from_msg
    store = get_typestore(release)
    types = {}
    for name, text in TYPES.items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store


def ros_message(store, f, name):
    import numpy
    time = store.types["builtin_interfaces/msg/Time"](sec=f.t // 10**9, nanosec=f.t % 10**9)
    number, extended = f.id & 0x1FFF_FFFF, bool(f.id & EXT)
    rtr, err = bool(f.id & RTR), bool(f.id & ERR)
    make = store.types[name]
    if name == "vendor_msgs/msg/CanEvent":
        raw = store.types["vendor_msgs/msg/Raw"](can_id=number, extended=extended, rtr=rtr, err=err, datalen=f.dlc,
                                                 payload=numpy.frombuffer(f.data, dtype=numpy.uint8))
        return make(device="logger", versions=numpy.array([1, 2, 3], dtype=numpy.uint16), load=0.5, stamp=time,
                    frame=raw, notes=["a", "bc"])
    kwargs = {"seq": f.dlc} if "seq" in store.types["std_msgs/msg/Header"].__dataclass_fields__ else {}
    header = store.types["std_msgs/msg/Header"](stamp=time, frame_id="can", **kwargs)
    if name == "ros2_socketcan_msgs/msg/FdFrame":
        data = numpy.frombuffer(f.data, dtype=numpy.uint8)
        return make(header=header, id=number, is_extended=extended, is_error=err, len=f.dlc, data=data)
    data = numpy.frombuffer(f.data + STALE[len(f.data):], dtype=numpy.uint8)
    return make(header=header, id=number, is_rtr=rtr, is_extended=extended, is_error=err, dlc=f.dlc, data=data)


def mcap_writer(name, **options):
    from mcap.writer import Writer
    writer = Writer(str(HERE / name), **options)
    writer.start(profile="", library="generate_binary.py")
    return writer


def log_time(f):
    return f.t + 5_000_000  # later than the frame's own stamp


def make_ros2(name, frames, message_of, **options):
    from rosbags.typesys import Stores
    store = typestore(Stores.ROS2_HUMBLE)
    writer = mcap_writer(name, **options)
    text, _ = store.generate_msgdef("std_msgs/msg/String", ros_version=2)
    log = writer.register_channel("/rosout", "cdr", writer.register_schema("std_msgs/msg/String", "ros2msg", text.encode()))
    schemas, channels = {}, {}
    for n, f in enumerate(frames):
        message = message_of(f)
        if message not in schemas:
            text, _ = store.generate_msgdef(message, ros_version=2)
            schemas[message] = writer.register_schema(message, "ros2msg", text.encode())
        topic = f"/can{f.bus}" + ("/fd" if f.fd is not None else "")
        if topic not in channels:
            channels[topic] = writer.register_channel(topic, "cdr", schemas[message])
        data = store.serialize_cdr(ros_message(store, f, message), message, little_endian=n % 5 != 4)
        writer.add_message(channels[topic], log_time(f), bytes(data), f.t)
        if n % 7 == 0:
            writer.add_message(log, log_time(f), b"\0\x01\0\0\x06\0\0\0hello\0", f.t)
    writer.finish()
    # FdFrame has no BRS and ESI.
    expect(name, [show(f.t, f"can{f.bus}", f.id, f.data, None if f.fd is None else 0, f.dlc) for f in frames])


def make_ros1(name):
    from rosbags.typesys import Stores
    store = typestore(Stores.ROS1_NOETIC)
    writer = mcap_writer(name)
    message = "can_msgs/msg/Frame"
    text, _ = store.generate_msgdef(message, ros_version=1)
    schema = writer.register_schema("can_msgs/Frame", "ros1msg", text.encode())
    channels = [writer.register_channel(f"/can{bus}", "ros1", schema) for bus in (0, 1)]
    for f in CLASSICAL:
        writer.add_message(channels[f.bus], log_time(f), bytes(store.serialize_ros1(ros_message(store, f, message), message)), f.t)
    writer.finish()
    expect(name, [f.shown(f"can{f.bus}") for f in CLASSICAL])


def make_json(name):
    writer = mcap_writer(name, use_chunking=False)
    properties = {"timestamp": {"type": "object"}, "id": {"type": "integer"}, "is_extended": {"type": "boolean"},
                  "is_rtr": {"type": "boolean"}, "is_error": {"type": "boolean"}, "is_fd": {"type": "boolean"},
                  "brs": {"type": "boolean"}, "esi": {"type": "boolean"}, "len": {"type": "integer"},
                  "data": {"type": "string", "contentEncoding": "base64"}}
    schema = {"type": "object", "title": "CanFrame", "properties": properties}
    described = writer.register_schema("CanFrame", "jsonschema", json.dumps(schema).encode())
    channels = [writer.register_channel("/can0", "json", described), writer.register_channel("can1", "json", 0)]
    for n, f in enumerate(TRAFFIC):
        data = [base64.b64encode(f.data).decode(), list(f.data), f.data.hex(" ")][0 if f.bus == 0 else n % 2 + 1]
        message = {"timestamp": {"sec": f.t // 10**9, "nsec": f.t % 10**9}, "id": f.id & 0x1FFF_FFFF,
                   "is_extended": bool(f.id & EXT), "is_rtr": bool(f.id & RTR), "is_error": bool(f.id & ERR),
                   "is_fd": f.fd is not None, "brs": bool((f.fd or 0) & 1), "esi": bool((f.fd or 0) & 2),
                   "len": f.dlc, "data": data}
        writer.add_message(channels[f.bus], log_time(f), json.dumps(message).encode(), f.t)
    writer.finish()
    expect(name, [f.shown(f"can{f.bus}") for f in TRAFFIC])


def make_protobuf(name):
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2
    T = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(name="bus.proto", package="fleet.bus", syntax="proto3",
                                              dependency=["google/protobuf/timestamp.proto"])
    event = file.message_type.add(name="Event")
    event.field.add(name="timestamp", number=1, type=T.TYPE_MESSAGE, label=1, type_name=".google.protobuf.Timestamp")
    event.field.add(name="can_frame", number=9, type=T.TYPE_MESSAGE, label=1, type_name=".fleet.bus.Event.CanFrame")
    frame = event.nested_type.add(name="CanFrame")
    for number, (field, kind) in enumerate([("arbitration_id", T.TYPE_FIXED32), ("is_extended_id", T.TYPE_BOOL),
                                            ("is_remote_frame", T.TYPE_BOOL), ("is_error_frame", T.TYPE_BOOL),
                                            ("is_fd", T.TYPE_BOOL), ("bitrate_switch", T.TYPE_BOOL),
                                            ("error_state_indicator", T.TYPE_BOOL), ("dlc", T.TYPE_UINT32)], 1):
        frame.field.add(name=field, number=number, type=kind, label=1)
    frame.field.add(name="data", number=200, type=T.TYPE_UINT32, label=3)
    files = descriptor_pb2.FileDescriptorSet()
    timestamp_pb2.DESCRIPTOR.CopyToProto(files.file.add())
    files.file.add().CopyFrom(file)
    pool = descriptor_pool.DescriptorPool()
    for each in files.file:
        pool.Add(each)
    Event = message_factory.GetMessageClass(pool.FindMessageTypeByName("fleet.bus.Event"))
    writer = mcap_writer(name, use_chunking=False)
    schema = writer.register_schema("fleet.bus.Event", "protobuf", files.SerializeToString())
    channels = [writer.register_channel(f"can{bus}", "protobuf", schema) for bus in (0, 1)]
    for f in TRAFFIC:
        message = Event()
        message.timestamp.seconds, message.timestamp.nanos = f.t // 10**9, f.t % 10**9
        c = message.can_frame
        c.arbitration_id, c.is_extended_id = f.id & 0x1FFF_FFFF, bool(f.id & EXT)
        c.is_remote_frame, c.is_error_frame = bool(f.id & RTR), bool(f.id & ERR)
        c.is_fd, c.bitrate_switch, c.error_state_indicator = f.fd is not None, bool((f.fd or 0) & 1), bool((f.fd or 0) & 2)
        c.dlc = f.dlc
        c.data.extend(f.data)
        writer.add_message(channels[f.bus], log_time(f), message.SerializeToString(), f.t)
    writer.finish()
    expect(name, [f.shown(f"can{f.bus}") for f in TRAFFIC])


def make_mcap():
    from mcap.writer import CompressionType, IndexType
    frame = lambda f: "can_msgs/msg/Frame" if f.fd is None else "ros2_socketcan_msgs/msg/FdFrame"
    make_ros2("ros2-zstd.mcap", TRAFFIC, frame, compression=CompressionType.ZSTD, chunk_size=600)
    make_ros2("ros2-lz4.mcap", TRAFFIC, frame, compression=CompressionType.LZ4, chunk_size=600)
    make_ros2("ros2-plain.mcap", TRAFFIC, frame, compression=CompressionType.NONE, chunk_size=600)
    make_ros2("ros2-unchunked.mcap", TRAFFIC, frame, use_chunking=False)
    make_ros2("vendor.mcap", CLASSICAL, lambda f: "vendor_msgs/msg/CanEvent")
    make_ros1("ros1.mcap")
    make_json("json.mcap")
    make_protobuf("protobuf.mcap")


def message(f):
    import can
    return can.Message(timestamp=f.t / 1e9, channel=f.bus, arbitration_id=f.id & 0x1FFF_FFFF,
                       is_extended_id=bool(f.id & EXT), is_remote_frame=bool(f.id & RTR),
                       is_error_frame=bool(f.id & ERR), is_fd=f.fd is not None, bitrate_switch=bool((f.fd or 0) & 1),
                       error_state_indicator=bool((f.fd or 0) & 2), dlc=f.dlc, data=f.data, is_rx=f.bus == 0)


def make_mf4():
    """Plain, deflated, and transposed records. python-can writes a group for data, remote and error frames each."""
    import asammdf, can
    for name, level in [("python-can-plain.mf4", 0), ("python-can-deflated.mf4", 1), ("python-can.mf4", 2)]:
        with can.MF4Writer(str(HERE / name), compression_level=level) as writer:
            for f in TRAFFIC:
                writer.on_message_received(message(f))
        # python-can reckons with seconds since 1970 in floating point: the nanoseconds that are in the file.
        mdf = asammdf.MDF(str(HERE / name))
        times = [t for group in range(len(mdf.groups)) for t in mdf.get_master(group)]
        times = sorted(mdf.header.abs_time + round(t * 1e9) for t in times)
        lines = []
        for m in sorted(can.MF4Reader(str(HERE / name)), key=lambda m: m.timestamp):
            can_id = 0x80 | ERR if m.is_error_frame else m.arbitration_id | (EXT if m.is_extended_id else 0) | \
                (RTR if m.is_remote_frame else 0)
            fd = m.bitrate_switch | m.error_state_indicator << 1 if m.is_fd else None
            data = b"" if m.is_error_frame else bytes(m.data)
            way = "Rx" if m.is_rx else "Tx"
            lines.append(show(int(times[len(lines)]), str(m.channel), can_id, data, fd, m.dlc, way))
        expect(name, lines)


def make_blf():
    import can

    for name, options in [("python-can.blf", {}), ("python-can-plain.blf", {"compression_level": 0}),
                          ("python-can-small-containers.blf", {"max_container_size": 100})]:
        with can.BLFWriter(str(HERE / name), **options) as writer:
            for f in TRAFFIC:
                writer.on_message_received(message(f))
        # python-can reckons in floating point: the nanoseconds that its writer puts into the file.
        start = int(TRAFFIC[0].t / 1e9 * 1000) / 1000
        times = [int(start) * 10**9 + int((f.t / 1e9 - start) * 1e9) for f in TRAFFIC]
        lines = []
        for m in can.BLFReader(str(HERE / name)):
            can_id = m.arbitration_id | (EXT if m.is_extended_id else 0) | (RTR if m.is_remote_frame else 0) | \
                (ERR if m.is_error_frame else 0)
            # The format has no direction of error frames.
            way = "" if m.is_error_frame else "Rx" if m.is_rx else "Tx"
            fd = m.bitrate_switch | m.error_state_indicator << 1 if m.is_fd else None
            lines.append(show(times[len(lines)], str(m.channel + 1), can_id, bytes(m.data), fd, m.dlc, way))
        expect(name, lines)


def make_sqlite():
    """Pages of the usual size, and of the smallest: then the table is a tree, and long rows have overflow pages."""
    import can, sqlite3
    for name, size in [("python-can.db", 4096), ("python-can-small-pages.db", 512)]:
        path = HERE / name
        path.unlink(missing_ok=True)
        with sqlite3.connect(path) as db:
            db.execute(f"PRAGMA page_size = {size}")
            db.execute("VACUUM")
        with can.SqliteWriter(str(path)) as writer:
            for f in TRAFFIC:
                writer.on_message_received(message(f))
        lines = []
        for m in can.SqliteReader(str(path)):
            can_id = m.arbitration_id | (EXT if m.is_extended_id else 0) | (RTR if m.is_remote_frame else 0) | \
                (ERR if m.is_error_frame else 0)
            # The format does not tell CAN FD from classical frames.
            fd = 0 if m.dlc > 8 else None
            lines.append(show(round(m.timestamp * 1e6) * 1000, "1", can_id, bytes(m.data), fd, m.dlc))
        expect(name, lines)
    # Another table, name and order of columns, and rows that need overflow pages.
    path = HERE / "long-rows.sqlite"
    path.unlink(missing_ok=True)
    with sqlite3.connect(path) as db:
        db.execute("PRAGMA page_size = 512")
        db.execute("CREATE TABLE notes (ts REAL, text TEXT)")
        db.execute('CREATE TABLE "bus 1" (note TEXT, "data" BLOB, dlc INTEGER, error INTEGER, remote INTEGER, '
                   "extended INTEGER, arbitration_id INTEGER, ts REAL)")
        for n in range(8):
            db.execute('INSERT INTO "bus 1" VALUES (?, ?, ?, 0, 0, ?, ?, ?)',
                       ("x" * 300 * n, bytes(range(n)), n, n % 2, 0x181 + n, n / 10))
    db.close()
    lines = []
    for _, data, dlc, _, _, extended, can_id, ts in sqlite3.connect(path).execute('SELECT * FROM "bus 1"'):
        lines.append(show(round(ts * 1e9), "1", can_id | (EXT if extended else 0), data, None, dlc))
    expect(path.name, lines)


PARTS = {"pcap": make_pcap, "unclean": make_unclean, "pcapng": make_pcapng, "mcap": make_mcap, "blf": make_blf,
         "mf4": make_mf4, "sqlite": make_sqlite}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
