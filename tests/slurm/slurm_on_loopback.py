"""A Slurm of one node on the loopback: `python slurm_on_loopback.py DIRECTORY`.

All its state is in DIRECTORY, which is there and empty (its path has to be short: sockets lie in it). Says `ready` once
jobs can be submitted with SLURM_CONF=DIRECTORY/slurm.conf, or why they cannot, and lives as long as its standard input:
when that ends, because whoever started it closed it or died, all that runs here is stopped by its process id and
DIRECTORY is removed. It leaves its parent's tree of processes, so that what kills that tree does not kill what cleans
up after it.
"""

import ctypes
import getpass
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

CPUS = 4  # more than there may be: what is tested is the order of things, not their speed
START_SECONDS = 30  # takes one or two
STOP_SECONDS = 5
PR_SET_CHILD_SUBREAPER = 36  # Linux, prctl(2)

CONFIGURATION = """
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
AuthType=auth/munge
AuthInfo=socket={directory}/munge.socket
CredType=cred/munge
StateSaveLocation={directory}/state
SlurmdSpoolDir={directory}/spool
SlurmctldPidFile={directory}/slurmctld.pid
SlurmdPidFile={directory}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1,sched_min_interval=0
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
KillWait=5
MinJobAge=3600
MailProg=/bin/true
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=4096
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE
"""


class NotUp(Exception):
    """Slurm did not come up; says why."""


def leave_the_tree():
    """Go on as a process of its own session, whose orphaned descendants become its children."""
    if os.fork() > 0:
        os._exit(0)
    os.setsid()
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def free_ports(count):
    """Numbers of ports of the loopback that nobody uses now."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def configure(directory):
    """Write key and configuration."""
    for name in ["state", "spool", "log"]:
        (directory / name).mkdir()
    key = directory / "munge.key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    text = CONFIGURATION.format(
        host=socket.gethostname().split(".")[0],
        user=getpass.getuser(),
        directory=directory,
        ports=free_ports(2),
        cpus=CPUS,
    )
    (directory / "slurm.conf").write_text(text)


def start(directory, name, *words):
    """Start a daemon in the foreground, as a child."""
    with (directory / "log" / name).open("wb") as log:
        return subprocess.Popen([name, *words], stdin=subprocess.DEVNULL, stdout=log, stderr=log)


def start_daemons(directory):
    """Start the three daemons and wait until the node is idle."""
    munge = {
        "key-file": "munge.key",
        "socket": "munge.socket",
        "pid-file": "munge.pid",
        "log-file": "log/munged.log",
        "seed-file": "munge.seed",
    }
    words = [f"--{option}={directory / name}" for option, name in munge.items()]
    daemons = [start(directory, "munged", "--foreground", "--force", "--num-threads=2", *words)]
    wait_until((directory / "munge.socket").exists, daemons)
    configuration = str(directory / "slurm.conf")
    os.environ["SLURM_CONF"] = configuration
    daemons.append(start(directory, "slurmctld", "-D", "-c", "-f", configuration))
    daemons.append(start(directory, "slurmd", "-D", "-c", "-f", configuration))
    wait_until(node_is_idle, daemons)


def node_is_idle():
    """Whether jobs can start."""
    asked = subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True, check=False)
    return asked.stdout.strip() == "idle"


def wait_until(fact, daemons):
    """Wait for a fact; a daemon that ends, or a fact that does not come, is a reason."""
    until = time.monotonic() + START_SECONDS
    while not fact():
        for daemon in daemons:
            if daemon.poll() is not None:
                raise NotUp(f"{daemon.args[0]} ended with status {daemon.returncode}")
        if time.monotonic() > until:
            raise NotUp(f"not up after {START_SECONDS} s")
        time.sleep(0.05)


def children(pid):
    """Process ids of the children of a process; none of one that is gone meanwhile."""
    found = []
    try:
        tasks = os.listdir(f"/proc/{pid}/task")
    except OSError:
        return found
    for task in tasks:
        try:
            found.extend(map(int, Path(f"/proc/{pid}/task/{task}/children").read_text().split()))
        except OSError:
            pass
    return found


def descendants(pid):
    """Process ids of all that came from this process and runs."""
    found = []
    for child in children(pid):
        found.append(child)
        found.extend(descendants(child))
    return found


def collect_the_dead():
    """Take over the status of children that ended, so that only running ones are left."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0] > 0:
            pass
    except ChildProcessError:
        pass


def stop_all():
    """Stop all that runs here: asked first, then killed."""
    began = time.monotonic()
    asked = set()
    while left := descendants(os.getpid()):
        number = signal.SIGTERM if time.monotonic() < began + STOP_SECONDS else signal.SIGKILL
        for pid in left:
            if number == signal.SIGKILL or pid not in asked:
                asked.add(pid)
                try:
                    os.kill(pid, number)
                except ProcessLookupError:
                    pass
        time.sleep(0.05)
        collect_the_dead()


def logs(directory):
    """The last lines of each log."""
    return "".join(f"\n{path.name}:\n{path.read_text()[-2000:]}" for path in sorted((directory / "log").iterdir()))


def serve(directory):
    """Bring Slurm up, say so, and wait for the end of standard input."""
    try:
        configure(directory)
        start_daemons(directory)
    except (NotUp, OSError) as problem:
        print(f"Slurm does not come up: {problem}{logs(directory)}", flush=True)
        return
    print("ready", flush=True)
    sys.stdin.read()


def main():
    """Run until standard input ends."""
    directory = Path(sys.argv[1])
    leave_the_tree()
    for number in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]:
        signal.signal(number, lambda *_: None)  # what ends this is the end of standard input
    try:
        serve(directory)
    finally:
        stop_all()
        shutil.rmtree(directory, ignore_errors=True)


if __name__ == "__main__":
    main()
