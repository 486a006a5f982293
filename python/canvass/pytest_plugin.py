"""The plugin for pytest.

``pytest --canvass-bus can0 --canvass-node 5`` runs the conformance cases as tests, one for each case, beside the
project's own tests. The fixtures ``can_bus``, ``canopen_device`` and ``capture`` serve the project's own tests on the
same device.
"""

from __future__ import annotations

import datetime
import json
from pathlib import Path
from typing import Any, Iterator, Optional

import pytest

from canvass import runs
from canvass.program import CanvassError, run
from canvass.results import Case, Diagnosis, TestRun

#: Verdicts with which a test ends well, and those that pytest shows as expected failures.
GOOD = ("pass", "tolerated")
EXPECTED = ("deviation",)
SKIPPED = ("not_applicable",)


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("canvass", "CANopen conformance (canvass)")
    group.addoption("--canvass-bus", metavar="BUS", help="run the conformance cases on the device at this bus")
    group.addoption("--canvass-node", metavar="N", type=int, help="node-ID of the device")
    group.addoption("--canvass-select", metavar="CASES", default=None, help="cases, such as 301/sdo (default: all)")
    group.addoption("--canvass-device", metavar="MODEL|FILE", help="built-in model or description of the device")
    group.addoption("--canvass-waivers", metavar="FILE", help="waivers: what they excuse is an expected failure")
    group.addoption("--canvass-allow", metavar="WHAT", default="", help="changes that cases may make, such as nvm")
    group.addoption("--canvass-inconclusive", choices=("fail", "skip"), default="fail", help="inconclusive cases")
    group.addoption("--canvass-captures", metavar="FOLDER", help="keep the captures of the fixture capture here")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "canvass: a conformance case of canvass")
    config.addinivalue_line("markers", "canvass_service(name): the standard and service of a case, such as 301/sdo")
    if config.getoption("--canvass-bus") and getattr(config.option, "numprocesses", None):
        raise pytest.UsageError(
            "one device can't be tested by several processes at a time: run --canvass-bus without -n, "
            "or divide the cases among several devices by --canvass-select"
        )


class Device:
    """The device under test, as the options name it."""

    def __init__(self, config: pytest.Config):
        self.bus: Optional[str] = config.getoption("--canvass-bus")
        self.node: Optional[int] = config.getoption("--canvass-node")
        self.description: Optional[str] = config.getoption("--canvass-device")
        self.waivers: Optional[str] = config.getoption("--canvass-waivers")
        self.allow = [word for word in config.getoption("--canvass-allow").split(",") if word]


class Conformance(pytest.Collector):
    """The conformance cases of a device. They run together, when the first one is wanted."""

    def __init__(self, *, device: Device, ids: list, **kwargs: Any):
        super().__init__(**kwargs)
        self.device = device
        self.ids = ids
        self._run: Optional[TestRun] = None
        self._error: Optional[Exception] = None

    def collect(self) -> Iterator["ConformanceCase"]:
        for case in self.ids:
            yield ConformanceCase.from_parent(self, name=case["id"], case=case)

    def result(self, id: str) -> Case:
        """The result of a case. The first call runs all cases that pytest has chosen."""
        if self._run is None and self._error is None:
            chosen = [item.name for item in self.session.items if isinstance(item, ConformanceCase)]
            try:
                self._run = runs.test(
                    self.device.bus,
                    node=self.device.node,
                    select=chosen,
                    device=self.device.description,
                    waivers=self.device.waivers,
                    allow=self.device.allow,
                )
            except CanvassError as error:
                self._error = error
        if self._error is not None or self._run is None:
            raise CaseFailed(str(self._error))
        case = self._run.case(id)
        if case is None:
            raise CaseFailed("the run ended before this case")
        return case


class CaseFailed(Exception):
    """A case did not end well; the text is the report."""


class ConformanceCase(pytest.Item):
    """One conformance case."""

    def __init__(self, *, case: dict, **kwargs: Any):
        super().__init__(**kwargs)
        self.case = case
        standard, service = self.name.split("/")[:2]
        self.add_marker("canvass")
        self.add_marker(pytest.mark.canvass_service(f"{standard}/{service}"))
        self.extra_keyword_matches.update({standard, service, f"{standard}/{service}"})

    def runtest(self) -> None:
        result = self.parent.result(self.name)
        self.user_properties.append(("clause", self.case["clause"]))
        verdict, reason = result.verdict, result.why
        if verdict in GOOD:
            return
        if verdict in EXPECTED:
            pytest.xfail(f"{reason} ({result.documented})" if result.documented else reason)
        if verdict in SKIPPED:
            pytest.skip(reason)
        if verdict == "inconclusive" and self.config.getoption("--canvass-inconclusive") == "skip":
            pytest.skip(f"inconclusive: {reason}")
        raise CaseFailed(report(result))

    def repr_failure(self, excinfo: Any, style: Any = None) -> Any:
        if isinstance(excinfo.value, CaseFailed):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self):
        return Path("canvass"), None, f"{self.name}: {self.case['summary']}"


def report(result: Case) -> str:
    """A failed case in words: the requirement, what was wrong, and the frames that show it."""
    lines = [f"{result.id}: {result.verdict}", result.requirement, result.clause, ""]
    for breach in result.breaches:
        lines.append(f"  {breach.duty}: expected {breach.expected}, found {breach.actual}")
    if not result.breaches and result.why:
        lines.append(f"  {result.why}")
    return "\n".join([*lines, "", result.frames()])


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(session: pytest.Session, config: pytest.Config, items: list) -> None:
    device = Device(config)
    if device.bus is None:
        return
    known = json.loads(run(["list", "cases", "--format", "json"]))
    select = config.getoption("--canvass-select")
    if select is not None:
        wanted = [pattern.strip() for pattern in select.split(",")]
        known = [case for case in known if any(_is_chosen(case["id"], pattern) for pattern in wanted)]
        if not known:
            raise pytest.UsageError(f"--canvass-select {select}: no case has this name (canvass list cases)")
    collector = Conformance.from_parent(session, name="canvass", device=device, ids=known)
    items.extend(collector.collect())


def _is_chosen(id: str, pattern: str) -> bool:
    return id == pattern or id.startswith(pattern.rstrip("/") + "/")


@pytest.fixture(scope="session")
def canvass_bus_address(request: pytest.FixtureRequest) -> str:
    """The bus of ``--canvass-bus``; tests that need it are skipped without the option."""
    bus = request.config.getoption("--canvass-bus")
    if bus is None:
        pytest.skip("no device: name its bus by --canvass-bus")
    return bus


@pytest.fixture(scope="session")
def can_bus(canvass_bus_address: str) -> Iterator[Any]:
    """The bus of ``--canvass-bus``, for python-can."""
    can = pytest.importorskip("can")
    with can.Bus(**python_can(canvass_bus_address)) as bus:
        yield bus


def python_can(address: str) -> dict:
    """The arguments of ``can.Bus`` for an address of canvass.

    :raises ValueError: if python-can has no such interface
    """
    kind, _, rest = address.partition(":")
    if kind == "sim":
        return {"interface": "canvass", "channel": address}
    if kind == "python":
        interface, _, channel = rest.partition(":")
        channel, _, rate = channel.partition("@")
        return {"interface": interface, "channel": channel, **_bit_rate(rate)}
    if kind == "slcan":
        channel, _, rate = rest.partition("@")
        return {"interface": "slcan", "channel": channel.replace("tcp://", "socket://"), **_bit_rate(rate)}
    if kind == "pcan":
        channel, _, rate = rest.partition("+")[0].partition("@")
        return {"interface": "pcan", "channel": channel, **_bit_rate(rate)}
    if kind == "socketcan" or not rest:
        return {"interface": "socketcan", "channel": rest or address}
    raise ValueError(f"python-can has no interface for {address}")


def _bit_rate(text: str) -> dict:
    factors = {"k": 1_000, "M": 1_000_000}
    if not text:
        return {}
    factor = factors.get(text[-1], 1)
    return {"bitrate": int(float(text[:-1] if text[-1] in factors else text) * factor)}


@pytest.fixture(scope="session")
def canopen_network(can_bus: Any) -> Iterator[Any]:
    """A python-canopen network on the bus."""
    canopen = pytest.importorskip("canopen")
    network = canopen.Network(can_bus)
    network.connect()
    yield network
    network.disconnect()


@pytest.fixture(scope="session")
def canopen_device(request: pytest.FixtureRequest, canopen_network: Any) -> Any:
    """The device under test as a node of python-canopen, with the description of ``--canvass-device`` if it is a file."""
    canopen = pytest.importorskip("canopen")
    device = Device(request.config)
    node = device.node
    if node is None:
        simulation = getattr(canopen_network.bus, "simulation", None)
        node = None if simulation is None else simulation.devices[0][0]
    if node is None:
        raise pytest.UsageError("name the device by --canvass-node")
    description = device.description
    is_file = description is not None and Path(description).is_file()
    dictionary = canopen.import_od(description) if is_file else canopen.ObjectDictionary()
    return canopen_network.add_node(node, dictionary)


class Recording:
    """The frames of a test. ``diagnose()`` judges them."""

    def __init__(self, path: Path):
        self.path = path

    def diagnose(self, **options: Any) -> Diagnosis:
        """Find what is wrong in the frames so far."""
        return runs.diagnose(self.path, **options)


@pytest.fixture
def capture(request: pytest.FixtureRequest, can_bus: Any, tmp_path: Path) -> Iterator[Recording]:
    """Records the frames of the test.

    If the test fails, its report has the last frames and what ``canvass diagnose`` finds in them. With
    ``--canvass-captures`` all captures are kept.
    """
    import can

    folder = request.config.getoption("--canvass-captures")
    name = "".join(c if c.isalnum() or c in "-_." else "-" for c in request.node.name)
    path = Path(folder, f"{name}.log") if folder else tmp_path / f"{name}.log"
    path.parent.mkdir(parents=True, exist_ok=True)
    notifiers = can.Notifier.find_instances(can_bus)
    own = None if notifiers else can.Notifier(can_bus, [])
    notifier = notifiers[0] if notifiers else own
    with _Log(path) as log:
        notifier.add_listener(log)
        request.node.stash[RECORDING] = Recording(path)
        yield request.node.stash[RECORDING]
        notifier.remove_listener(log)
    if own is not None:
        own.stop()


RECORDING = pytest.StashKey[Recording]()


class _Log:
    """A listener that writes a candump log, flushed after each frame: a failed test shows it."""

    def __init__(self, path: Path):
        self._file = open(path, "w", encoding="ascii")

    def __enter__(self) -> "_Log":
        return self

    def __exit__(self, *_: Any) -> None:
        self._file.close()

    def __call__(self, message: Any) -> None:
        width = 8 if message.is_extended_id else 3
        data = "R" if message.is_remote_frame else bytes(message.data).hex().upper()
        self._file.write(f"({message.timestamp:.6f}) can0 {message.arbitration_id:0{width}X}#{data}\n")
        self._file.flush()

    def on_message_received(self, message: Any) -> None:
        self(message)

    def on_error(self, error: Exception) -> None:
        raise error

    def stop(self) -> None:
        self._file.close()


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: Any):
    outcome = yield
    result = outcome.get_result()
    recording = item.stash.get(RECORDING, None)
    if call.when != "call" or not result.failed or recording is None:
        return
    frames = recording.path.read_text("ascii").splitlines()
    result.sections.append((f"canvass: the last of {len(frames)} frames ({recording.path})", "\n".join(frames[-20:])))
    try:
        found = recording.diagnose().findings
    except CanvassError as error:
        result.sections.append(("canvass: the capture can't be diagnosed", str(error)))
        return
    lines = [str(finding) for finding in found] or ["nothing wrong was found"]
    result.sections.append(("canvass: diagnosis of the capture", "\n".join(lines)))


def pytest_report_header(config: pytest.Config) -> Optional[str]:
    bus = config.getoption("--canvass-bus")
    if bus is None:
        return None
    from canvass import __version__

    node = config.getoption("--canvass-node")
    at = f", node {node}" if node else ""
    return f"canvass {__version__}: device at {bus}{at}, {datetime.date.today().isoformat()}"
