"""What the program does with captures and devices: diagnosis, conformance tests, fuzzing."""

from __future__ import annotations

import contextlib
import json
import os
from typing import Any, Iterable, Iterator, Optional, Sequence, Tuple, Union

from canvass.captures import Devices, StrPath
from canvass.devices import Device
from canvass.program import run, run_with_status
from canvass.results import Diagnosis, FuzzRun, TestRun


def diagnose(*paths: StrPath, device: Optional[Devices] = None, options: Sequence[str] = ()) -> Diagnosis:
    """Find what is wrong in captures, as ``canvass diagnose`` does.

    :param device: the devices of nodes: built-in models, or paths of descriptions
    :param options: further options of the command, such as ``["--from", "+10"]``
    """
    arguments = ["diagnose", *map(os.fspath, paths), "--format", "json", *_devices(device), *options]
    return Diagnosis(json.loads(run(arguments, statuses=(0, 1))))


def test(
    bus: Any,
    *,
    node: Optional[int] = None,
    select: Union[str, Iterable[str], None] = None,
    device: Optional[StrPath] = None,
    waivers: Optional[StrPath] = None,
    allow: Iterable[str] = (),
    seed: Optional[int] = None,
    options: Sequence[str] = (),
) -> TestRun:
    """Test whether a device conforms, as ``canvass test`` does.

    :param bus: an address of canvass (``can0``, ``sim:MODEL``), a :class:`canvass.Device` in real time, or a bus of
        python-can. Nobody else may receive from it meanwhile.
    :param node: the node-ID of the device
    :param select: the cases, such as ``301/sdo``
    :param device: a built-in model, or the path of the device's description
    :param allow: changes that the cases may make, such as ``nvm``
    :raises CanvassError: if the bus or the device could not be reached
    """
    return TestRun(*_on_bus("test", bus, node, device, select, waivers, allow, seed, options))


# pytest does not take the function for a test.
test.__test__ = False  # type: ignore[attr-defined]


def fuzz(
    bus: Any,
    *,
    node: Optional[int] = None,
    target: Optional[str] = None,
    seconds: Optional[float] = None,
    runs: Optional[int] = None,
    seed: Optional[int] = None,
    device: Optional[StrPath] = None,
    allow: Iterable[str] = (),
    options: Sequence[str] = (),
) -> FuzzRun:
    """Send a device unexpected sequences of frames, as ``canvass fuzz`` does."""
    further = [*options]
    if target is not None:
        further += ["--target", target]
    if seconds is not None:
        further += ["--for", f"{round(seconds * 1000)}ms"]
    if runs is not None:
        further += ["--runs", str(runs)]
    return FuzzRun(*_on_bus("fuzz", bus, node, device, None, None, allow, seed, further))


def _on_bus(command, bus, node, device, select, waivers, allow, seed, options) -> Tuple[dict, int]:
    with address(bus) as at:
        arguments = [command, at, "--format", "json"]
        for name, value in [("node", node), ("device", device), ("waivers", waivers), ("seed", seed)]:
            if value is not None:
                arguments += [f"--{name}", os.fspath(value) if name in ("device", "waivers") else str(value)]
        chosen = [select] if isinstance(select, str) else list(select or ())
        if chosen:
            arguments += ["--select", ",".join(chosen)]
        if allow := list(allow):
            arguments += ["--allow", ",".join(allow)]
        printed, status = run_with_status([*arguments, *options], statuses=(0, 1, 3))
    return json.loads(printed), status


@contextlib.contextmanager
def address(bus: Any) -> Iterator[str]:
    """The address under which the program reaches a bus; a device's bus and that of python-can are bridged meanwhile."""
    if isinstance(bus, str):
        yield bus
        return
    from canvass.bridge import Bridge

    with contextlib.ExitStack() as opened:
        if isinstance(bus, Device):
            bus = opened.enter_context(bus.bus())
        if not getattr(bus, "real_time", True):
            raise ValueError(
                f"the program can't follow the virtual time of this bus: test a new device at its address {bus.address!r}, "
                "or this one with real_time=True"
            )
        yield opened.enter_context(Bridge(bus)).address


def _devices(device: Optional[Devices]) -> list[str]:
    named = (device or {}).items()
    return [argument for node, path in named for argument in ("--device", f"{node}={os.fspath(path)}")]
