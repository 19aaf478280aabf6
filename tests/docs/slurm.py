"""A SLURM cluster of one node, this machine, whose daemons are processes of the tests."""

from __future__ import annotations

import os
import platform
import re
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

DAEMONS = ("munged", "slurmctld", "slurmd")
PATIENCE_S = 240.0
NODE = platform.node().partition(".")[0]

CONFIGURATION = """
ClusterName=one
SlurmctldHost={node}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={home}/munge
StateSaveLocation={home}/state
SlurmdSpoolDir={home}/spool
SlurmctldPidFile={home}/slurmctld.pid
SlurmdPidFile={home}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
KillWait=2
NodeName={node} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE
"""


def until(happened: Callable[[], bool], what: str) -> None:
    """Wait for something; a failure where it does not come."""
    give_up = time.monotonic() + PATIENCE_S
    while not happened():
        assert time.monotonic() < give_up, f"waited in vain: {what}"
        time.sleep(0.1)


@dataclass(frozen=True)
class Slurm:
    """The cluster: commands are given to it in this environment."""

    environment: dict[str, str]

    def said(self, *command: str, folder: Path = Path(), well: bool = True) -> str:
        """What a command printed."""
        done = subprocess.run(command, cwd=folder, env=self.environment, capture_output=True, text=True)
        assert not well or done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def submit(self, script: Path, *options: str) -> str:
        """Submit a script from its folder, with options that stand above its own; give the job's number."""
        return self.said("sbatch", "--parsable", *options, script.name, folder=script.parent).strip()

    def state(self, job: str) -> str:
        """As PENDING, RUNNING, COMPLETED."""
        return re.findall(r"JobState=(\w+)", self.said("scontrol", "show", "job", job))[0]

    def ended(self, job: str) -> str:
        """Wait for a job's end and the end of its processes; give its state."""
        until(lambda: self.state(job) not in ("PENDING", "RUNNING", "COMPLETING"), f"end of job {job}")
        self._gone(job)
        return self.state(job)

    def fail_the_node(self, job: str) -> None:
        """The node of a job fails and comes back.

        SLURM lets the job wait two minutes, as a late SIGKILL for its first life would end its second one;
        after `KillWait` there is none.
        """
        self.said("scontrol", "update", f"NodeName={NODE}", "State=DOWN", "Reason=test")
        self._gone(job)
        self.said("scontrol", "update", f"NodeName={NODE}", "State=RESUME")
        assert self.state(job) == "PENDING"
        time.sleep(10)
        self.said("scontrol", "update", f"JobId={job}", "StartTime=now")

    def _gone(self, job: str) -> None:
        listed = ("scontrol", "listpids", job)
        until(lambda: len(self.said(*listed, well=False).splitlines()) < 2, f"processes of job {job}")


@contextmanager
def slurm(home: Path) -> Iterator[Slurm]:
    """Bring it up; skips with the reason where it cannot be had."""
    path = os.pathsep.join([str(home), str(Path(sys.executable).parent), os.environ["PATH"], "/usr/sbin"])
    for name in (*DAEMONS, "sbatch", "srun", "scontrol"):
        if shutil.which(name, path=path) is None:
            pytest.skip(f"{name} is missing: apt install slurm-wlm munge")
    if os.getuid() != 0:
        pytest.skip("slurmd starts jobs as root only")
    shim = home / "warmlink"
    shim.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m warmlink "$@"\n')
    shim.chmod(0o755)
    with ExitStack() as stack:
        free = [stack.enter_context(socket.create_server(("", 0))).getsockname()[1] for _ in range(2)]
    (home / "slurm.conf").write_text(CONFIGURATION.format(node=NODE, ports=free, home=home))
    (home / "key").write_bytes(os.urandom(128))
    (home / "key").chmod(0o600)
    for folder in ("state", "spool"):
        (home / folder).mkdir()
    own = [f"--{name}={home / name}" for name in ("socket", "pid-file", "seed-file", "log-file")]
    own[0] = f"--socket={home / 'munge'}"
    environment = {**os.environ, "PATH": path, "SLURM_CONF": str(home / "slurm.conf")}
    commands = (
        ["munged", "--foreground", "--force", f"--key-file={home / 'key'}", *own],
        ["slurmctld", "-D"],
        ["slurmd", "-D"],
    )
    with ExitStack() as stack:
        log = stack.enter_context((home / "log").open("wb"))
        for command in commands:
            daemon = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
            stack.callback(daemon.wait)
            stack.callback(daemon.terminate)
            if command[0] == "munged":
                until((home / "munge").exists, "munged")
        cluster = Slurm(environment)
        until(lambda: "idle" in cluster.said("sinfo", "-h", well=False), "the node of the cluster")
        yield cluster
