"""The interface for python-can: ``can.Bus(interface="canvass", channel="sim:kuebler-sendix-58x8")``."""

from __future__ import annotations

import time
from typing import Any, Optional, Tuple

import can

from canvass import _native
from canvass.devices import Device

#: The virtual time within which an answer is delivered while a frame is sent, in seconds.
ANSWER = 0.01


class CanvassBus(can.BusABC):
    """A bus with simulated devices.

    :param channel: the address of canvass, ``sim:MODEL[:NODE][@BITRATE][~MOTION][+FAULT...]``, or a
        :class:`canvass.Device`
    :param real_time: whether the bus runs at the pace of this computer's clock. In virtual time nothing waits: time
        advances while frames are received.
    :param receive_own_messages: whether sent frames are received, too
    """

    def __init__(
        self,
        channel: Any,
        *,
        seed: int = 0,
        real_time: bool = True,
        receive_own_messages: bool = False,
        **kwargs: Any,
    ):
        if isinstance(channel, Device):
            self.simulation = channel.simulation
            #: The address of such a bus for the program.
            self.address = channel.address
        else:
            self.address = str(channel)
            self.simulation = _native.Simulation(self.address, seed, real_time)
        self.channel_info = f"canvass {self.address}"
        self._own = receive_own_messages
        #: Whether the bus runs at the pace of this computer's clock.
        self.real_time = channel.real_time if isinstance(channel, Device) else real_time
        # Times of frames are seconds since 1970, as on other interfaces.
        self._began = time.time() - self.simulation.now
        super().__init__(channel=self.address, **kwargs)

    def _recv_internal(self, timeout: Optional[float]) -> Tuple[Optional[can.Message], bool]:
        frame = self.simulation.receive_raw(timeout, self._own)
        if frame is None:
            return None, False
        return self._message(frame), False

    def _message(self, frame: tuple) -> can.Message:
        now, can_id, extended, remote, length, data, is_rx = frame
        return can.Message(
            timestamp=self._began + now,
            arbitration_id=can_id,
            is_extended_id=extended,
            is_remote_frame=remote,
            dlc=length,
            data=data,
            channel=self.address,
            is_rx=is_rx,
        )

    def send(self, msg: can.Message, timeout: Optional[float] = None) -> None:
        if msg.is_fd or msg.is_error_frame:
            raise can.CanOperationError("expected a classical data or remote frame")
        try:
            self.simulation.send(
                msg.arbitration_id, bytes(msg.data), msg.is_extended_id, msg.is_remote_frame, msg.dlc
            )
        except ValueError as error:
            raise can.CanOperationError(str(error)) from error
        if not self.real_time:
            self._answer()

    def _answer(self) -> None:
        """Give the listeners of notifiers the answer at once.

        In virtual time the answer is there as soon as it is asked for. Waking the notifier's thread for it would take
        far longer than everything else.
        """
        listeners = [listener for notifier in can.Notifier.find_instances(self) for listener in notifier.listeners]
        if not listeners:
            return
        frame = self.simulation.answer(ANSWER)
        if frame is not None:
            message = self._message(frame)
            for listener in listeners:
                listener(message)

    @staticmethod
    def _detect_available_configs() -> list:
        return [{"interface": "canvass", "channel": f"sim:{model}"} for model, _ in _native.models()]
