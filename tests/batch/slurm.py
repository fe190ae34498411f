"""Slurm on one machine without systemd: munged, slurmctld and slurmd started by hand, their files in a folder of their own."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "sinfo", "scancel")


def missing():
    """Names the package that is missing, or says why Slurm cannot run."""
    absent = [p for p in PROGRAMS if shutil.which(p, path=os.environ["PATH"] + ":/usr/sbin") is None]
    if absent:
        return f"there is no {', '.join(absent)} (Debian: slurm-wlm munge)"
    return None if os.geteuid() == 0 else "Slurm's daemons are started as root"


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Slurm:
    """A cluster of this machine; with it as a context its commands are run."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.daemons = {}
        host, (controller, node) = socket.gethostname(), free_ports(2)
        for name in ("spool", "state"):
            (self.folder / name).mkdir(parents=True)
        os.chmod(self.folder, 0o755)
        self.configuration = self.folder / "slurm.conf"
        self.configuration.write_text(
            f"ClusterName=test\nSlurmctldHost={host}\nSlurmctldPort={controller}\nSlurmdPort={node}\nSlurmUser=root\nSlurmdUser=root\n"
            f"AuthType=auth/munge\nAuthInfo=socket={self.folder}/munge.socket\nCryptoType=crypto/munge\n"
            "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\nSelectTypeParameters=CR_Core\n"
            "PropagateResourceLimits=NONE\nAccountingStorageType=accounting_storage/none\nJobAcctGatherType=jobacct_gather/none\n"
            f"SwitchType=switch/none\nMpiDefault=none\nReturnToService=2\nStateSaveLocation={self.folder}/state\n"
            f"SlurmdSpoolDir={self.folder}/spool\nSlurmctldPidFile={self.folder}/ctld.pid\nSlurmdPidFile={self.folder}/d.pid\n"
            "SlurmdTimeout=5\nSlurmctldTimeout=10\nSchedulerParameters=sched_interval=2\nKillWait=5\n"
            f"NodeName={host} CPUs={os.cpu_count()} State=UNKNOWN\nPartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n")
        self.environment = {**os.environ, "SLURM_CONF": str(self.configuration), "PATH": os.environ["PATH"] + ":/usr/sbin:/usr/bin"}

    def __enter__(self):
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.socket",
                   f"--pid-file={self.folder}/munge.pid", f"--log-file={self.folder}/munge.log", f"--seed-file={self.folder}/munge.seed")
        self.wait_for(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.start("slurmctld", "-D", "-f", self.configuration)
        self.start_node()
        self.wait_for(self.is_idle, "a node")
        return self

    def __exit__(self, *_):
        self.run("scancel", "--me", check=False)
        for name in reversed(list(self.daemons)):
            self.stop(name, signal.SIGKILL if name == "munged" else signal.SIGTERM)

    def start(self, name, *arguments):
        with open(self.folder / f"{name}.out", "ab") as log:
            self.daemons[name] = subprocess.Popen([name, *map(str, arguments)], stdout=log, stderr=log, env=self.environment)

    def start_node(self):
        self.start("slurmd", "-D", "-f", self.configuration)

    def stop(self, name, how):
        daemon = self.daemons.pop(name)
        daemon.send_signal(how)
        try:
            daemon.wait(30)
        except subprocess.TimeoutExpired:
            daemon.kill()
            daemon.wait()

    def is_idle(self):
        return self.run("sinfo", "-h", "-o", "%T", check=False).stdout.strip() == "idle"

    def wait_for(self, condition, what):
        deadline = time.monotonic() + 60
        while not condition():
            if time.monotonic() > deadline:
                raise RuntimeError(f"{what} did not come up\n{self.logs()}")
            time.sleep(0.2)

    def logs(self):
        return "\n".join(f"{p.name}: {p.read_text(errors='replace')[-600:]}" for p in self.folder.glob("*.out"))

    def run(self, *command, check=True):
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, env=self.environment, cwd=self.folder.parent)
        if check and done.returncode != 0:
            raise RuntimeError(f"{command}: {done.stdout}{done.stderr}")
        return done

    def submit(self, *arguments, wait=True):
        """Hands in a batch script, and waits for its end; what sbatch returns."""
        options = [*(["--wait"] if wait else []), "--output", self.folder / "job-%A_%a.out"]
        return self.run("sbatch", *options, *arguments, check=False)
