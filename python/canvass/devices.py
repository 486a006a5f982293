"""Simulated devices."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Iterable, Optional

from canvass import _native
from canvass.captures import StrPath

if TYPE_CHECKING:
    from canvass.can import CanvassBus


class Device:
    """A simulated device with its own bus.

    :param model: a built-in model (``canvass list models``), or the path of a description
    :param node: the node-ID (default: that of the model as delivered)
    :param faults: faults of the firmware (``canvass list faults``)
    :param liberties: unusual behaviour that the standard allows (``canvass list liberties``)
    :param motion: what the device measures: ``still=1000``, ``rpm=60``, ``sine=2,10``, ...
    :param real_time: whether the bus runs at the pace of this computer's clock. In virtual time nothing waits.
    :param seed: determines random choices of the device
    """

    def __init__(
        self,
        model: StrPath,
        *,
        node: Optional[int] = None,
        bit_rate: Optional[int] = None,
        faults: Iterable[str] = (),
        liberties: Iterable[str] = (),
        motion: Optional[str] = None,
        real_time: bool = True,
        seed: int = 0,
    ):
        self.model = os.fspath(model)
        #: Whether the bus runs at the pace of this computer's clock.
        self.real_time = real_time
        address = f"sim:{self.model}"
        if node is not None:
            address += f":{node}"
        if bit_rate is not None:
            address += f"@{bit_rate}"
        if motion is not None:
            address += f"~{motion}"
        address += "".join(f"~~{liberty}" for liberty in liberties)
        address += "".join(f"+{fault}" for fault in faults)
        #: The address at which the program makes a new device of this kind.
        self.address = address
        self.simulation = _native.Simulation(address, seed, real_time)

    @property
    def node(self) -> Optional[int]:
        """The present node-ID; ``None`` while LSS has given none."""
        return self.simulation.devices[0][0]

    def bus(self, **options) -> "CanvassBus":
        """The device's bus for python-can."""
        from canvass.can import CanvassBus

        return CanvassBus(self, **options)

    def set_error(self, code: int) -> None:
        """Raise the hardware error with this EMCY code."""
        self.simulation.set_error(code, True)

    def clear_error(self, code: int) -> None:
        """Take the hardware error back."""
        self.simulation.set_error(code, False)

    def move(self, motion: str) -> None:
        """Set what the device measures from now on, such as ``rpm=60``."""
        self.simulation.set_motion(motion)

    def power_cycle(self) -> None:
        """Switch the supply off and on."""
        self.simulation.power_cycle()

    def __repr__(self) -> str:
        return f"<Device {self.address}>"
