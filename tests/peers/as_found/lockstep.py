"""The simulated device in virtual time as a bus of python-can, and python-canopen on it."""

import collections
import json
import subprocess

import can
import canopen

SILENCE_US = 3_000
"""A device that has not answered by then answers while it is waited for."""

PATIENCE = 12.0
"""Seconds for an answer: the slowest model is silent for three seconds while it stores."""


class Lockstep:
    """The program `lockstep`: a request and its answer, a JSON object a line each."""

    def __init__(self, program):
        self._process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)

    def ask(self, do, **words):
        self._process.stdin.write(json.dumps({"do": do, **words}) + "\n")
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"lockstep ended with {self._process.wait()} at {do} {words}")
        answer = json.loads(line)
        if "error" in answer:
            raise RuntimeError(f"{do} {words}: {answer['error']}")
        return answer

    def close(self):
        self._process.stdin.close()
        self._process.wait()


class LockstepBus(can.BusABC):
    """Time passes on it while something is sent or waited for, and never else."""

    def __init__(self, lockstep):
        super().__init__(channel="lockstep")
        self.channel_info = "a simulated device in virtual time"
        self._lockstep = lockstep
        self._received = collections.deque()
        self.now = 0.0
        """Seconds since the device was first switched on."""

    def send(self, msg, timeout=None):
        data = f"R{msg.dlc or ''}" if msg.is_remote_frame else msg.data.hex()
        frame = f"{msg.arbitration_id:03X}#{data}"
        self._take(self._lockstep.ask("send", frame=frame, silence_us=SILENCE_US))

    def recv(self, timeout=None):
        """The next frame; waits only if none is there, and then the whole time."""
        if not self._received and timeout:
            self._take(self._lockstep.ask("wait", ms=round(timeout * 1_000)))
        return self._received.popleft() if self._received else None

    def forget(self, nanoseconds):
        """It is another time: frames of a state that was left are of no concern any more."""
        self._received.clear()
        self.now = nanoseconds / 1e9

    def _take(self, answer):
        self.now = answer["now"] / 1e9
        for frame in answer["frames"]:
            identifier, _, data = frame.partition("#")
            is_remote = data.startswith("R")
            self._received.append(
                can.Message(
                    timestamp=self.now,
                    arbitration_id=int(identifier, 16),
                    is_extended_id=len(identifier) > 3,
                    is_remote_frame=is_remote,
                    data=b"" if is_remote else bytes.fromhex(data),
                )
            )


class Network(canopen.Network):
    """A network of python-canopen that hands on what was received whenever something was sent or waited for."""

    def __init__(self, lockstep):
        super().__init__(LockstepBus(lockstep))

    def send_message(self, can_id, data, remote=False):
        super().send_message(can_id, data, remote)
        self.hear(0)

    def now(self):
        """Seconds on the clock of the bus."""
        return self.bus.now

    def hear(self, seconds):
        """Lets that time pass."""
        while (message := self.bus.recv(seconds)) is not None:
            self.notify(message.arbitration_id, message.data, message.timestamp)
            seconds = 0

    def attach(self, node_id, description):
        """A node whose client waits for answers in virtual time."""
        node = self.add_node(canopen.RemoteNode(node_id, description))
        client, read_response = node.sdo, node.sdo.read_response
        client.RESPONSE_TIMEOUT = 0.001

        def patient():
            step, waited = 0.01, 0.0
            while client.responses.empty() and waited < PATIENCE:
                self.hear(step)
                step, waited = step * 2, waited + step
            return read_response()

        client.read_response = patient
        return node
