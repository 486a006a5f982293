"""Device descriptions: EDS, DCF, XDD, XDC, and the built-in models."""

from __future__ import annotations

import json
import os
from typing import Any, Iterator, NamedTuple, Optional

from canvass import _native
from canvass.captures import StrPath
from canvass.program import run
from canvass.results import Result


class Entry(NamedTuple):
    """An entry of the object dictionary."""

    index: int
    sub: int
    #: The name of the object, and that of the sub-index.
    object: str
    name: str
    #: The data type, such as ``UNSIGNED32``.
    type: str
    #: ``ro``, ``rw``, ``wo``, ``const``, ``rwr`` or ``rww``.
    access: str
    #: Whether a PDO may carry it.
    pdo: bool
    default: Optional[str]
    low: Optional[str]
    high: Optional[str]
    #: The value of a configured device (DCF, XDC).
    value: Optional[str]


class Description:
    """A device description, or the description of a built-in model.

    :raises OSError: if there is neither such a model nor such a file
    :raises ValueError: if the file describes no device
    """

    def __init__(self, device: StrPath):
        self.device = os.fspath(device)
        self.entries = [Entry(**row) for row in _native.objects(self.device)]
        self._places = {(entry.index, entry.sub): entry for entry in self.entries}

    def __iter__(self) -> Iterator[Entry]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __getitem__(self, place: Any) -> Entry:
        """An entry by index, or by index and sub-index: ``description[0x1018, 1]``."""
        index, sub = place if isinstance(place, tuple) else (place, 0)
        return self._places[index, sub]

    def __contains__(self, place: Any) -> bool:
        index, sub = place if isinstance(place, tuple) else (place, 0)
        return (index, sub) in self._places

    def check(self) -> list[Result]:
        """The findings of ``canvass eds check`` in the file."""
        printed = run(["eds", "check", self.device, "--format", "json"], statuses=(0, 1))
        return [Result(finding) for finding in json.loads(printed)["findings"]]
