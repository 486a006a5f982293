"""Captures: frames, decoded frames, and tables for data frames."""

from __future__ import annotations

import os
from typing import Iterator, Mapping, Optional, Union

from canvass import _native

StrPath = Union[str, "os.PathLike[str]"]
#: The devices of nodes: ``{5: "encoder.eds"}``, ``{"5-8": "kuebler-sendix-58x8"}``.
Devices = Mapping[Union[int, str], StrPath]


class Capture:
    """A capture of any format that canvass reads, or several captures merged by time.

    It is read while it is iterated, each time from its beginning. Unreadable parts are skipped and noted in
    :attr:`damages`.
    """

    def __init__(self, *paths: StrPath, device: Optional[Devices] = None, format: Optional[str] = None):
        if not paths:
            raise ValueError("expected at least one file")
        devices = [(str(node), os.fspath(named)) for node, named in (device or {}).items()]
        self._native = _native.Capture([os.fspath(path) for path in paths], devices, format)

    def __iter__(self) -> Iterator[_native.Frame]:
        return iter(self._native)

    def __repr__(self) -> str:
        return repr(self._native)

    def decode(self) -> Iterator[_native.Message]:
        """The decoded frames, one after the other."""
        return self._native.decode()

    @property
    def frames(self) -> _native.Table:
        """The frames as they were recorded: a table for pandas, Polars, PyArrow or DuckDB."""
        return self._native.table("frames")

    @property
    def messages(self) -> _native.Table:
        """The decoded frames, as a table."""
        return self._native.table("messages")

    @property
    def events(self) -> _native.Table:
        """Whole SDO transfers, states, errors and layer setting, as a table."""
        return self._native.table("events")

    @property
    def signals(self) -> _native.Table:
        """The values of process data, as a table with a row for each value."""
        return self._native.table("signals")

    @property
    def damages(self) -> list[str]:
        """The first 1000 unreadable parts that the latest reading has met, each with its place."""
        return self._native.damages

    @property
    def damage_count(self) -> int:
        """The number of unreadable parts that the latest reading has met."""
        return self._native.damage_count


def read(*paths: StrPath, device: Optional[Devices] = None, format: Optional[str] = None) -> Capture:
    """Open captures, merged by time.

    :param paths: files of any format that canvass reads
    :param device: the devices of nodes: built-in models, or paths of EDS, DCF, XDD or XDC files
    :param format: the id of the format (``canvass list formats``), if the content does not show it
    :raises OSError: if a file can't be opened or is no capture
    """
    return Capture(*paths, device=device, format=format)


def decode(*paths: StrPath, device: Optional[Devices] = None, format: Optional[str] = None) -> Iterator[_native.Message]:
    """The decoded frames of captures, one after the other."""
    return read(*paths, device=device, format=format).decode()
