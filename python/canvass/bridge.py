"""Connects canvass to a bus of python-can.

canvass's program reaches the bus as an SLCAN adapter at a TCP port of this machine. This file needs only python-can;
the program starts it for ``python:INTERFACE:CHANNEL`` with the interpreter of the environment.
"""

import argparse
import signal
import socket
import sys
import threading

import can

# The answers to the commands of SLCAN: version, serial number, status flags; all others are only confirmed.
ANSWERS = {b"V": b"V1013\r", b"N": b"NPYCA\r", b"F": b"F00\r"}
# Longest wait for a frame, after which a thread looks whether it should end.
LOOK = 0.1


class Bridge:
    """An SLCAN adapter whose bus is a bus of python-can.

    :param bus: the bus. Nobody else may receive from it meanwhile.
    """

    def __init__(self, bus):
        self._bus = bus
        self._listener = socket.socket()
        self._listener.bind(("127.0.0.1", 0))
        self._listener.listen(1)
        #: The address for the program.
        self.address = "slcan:tcp://127.0.0.1:%d" % self._listener.getsockname()[1]
        self._ended = threading.Event()
        self._client = None
        self._stamps = False
        self._lock = threading.Lock()
        #: The error that ended the connection to the bus.
        self.failure = None
        self._threads = [
            threading.Thread(target=self._accept, name="canvass bridge", daemon=True),
            threading.Thread(target=self._receive, name="canvass bus", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """End the connection; the bus stays open."""
        self._ended.set()
        self._listener.close()
        self._drop()
        for thread in self._threads:
            thread.join(timeout=2)

    def wait(self):
        """Wait until the program has ended the connection."""
        self._threads[0].join()

    def _drop(self):
        client, self._client = self._client, None
        if client is not None:
            client.close()

    def _accept(self):
        self._listener.settimeout(LOOK)
        while not self._ended.is_set():
            try:
                client, _ = self._listener.accept()
            except socket.timeout:
                continue
            except OSError:
                return
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client.settimeout(LOOK)
            self._client = client
            self._serve(client)
            self._drop()

    def _serve(self, client):
        """Take lines from the program until it leaves."""
        waiting = b""
        while not self._ended.is_set():
            try:
                read = client.recv(65536)
            except socket.timeout:
                continue
            except OSError:
                return
            if not read:
                return
            *lines, waiting = (waiting + read).split(b"\r")
            for line in lines:
                self._line(line)

    def _line(self, line):
        kind = line[:1]
        if kind not in b"tTrR" or not kind:
            if kind == b"Z":
                self._stamps = line == b"Z1"
            self._write(ANSWERS.get(kind, b"\r"))
            return
        try:
            self._bus.send(message(line))
        except (can.CanError, ValueError, IndexError) as error:
            self.failure = error
            # The status flag "transmit queue full": the frame was not sent.
            self._write(b"F02\r")

    def _receive(self):
        while not self._ended.is_set():
            try:
                received = self._bus.recv(LOOK)
            except (can.CanError, OSError) as error:
                self.failure = error
                self._drop()
                return
            if received is not None and received.is_rx and not (received.is_error_frame or received.is_fd):
                self._write(line_of(received, self._stamps))

    def _write(self, line):
        client = self._client
        if client is None:
            return
        with self._lock:
            try:
                client.sendall(line)
            except OSError:
                self._drop()


def message(line):
    """The frame of an SLCAN line."""
    text = line.decode("ascii")
    digits = 8 if text[0] in "TR" else 3
    length = int(text[1 + digits], 16)
    remote = text[0] in "rR"
    return can.Message(
        arbitration_id=int(text[1 : 1 + digits], 16),
        is_extended_id=digits == 8,
        is_remote_frame=remote,
        dlc=length,
        data=None if remote else bytes.fromhex(text[2 + digits : 2 + digits + 2 * length]),
    )


def line_of(received, stamps):
    """The SLCAN line of a frame, with the milliseconds of its minute if they are wanted and known."""
    kind = ("R" if received.is_extended_id else "r") if received.is_remote_frame else (
        "T" if received.is_extended_id else "t"
    )
    width = 8 if received.is_extended_id else 3
    data = "" if received.is_remote_frame else bytes(received.data).hex().upper()
    stamp = "%04X" % (int(received.timestamp * 1000) % 60000) if stamps and received.timestamp else ""
    return ("%s%0*X%X%s%s\r" % (kind, width, received.arbitration_id, received.dlc, data, stamp)).encode()


def main():
    """Open a bus of python-can, and serve one program."""
    # Ctrl-C reaches this process, too. The program needs the bus until it has put the device back, and then ends this.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--interface", required=True)
    parser.add_argument("--channel", required=True)
    parser.add_argument("--bitrate", type=int)
    options = parser.parse_args()
    channel = int(options.channel) if options.channel.isdigit() else options.channel
    settings = {} if options.bitrate is None else {"bitrate": options.bitrate}
    try:
        bus = can.Bus(interface=options.interface, channel=channel, **settings)
    except Exception as error:  # Each interface has errors of its own.
        sys.exit("python-can can't open %s %s: %s" % (options.interface, options.channel, error))
    with bus, Bridge(bus) as bridge:
        print(bridge.address, flush=True)
        # The program closes this process's standard input when it ends.
        sys.stdin.read()


if __name__ == "__main__":
    main()
