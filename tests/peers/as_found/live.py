"""The same with processes and in real time: `canvass test` is killed on a device that is a process of its own, and `canvass
restore` puts it back. python-canopen sees the device through python-can's SLCAN over TCP."""

import contextlib
import multiprocessing.pool
import pathlib
import random
import shutil
import socket
import subprocess
import tempfile
import time

import can
import canopen

from judge import Judge
from situation import FORGETFUL, SITUATIONS, course, prepare, turned
from subject import Silent, Subject
from trial import Trial

NODE_IDS = {"kuebler-sendix-m58": "127"}
"""Models that are delivered without one."""

UNREACHABLE = 3
"""The status of a program whose device does not answer."""

KILLS = 10
SITUATION, OF_FORGETFUL = "both", "communication"
CASES = 12
"""How many cases a run has: those that touch something, so that most kills come at one."""
LONGEST = 15.0
"""Seconds after its first case at which a run is killed at the latest."""


class Network(canopen.Network):
    """A network of python-canopen on a real bus."""

    @staticmethod
    def now():
        return time.monotonic()

    @staticmethod
    def hear(seconds):
        time.sleep(seconds)

    def attach(self, node_id, description):
        node = self.add_node(canopen.RemoteNode(node_id, description))
        node.sdo.RESPONSE_TIMEOUT = 5
        return node


class Device:
    """`canvass simulate`: a device with its memory in a file, switched on; its shaft moves as `motion` says."""

    def __init__(self, canvass, model, memory, motion):
        with socket.create_server(("127.0.0.1", 0)) as free:
            self._place = "127.0.0.1:%d" % free.getsockname()[1]
        self.bus = f"slcan:tcp://{self._place}"
        self._command = [canvass, "simulate", model, f"slcan:listen://{self._place}", "--memory", memory]
        if model in NODE_IDS:
            self._command += ["--node", NODE_IDS[model]]
        self._switch_on(motion)

    def _switch_on(self, motion):
        command = [*self._command, "--motion", motion]
        self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        told = self._process.stderr.readline()
        self.node_id = int(told.split(" as node ")[1].split()[0])

    def _switch_off(self):
        self._process.kill()
        self._process.wait()
        self._process.stderr.close()

    def power_cycle(self, motion):
        """Off and on again."""
        self._switch_off()
        self._switch_on(motion)
        time.sleep(3)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._switch_off()

    @contextlib.contextmanager
    def seen(self, descriptions, model):
        """The device as its user sees it; nobody else can be connected meanwhile."""
        network = Network(can.Bus(interface="slcan", channel=f"socket://{self._place}", bitrate=250_000))
        network.connect()
        try:
            yield Subject(network, self.node_id, f"{descriptions}/{model}.eds", guards=False)
        finally:
            network.disconnect()


def kills(canvass, descriptions, catalogue, models, seed):
    """Runs that are killed at random moments, all at a time: most of the time is waiting."""
    dice = random.Random(f"{seed} processes")
    touching = [case["id"] for case in catalogue["cases"] if case["touches"]]
    words = tuple(catalogue["words"])
    trials = [_trial(dice, models, words, touching) for _ in range(KILLS)]
    with multiprocessing.pool.ThreadPool(KILLS) as pool:
        return pool.map(lambda trial: kill(canvass, descriptions, trial), trials)


def _trial(dice, models, words, touching):
    """A run that is killed at a random moment."""
    model = dice.choice(models)
    situation = OF_FORGETFUL if model in FORGETFUL else SITUATION
    select = tuple(sorted(dice.sample(touching, CASES)))
    return Trial(model, situation, words, "all", select, seconds=round(dice.uniform(0, LONGEST), 2))


def kill(canvass, descriptions, trial):
    """One run that is killed, after which the device is restored."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        turning = folder / "turning.csv"
        turning.write_text(course(trial.situation))
        (folder / "turned.csv").write_text(turned())
        with Device(canvass, trial.model, folder / "memory", f"csv={turning}") as device:
            with device.seen(descriptions, trial.model) as subject:
                prepare(subject, trial.model, trial.situation)
            look = lambda: _look(canvass, descriptions, trial.model, folder, device)
            judge = Judge(trial.model, device.node_id, subject.description, look(), look())
            journal = folder / "journal"
            began = _test_and_kill(canvass, trial, device, journal)
            claims, text = _restore(canvass, device, journal, folder) if journal.exists() else (None, [])
            try:
                seen = look()
            except Silent as silent:
                seen = str(silent)
            return judge.outcome(trial, claims, text, seen, [], began=began)


def _look(canvass, descriptions, model, folder, device):
    """What is there, and what another device with the same memory has after power-on."""
    with device.seen(descriptions, model) as subject:
        found = subject.look()
    memory = folder / "memory of the other"
    if (folder / "memory").exists():
        shutil.copy(folder / "memory", memory)
    with Device(canvass, model, memory, _turned(folder)) as other, other.seen(descriptions, model) as subject:
        subject.network.hear(3)
        return found, subject.look()


def _turned(folder):
    """The motion of a shaft that has turned before."""
    return f"csv={folder / 'turned.csv'}"


def _test_and_kill(canvass, trial, device, journal):
    """Whether the first case had begun when the run was killed."""
    command = [canvass, "test", device.bus, "--node", str(device.node_id), "--device", trial.model]
    command += ["--allow", "all", "--select", ",".join(trial.select), "--journal", journal]
    command += ["--zero-point-stored"] if SITUATIONS[trial.situation].zero_point_is_stored else []
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
        # Counted from the first case: a busy machine needs seconds for what comes before it.
        while not journal.exists() and run.poll() is None:
            time.sleep(0.005)
        began = journal.exists()
        time.sleep(trial.seconds)
        run.kill()
    return began


def _restore(canvass, device, journal, folder):
    """What `canvass restore` claims and tells."""
    command = [canvass, "restore", device.bus, "--journal", journal]
    restored = subprocess.run(command, capture_output=True, text=True, check=False)
    if restored.returncode == UNREACHABLE:
        # What the user does with a device that does not answer.
        device.power_cycle(_turned(folder))
        restored = subprocess.run(command, capture_output=True, text=True, check=False)
    return restored.returncode == 0, restored.stderr.splitlines()
