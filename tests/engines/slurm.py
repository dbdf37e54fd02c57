"""A sweep over a real Slurm: a controller and two nodes on this machine, with all of their files in a temporary folder.

slurm.py DUCTLOOP [--small]. The full form kills a node in mid-sweep, with all that runs on it, and waits until Slurm has requeued its task.
"""

import getpass
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time

import common

NODES = ["ductnode1", "ductnode2"]


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def configuration(folder, host):
    ports = [free_port() for _ in range(3)]
    user = getpass.getuser()
    # AuthInfo: a requeued task is held until credentials of its first start have run out, 120 s by default.
    text = f"""ClusterName=ductloop
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
AuthInfo=cred_expire=10
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/linear
SlurmctldTimeout=10
SlurmdTimeout=10
KillWait=5
ReturnToService=2
MpiDefault=none
SwitchType=switch/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerParameters=sched_interval=2,batch_sched_delay=0
"""
    for name, port in zip(NODES, ports[1:]):
        text += f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 State=UNKNOWN\n"
    text += f"PartitionName=tests Nodes={','.join(NODES)} Default=YES MaxTime=INFINITE State=UP\n"
    path = folder / "slurm.conf"
    path.write_text(text)
    (folder / "state").mkdir()
    return path


class Cluster:
    """Controller and nodes, as processes of this one."""

    def __init__(self, folder):
        self.folder = folder
        host = socket.gethostname().split(".")[0]
        os.environ["SLURM_CONF"] = str(configuration(folder, host))
        os.environ["PATH"] += ":/usr/sbin:/sbin"
        self.started = []
        log = (folder / "daemons.log").open("w")
        start = lambda words: self.started.append(subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log))
        start(["slurmctld", "-D", "-i"])
        time.sleep(1)
        for name in NODES:
            (folder / f"spool-{name}").mkdir()
            start(["slurmd", "-D", "-N", name])

    def until_idle(self):
        def idle():
            told = subprocess.run(["sinfo", "--noheader", "--Node", "--format=%T"], capture_output=True, text=True)
            return told.returncode == 0 and told.stdout.split() == ["idle"] * len(NODES)

        common.until("two idle nodes", idle, 60)

    def on_node(self, name):
        """Processes of a node's tasks and their keepers, not of its daemon."""
        here = f"SLURM_CONF={os.environ['SLURM_CONF']}".encode()
        of_node = f"SLURMD_NODENAME={name}".encode()
        is_one = lambda command, environment: here in environment and (of_node in environment or command.startswith("slurmstepd"))
        return common.processes(is_one)

    def kill_node(self, index):
        """A power cut: daemon, keepers and tasks end at once. Keepers (slurmstepd) are told apart by their parents' tasks."""
        self.started[1 + index].kill()
        self.started[1 + index].wait()
        tasks = self.on_node(NODES[index])
        keepers = {parent(number) for number in tasks if "slurmstepd" in command(parent(number))}
        tasks = [number for number in tasks if "slurmstepd" not in command(number)]
        common.kill(sorted(keepers))
        common.kill(tasks)

    def close(self):
        for daemon in reversed(self.started):
            daemon.send_signal(signal.SIGTERM)
        for daemon in reversed(self.started):
            try:
                daemon.wait(timeout=15)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        here = f"SLURM_CONF={os.environ['SLURM_CONF']}".encode()
        common.kill(common.processes(lambda _, environment: here in environment))


def parent(number):
    try:
        return int(pathlib.Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()[1])
    except OSError:
        return 0


def command(number):
    try:
        return pathlib.Path(f"/proc/{number}/cmdline").read_text().replace("\0", " ")
    except OSError:
        return ""


def requeued():
    """Whether a task has been begun again, or waits for it."""
    told = subprocess.run(["scontrol", "show", "job", "--oneliner"], capture_output=True, text=True).stdout
    return any("Restarts=0" not in line for line in told.splitlines() if "Restarts=" in line)


def main():
    ductloop, small = pathlib.Path(sys.argv[1]).absolute(), "--small" in sys.argv
    with tempfile.TemporaryDirectory(prefix="ductloop-slurm-") as name:
        folder = pathlib.Path(name)
        replicates = 20 if small else 60
        cases = replicates * common.POINTS
        sweep = common.write_sweep(folder, replicates)
        expected = common.local_rows(ductloop, sweep, folder)
        cluster = Cluster(folder)
        try:
            cluster.until_idle()
            call = [str(ductloop), "sweep", str(sweep), "--engine", "slurm", "--nodes", "2", "--partition", "tests", "--out", "cluster"]
            place = folder / "cluster" / "engines"
            started = time.monotonic()
            going = subprocess.Popen(call, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            if small:
                # Ctrl-C ends the array and keeps what is done.
                common.until("cases", lambda: common.parts_done(place) >= 6, 120, going)
                going.send_signal(signal.SIGINT)
                said = going.communicate(timeout=60)
                assert going.returncode == 130 and "are done and kept" in said[1], said
                empty = lambda: not subprocess.run(["squeue", "--noheader"], capture_output=True, text=True).stdout.strip()
                common.until("an empty queue", empty, 60)
                kept = common.parts_done(place)
                assert 6 <= kept < cases, kept
                print(f"interrupted: the queue is empty, {kept} cases are kept", flush=True)
                common.run(call + ["--quiet"], cwd=folder)
            else:
                common.until("cases", lambda: common.parts_done(place) >= 12, 120, going)
                cluster.kill_node(1)
                killed, kept = time.monotonic(), common.parts_done(place)
                assert kept < cases, "the sweep was over before the kill"
                seconds = common.until("the lost task's requeue", requeued, 300, going)
                print(f"a node killed at {kept} of {cases} cases; its task requeued after {seconds:.0f} s", flush=True)
                said = going.communicate(timeout=600)
                assert going.returncode == 0, said
                print(f"all done {time.monotonic() - killed:.0f} s after the kill", flush=True)
            print(f"on Slurm: {time.monotonic() - started:.0f} s", flush=True)
            common.compare(place / "results.parquet", expected, cases)
            # Called again, there is nothing to submit.
            told = common.run(call, cwd=folder)
            assert "job array" not in told.stderr, told
            assert not subprocess.run(["squeue", "--noheader"], capture_output=True, text=True).stdout.strip()
        except BaseException:
            for log in [*folder.glob("*.log"), *folder.glob("cluster/engines/logs/*")]:
                print(f"--- {log}\n{log.read_text(errors='replace')[-3000:]}", file=sys.stderr)
            raise
        finally:
            cluster.close()
        common.until("the end of all processes", lambda: not common.processes(lambda line, _: str(folder) in line), 30)


if __name__ == "__main__":
    main()
