"""What the tests share."""

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def commissioning() -> Path:
    """A capture of an encoder that is commissioned by LSS and SDO."""
    return ROOT / "docs/examples/commissioning.log"


@pytest.fixture
def rising(tmp_path) -> Path:
    """TPDO 2 of node 5 a hundred times a second for 2 s: a position that rises by one step each time."""
    path = tmp_path / "rising.log"
    lines = (f"({n / 100:.6f}) can0 285#{n.to_bytes(4, 'little').hex().upper()}0000\n" for n in range(200))
    path.write_text("".join(lines))
    return path
