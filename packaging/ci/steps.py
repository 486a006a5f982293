"""Runs the steps of a composite action as GitHub's runner does: steps.py action.yml NAME=VALUE...

Each step is a bash script with `-e -o pipefail`; a step that fails ends the job. Expressions of inputs and contexts are filled in,
and what a step adds to GITHUB_PATH is in the PATH of the next.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

import yaml

path, *given = sys.argv[1:]
action = yaml.safe_load(open(path))
inputs = {name: str(about.get("default", "")) for name, about in action["inputs"].items()}
for word in given:
    name, value = word.split("=", 1)
    if name not in inputs:
        sys.exit(f"the action has no input {name}")
    inputs[name] = value
for name, about in action["inputs"].items():
    if about.get("required") and not inputs[name]:
        sys.exit(f"the input {name} is required")

context = {f"inputs.{name}": value for name, value in inputs.items()}
context |= {"github.server_url": "https://github.invalid", "github.action_repository": "a/canvass", "github.action_ref": "v0"}


def filled(text):
    """A text with each expression replaced by its value; an unknown one is a mistake of the action."""
    return re.sub(r"\$\{\{\s*(.*?)\s*\}\}", lambda found: context[found[1]], str(text))


work = pathlib.Path(tempfile.mkdtemp())
files = {name: work / name.lower() for name in ("GITHUB_PATH", "GITHUB_OUTPUT")}
files["GITHUB_STEP_SUMMARY"] = pathlib.Path("summary.md")
for file in files.values():
    file.write_text("")
environment = os.environ | {name: str(file) for name, file in files.items()}
environment |= {"GITHUB_ACTION_PATH": str(pathlib.Path(path).parent), "GITHUB_ACTIONS": "true", "RUNNER_TEMP": str(work)}

for step in action["runs"]["steps"]:
    if step["shell"] != "bash":
        sys.exit(f"step {step['name']}: expected the shell bash, found {step['shell']}")
    added = files["GITHUB_PATH"].read_text().split()
    own = {name: filled(value) for name, value in step.get("env", {}).items()}
    own["PATH"] = os.pathsep.join([*reversed(added), environment["PATH"]])
    script = work / "step.sh"
    script.write_text(filled(step["run"]))
    bash = ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", str(script)]
    status = subprocess.run(bash, env=environment | own).returncode
    if status:
        sys.exit(status)
