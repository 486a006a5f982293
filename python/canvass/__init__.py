"""CANopen: conformance tests, trace analysis and simulated devices.

>>> import canvass
>>> canvass.Device("kuebler-sendix-58x8").model
'kuebler-sendix-58x8'

Captures: :func:`read`, :func:`decode`, :func:`diagnose`. Devices: :class:`Device`, :func:`test`, :func:`fuzz`.
Descriptions: :class:`Description`. The interface for python-can is ``can.Bus(interface="canvass", channel="sim:MODEL")``.
"""

from canvass._native import Frame, Message, Simulation, Table, __version__, models
from canvass.captures import Capture, decode, read
from canvass.descriptions import Description
from canvass.devices import Device
from canvass.program import CanvassError, path, run
from canvass.results import Case, Diagnosis, Finding, FuzzRun, Result, TestRun
from canvass.runs import diagnose, fuzz, test

__all__ = [
    "CanvassError",
    "Capture",
    "Case",
    "Description",
    "Device",
    "Diagnosis",
    "Finding",
    "Frame",
    "FuzzRun",
    "Message",
    "Result",
    "Simulation",
    "Table",
    "TestRun",
    "__version__",
    "decode",
    "diagnose",
    "fuzz",
    "models",
    "path",
    "read",
    "run",
    "test",
]
