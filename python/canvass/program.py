"""The program ``canvass``, which the wheel brings along."""

from __future__ import annotations

import os
import shutil
import subprocess
import sysconfig
from pathlib import Path
from typing import Iterable, Optional, Tuple

#: The environment variable that names another program.
PROGRAM = "CANVASS_PROGRAM"


class CanvassError(Exception):
    """The program could not do what it was asked for.

    ``status`` is its exit status: 2 for a mistake in the request or its files, 3 if the bus or the device could not
    be reached.
    """

    def __init__(self, message: str, status: Optional[int] = None):
        super().__init__(message)
        self.status = status


def path() -> Path:
    """The program: that of ``CANVASS_PROGRAM``, else that of this environment, else the first one on ``PATH``."""
    named = os.environ.get(PROGRAM)
    if named:
        return Path(named)
    name = "canvass.exe" if os.name == "nt" else "canvass"
    schemes = ["scripts"]
    folders = [sysconfig.get_path(scheme) for scheme in schemes]
    user = {"nt": "nt_user"}.get(os.name, "posix_user")
    if user in sysconfig.get_scheme_names():
        folders.append(sysconfig.get_path("scripts", user))
    for folder in folders:
        candidate = Path(folder) / name
        if candidate.is_file():
            return candidate
    found = shutil.which("canvass")
    if found is None:
        raise CanvassError(f"there is no program canvass: install the wheel, or name the program in {PROGRAM}")
    return Path(found)


def run(arguments: Iterable[str], *, input: Optional[bytes] = None, statuses: Iterable[int] = (0,)) -> bytes:
    """Run the program; return what it has printed.

    :raises CanvassError: if its exit status is none of ``statuses``, with the message that it has printed.
    """
    return run_with_status(arguments, input=input, statuses=statuses)[0]


def run_with_status(
    arguments: Iterable[str], *, input: Optional[bytes] = None, statuses: Iterable[int] = (0,)
) -> Tuple[bytes, int]:
    """As :func:`run`; return the exit status, too."""
    done = subprocess.run([str(path()), *map(str, arguments)], input=input, capture_output=True, check=False)
    is_refused = done.returncode != 0 and not done.stdout
    if is_refused or done.returncode not in tuple(statuses):
        message = done.stderr.decode("utf-8", "replace").strip() or f"exit status {done.returncode}"
        raise CanvassError(message, done.returncode)
    return done.stdout, done.returncode
