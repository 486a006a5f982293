"""The device as its user sees it through python-canopen."""

import dataclasses

import canopen
from canopen.objectdictionary import ODVariable


class Silent(Exception):
    """The device does not answer."""


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """What a user can see of the device."""

    values: dict
    """By index and sub-index: the bytes, or the abort code."""

    state: str | None
    """The NMT state that heartbeats or node guarding tell; None where neither comes."""


class Subject:
    """A device on a network of python-canopen."""

    def __init__(self, network, node_id, eds, guards=True):
        """`guards`: a device without heartbeats is asked for its state by node guarding. It then expects to be asked again, and
        may leave operational if it is not: only for a device that is looked at and then gone back from."""
        self.network, self._guards = network, guards
        self.description = canopen.import_od(eds, node_id)
        self.node = network.attach(node_id, self.description)
        self._heard = None
        network.subscribe(0x700 + node_id, self._on_error_control)

    def _on_error_control(self, _can_id, data, _timestamp):
        self._heard = canopen.nmt.NMT_STATES.get(data[0] & 0x7F) if data else None

    def variables(self):
        for entry in self.description.values():
            # An entry without a description of its parts, such as a dummy of a mapping, can't be asked for.
            if entry.index < 0x1000:
                continue
            yield from [entry] if isinstance(entry, ODVariable) else entry.values()

    def encode(self, at, value):
        """The bytes of a value by the type of its object."""
        return self.description.get_variable(*at).encode_raw(value)

    def read(self, index, sub):
        """The bytes of an object, or the abort code."""
        try:
            return self.node.sdo.upload(index, sub)
        except canopen.SdoAbortedError as error:
            return f"abort {error.code:08X}"
        except canopen.SdoCommunicationError as error:
            raise Silent(f"{index:04X}h:{sub:02X}: {error}") from error

    def write(self, index, sub, value):
        """Whether the device took it."""
        try:
            self.node.sdo.download(index, sub, value)
        except canopen.SdoAbortedError:
            return False
        except canopen.SdoCommunicationError as error:
            raise Silent(f"{index:04X}h:{sub:02X}: {error}") from error
        return True

    def look(self):
        """All that can be read, after two and a half seconds in which heartbeats may come."""
        self._heard = None
        self.network.hear(2.5)
        if self._heard is None and self._guards:
            self.network.send_message(0x700 + self.node.id, b"", remote=True)
            self.network.hear(0.1)
        readable = [(variable.index, variable.subindex) for variable in self.variables() if variable.readable]
        return Snapshot({at: self.read(*at) for at in readable}, self._heard)
