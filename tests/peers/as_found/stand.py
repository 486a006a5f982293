"""A simulated device in virtual time that was set up by its user, and to which each trial goes back."""

import dataclasses
import tempfile

from judge import Judge
from lockstep import Lockstep, Network
from situation import SITUATIONS, course, prepare
from subject import Silent, Subject


class Stand:
    """One model in one situation."""

    def __init__(self, program, descriptions, model, situation):
        self.model, self.situation = model, situation
        self._lockstep = Lockstep(program)
        with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
            file.write(course(situation))
            file.flush()
            device = self._lockstep.ask("device", address=f"sim:{model}~csv={file.name}")
        self.network = Network(self._lockstep)
        self.subject = Subject(self.network, device["node"], f"{descriptions}/{model}.eds")
        prepare(self.subject, model, situation)
        self._lockstep.ask("keep", name="found")
        found = self.look()
        self.go_back()
        self.network.hear(90)
        self._judge = Judge(model, device["node"], self.subject.description, found, self.look())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.network.bus.shutdown()
        self._lockstep.close()

    def run(self, trial):
        """A complete or interrupted run."""
        self.go_back()
        told = self._test(trial, [])
        counts = {"began": told["begun"] > 0, "frames": told["frames"], "cases": told["cases"]}
        return self.judge(trial, told.get("is_as_found"), told, told["closing"], **counts)

    def kill(self, trial, frames):
        """The run is killed at each of these frames, and the device is restored each time."""
        self.go_back()
        self._test(trial, frames)
        for frame in frames:
            self.go_back(f"kill {frame}")
            self.network.hear(2)
            told = self._lockstep.ask("restore")
            if "failed" in told:
                # What the user does with a device that does not answer.
                self._power_cycle()
                told = self._lockstep.ask("restore")
            killed = dataclasses.replace(trial, kill=frame)
            yield self.judge(killed, told.get("is_as_found"), told, told["sent"], began=told["had_journal"])

    def _test(self, trial, kill):
        return self._lockstep.ask(
            "run",
            allow=trial.allow,
            select=trial.select,
            zero_point_stored=SITUATIONS[self.situation].zero_point_is_stored,
            power_cycle=SITUATIONS[self.situation].has_switch,
            interrupt=trial.interrupt,
            kill=kill,
        )

    def judge(self, trial, claims, told, sent, **more):
        try:
            seen = self.look()
        except Silent as silent:
            seen = str(silent)
        text = told.get("lines", []) + told.get("notices", []) + [told[key] for key in ["failed"] if key in told]
        return self._judge.outcome(trial, claims, text, seen, sent, **more)

    def look(self):
        """What is there, and what is there after the supply was off; once the shaft is at rest."""
        self.network.hear(max(0, SITUATIONS[self.situation].rests_at - self.network.now()))
        found = self.subject.look()
        self._power_cycle()
        return found, self.subject.look()

    def go_back(self, name="found"):
        self.network.bus.forget(self._lockstep.ask("go-back", name=name)["now"])

    def _power_cycle(self):
        self._lockstep.ask("power-cycle")
        self.network.hear(3)
