"""The library for Robot Framework.

| *** Settings ***
| Library    canvass.robot.Canvass    bus=can0    node=5
"""

from __future__ import annotations

import json
from typing import Optional

from robot.api import Failure, logger
from robot.api.deco import keyword, library

from canvass import runs
from canvass.program import CanvassError, run


@library(scope="SUITE", version="0.1.0", doc_format="ROBOT")
class Canvass:
    """CANopen devices and captures.

    ``bus`` is an address of canvass, such as ``can0``, ``slcan:/dev/ttyACM0@250k``, ``python:kvaser:0@250k`` or
    ``sim:kuebler-sendix-58x8``. ``node`` is the node-ID of the device; keywords with the argument ``node`` can name
    another one. ``device`` is a built-in model or the path of the device's description; it gives objects names and types.

    Example:
    | *** Settings ***
    | Library    canvass.robot.Canvass    bus=can0    node=5
    | *** Test Cases ***
    | The Encoder Conforms
    |     Device Should Conform    301/sdo
    | The Vendor Is Known
    |     ${vendor} =    Read Object    1018:01
    |     Should Be Equal As Integers    ${vendor}    19
    """

    def __init__(self, bus: Optional[str] = None, node: Optional[int] = None, device: Optional[str] = None):
        self._bus, self._node, self._device = bus, node, device

    @keyword
    def use_device(self, bus: str, node: Optional[int] = None, device: Optional[str] = None) -> None:
        """Chooses another device for the keywords that follow."""
        self._bus, self._node, self._device = bus, node, device

    @keyword
    def read_object(self, object: str, node: Optional[int] = None):
        """Reads an object by SDO and returns its value: a number or a text.

        ``object`` is ``INDEX:SUB`` in hexadecimal, such as ``1018:01``, or a name of the description.
        """
        printed = self._run(["sdo", "read", *self._target(node), object, "--format", "json", *self._description()])
        document = json.loads(printed)
        logger.info(document.get("text", ""))
        return document.get("value", document.get("text"))

    @keyword
    def write_object(self, object: str, value: str, node: Optional[int] = None) -> None:
        """Writes an object by SDO. The device keeps the value until a reset, or for good if it stores it."""
        self._run(["sdo", "write", *self._target(node), object, str(value), *self._description()])

    @keyword
    def send_nmt_command(self, command: str, node: Optional[str] = None) -> None:
        """Sends ``start``, ``stop``, ``pre-operational``, ``reset-node`` or ``reset-communication``, to a node or ``all``."""
        target = str(node or self._node or "all")
        logger.info(self._run(["nmt", self._address(), command, target]).decode())

    @keyword
    def device_should_conform(self, select: Optional[str] = None, waivers: Optional[str] = None, allow: str = "") -> None:
        """Runs conformance cases, and fails unless the device passes: a case that fails or can't be decided fails it.

        ``select`` names the cases, such as ``301/sdo`` (default: all). ``waivers`` is the path of a file with waivers.
        """
        result = self._test(select, waivers, allow)
        for case in result.cases:
            if case.verdict not in ("pass", "tolerated", "not_applicable"):
                logger.warn(str(case))
        if not result.passed:
            raise Failure(result.why)

    @keyword
    def run_conformance_cases(self, select: Optional[str] = None, waivers: Optional[str] = None, allow: str = ""):
        """Runs conformance cases and returns the result: ``${result.failures}``, ``${result.cases}``."""
        return self._test(select, waivers, allow)

    @keyword
    def device_should_withstand_fuzzing(self, seconds: float = 10, target: str = "all") -> None:
        """Sends the device unexpected frames, and fails if a violation is confirmed."""
        result = runs.fuzz(self._address(), node=self._node, device=self._device, seconds=seconds, target=target)
        if not result.passed:
            raise Failure(result.why)

    @keyword
    def diagnose_capture(self, path: str):
        """Returns what is wrong in a capture: ``${diagnosis.findings}``."""
        return runs.diagnose(path)

    @keyword
    def capture_should_be_healthy(self, path: str) -> None:
        """Fails if a capture has findings of severity *error*."""
        errors = runs.diagnose(path).errors
        if errors:
            raise Failure("\n".join(str(finding) for finding in errors))

    def _test(self, select, waivers, allow):
        allowed = [word for word in allow.split(",") if word]
        return runs.test(
            self._address(), node=self._node, device=self._device, select=select, waivers=waivers, allow=allowed
        )

    def _address(self) -> str:
        if self._bus is None:
            raise Failure("name the bus of the device: Use Device, or the argument bus of the library")
        return self._bus

    def _target(self, node: Optional[int]) -> list:
        chosen = node or self._node
        if chosen is None:
            raise Failure("name the node: the argument node of the keyword or of the library")
        return [self._address(), str(chosen)]

    def _description(self) -> list:
        return [] if self._device is None else ["--device", self._device]

    def _run(self, arguments: list) -> bytes:
        try:
            return run(arguments)
        except CanvassError as error:
            raise Failure(str(error)) from error
