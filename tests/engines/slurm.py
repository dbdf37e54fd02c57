"""A sweep over a real Slurm: a controller and two nodes on this machine, with all of their files in a temporary folder.

slurm.py DUCTLOOP [--small]. The call that follows the job array is killed without a word, and called again: it follows the same array. The
full form kills a node too, with all that runs on it, and waits until Slurm has requeued its task. Exit code 77 where Slurm cannot be
started here, or runs not even an empty job: no program of ours has a part in that.
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

    def runs_jobs(self):
        """An array of two empty tasks, one on each node."""
        mark = self.folder / "trial"
        submit = ["sbatch", "--parsable", "--array=1-2", "--nodes=1", "--exclusive", f"--output={self.folder}/trial-%a.log"]
        common.run([*submit, f"--wrap=touch '{mark}-'$SLURM_ARRAY_TASK_ID"])
        common.until("an empty job", lambda: all(pathlib.Path(f"{mark}-{task}").exists() for task in (1, 2)), 60)
        common.until("the end of an empty job", lambda: not queue(), 60)

    def said(self):
        """The last words of controller and nodes."""
        logs = [log for log in sorted(self.folder.glob("*.log")) if log.exists()]
        lines = [f"{log.name}: {line}" for log in logs for line in log.read_text(errors="replace").splitlines()[-4:]]
        return "\n".join(lines)

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
        keepers = {common.parent(number) for number in tasks if "slurmstepd" in command(common.parent(number))}
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


def command(number):
    try:
        return pathlib.Path(f"/proc/{number}/cmdline").read_text().replace("\0", " ")
    except OSError:
        return ""


def queue():
    """Numbers of the job arrays that wait, run, or are about to end."""
    told = subprocess.run(["squeue", "--noheader", "--format=%F"], capture_output=True, text=True)
    assert told.returncode == 0, told
    return set(told.stdout.split())


def arrays():
    """All job arrays that Slurm remembers, those that have ended too."""
    told = subprocess.run(["scontrol", "show", "job", "--oneliner"], capture_output=True, text=True).stdout
    words = [word for line in told.splitlines() if "JobName=ductloop-" in line for word in line.split()]
    return {word.partition("=")[2] for word in words if word.startswith("ArrayJobId=")}


def requeued():
    """Whether a task has been begun again, or waits for it."""
    told = subprocess.run(["scontrol", "show", "job", "--oneliner"], capture_output=True, text=True).stdout
    return any("Restarts=0" not in line for line in told.splitlines() if "Restarts=" in line)


def main():
    ductloop, small = pathlib.Path(sys.argv[1]).absolute(), "--small" in sys.argv
    common.within(600 if small else 900)
    with tempfile.TemporaryDirectory(prefix="ductloop-slurm-") as name:
        folder = pathlib.Path(name)
        replicates = 20 if small else 60
        cases = replicates * common.POINTS
        sweep = common.write_sweep(folder, replicates)
        expected = common.local_rows(ductloop, sweep, folder)
        cluster = None
        try:
            try:
                cluster = Cluster(folder)
                cluster.until_idle()
                cluster.runs_jobs()
            except (OSError, AssertionError, subprocess.SubprocessError) as error:
                common.not_here(f"Slurm does not work here: {error}\n{cluster.said() if cluster else ''}")
            call = [str(ductloop), "sweep", str(sweep), "--engine", "slurm", "--nodes", "2", "--partition", "tests", "--out", "cluster"]
            place = folder / "cluster" / "engines"
            begin = lambda: subprocess.Popen(
                call, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
            started = time.monotonic()
            going = begin()
            common.until("cases", lambda: common.parts_done(place) >= 6, 120, going)
            if small:
                # Ctrl-C ends the array and keeps what is done. Called again at once, the array may still be about to end.
                going.send_signal(signal.SIGINT)
                said = common.ended(going, "the end after Ctrl-C", 60)
                assert going.returncode == 130 and "are done and kept" in said[1], said
                kept = common.parts_done(place)
                assert 6 <= kept < cases, kept
                print(f"interrupted: {kept} of {cases} cases are kept", flush=True)
                first = arrays()
                going = begin()
                common.until("another array", lambda: arrays() - first, 60, going)
                common.until("more cases", lambda: common.parts_done(place) >= kept + 6, 120, going)
                assert not first & queue(), (first, queue())
            # The call that follows is killed: the array goes on, and the next call follows it.
            going.kill()
            common.ended(going, "the end of a killed call", 30)
            known, kept = arrays(), common.parts_done(place)
            assert len(queue()) == 1 and kept < cases, (queue(), kept)
            going = begin()
            if not small:
                common.until("cases", lambda: common.parts_done(place) >= 18, 120, going)
                cluster.kill_node(1)
                killed, kept = time.monotonic(), common.parts_done(place)
                assert kept < cases, "the sweep was over before the kill"
                seconds = common.until("the lost task's requeue", requeued, 300, going)
                print(f"a node killed at {kept} of {cases} cases; its task requeued after {seconds:.0f} s", flush=True)
            said = common.ended(going, "the end of the sweep", 500)
            assert going.returncode == 0 and "of an earlier call is at it" in said[1], said
            assert arrays() == known, (arrays(), known)
            if not small:
                print(f"all done {time.monotonic() - killed:.0f} s after the kill", flush=True)
            print(f"a killed call's array was followed by the next call: {len(known)} arrays in all", flush=True)
            print(f"on Slurm: {time.monotonic() - started:.0f} s", flush=True)
            common.compare(place / "results.parquet", expected, cases)
            # Called again, there is nothing to submit.
            told = common.run(call, cwd=folder)
            assert "job array" not in told.stderr, told
            assert not queue() and arrays() == known
            # A study's generations are sweeps, handed over one by one.
            study = common.write_study(folder, runs=20)
            common.run([ductloop, "tune", study, "--out", folder / "alone"])
            there = ["--engine", "slurm", "--nodes", "2", "--partition", "tests", "--out", "tuned"]
            common.run([ductloop, "tune", study, *there], cwd=folder)
            assert common.tuned(folder / "tuned") == common.tuned(folder / "alone"), "another course than on this machine"
            print(f"a study in {len(arrays() - known)} arrays: the same candidates and the same best, to the bit", flush=True)
        except SystemExit:
            raise
        except BaseException:
            for log in [*folder.glob("*.log"), *folder.glob("cluster/engines/logs/*")]:
                print(f"--- {log}\n{log.read_text(errors='replace')[-3000:]}", file=sys.stderr)
            raise
        finally:
            if cluster:
                cluster.close()
        common.until("the end of all processes", lambda: not common.processes(lambda line, _: str(folder) in line), 30)


if __name__ == "__main__":
    main()
