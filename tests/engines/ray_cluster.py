"""A sweep over a Ray cluster of two nodes on this machine (`ray.cluster_utils.Cluster`), one of which is killed in mid-sweep.

ray_cluster.py DUCTLOOP [--small]. The small form has fewer cases, and interrupts the sweep first. Exit code 77 where Ray cannot be started
here, or runs not even an empty task: no program of ours has a part in that.
"""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"

import common
from ray.cluster_utils import Cluster

# What a node keeps objects in, of which there are none here: the least that Ray takes.
NODE = {"num_cpus": 1, "object_store_memory": 80 << 20}


# An empty task on each node, in a process of its own: this one would become the parent of what a killed raylet leaves, and Ray's workers
# end only where they see that their parent is gone.
TRIAL = """
import sys
import ray
ray.init(address=sys.argv[1], log_to_driver=False)
empty = ray.remote(lambda: None).options(num_cpus=1, scheduling_strategy="SPREAD")
ray.get([empty.remote() for _ in range(2)], timeout=90)
"""


def runs_tasks(cluster):
    told = subprocess.run(
        [sys.executable, "-c", TRIAL, cluster.address], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120
    )
    if told.returncode != 0:
        raise RuntimeError(f"an empty task does not run: {told.stderr[-2000:]}")


def main():
    ductloop, small = pathlib.Path(sys.argv[1]).absolute(), "--small" in sys.argv
    with tempfile.TemporaryDirectory(prefix="ductloop-ray-") as name:
        folder = pathlib.Path(name)
        replicates = 40 if small else 80
        cases = replicates * common.POINTS
        sweep = common.write_sweep(folder, replicates)
        expected = common.local_rows(ductloop, sweep, folder)
        workers = lambda: common.processes(lambda line, _: " sweep work " in line and str(folder) in line and "--shard" in line)
        # Told to all that is started from here, by which it is found.
        os.environ["DUCTLOOP_TEST"] = name
        ours = lambda: common.processes(lambda _, environment: f"DUCTLOOP_TEST={name}".encode() in environment)
        cluster = None
        try:
            try:
                common.within(150)
                common.waited_for = "Ray's start"
                cluster = Cluster(initialize_head=True, head_node_args=NODE | {"include_dashboard": False})
                lost = cluster.add_node(**NODE)
                common.waited_for = "an empty task on Ray"
                runs_tasks(cluster)
            except Exception as error:
                common.not_here(f"Ray does not work here: {error}")
            common.within(600 if small else 900)
            call = [str(ductloop), "sweep", str(sweep), "--engine", "ray", "--nodes", "2", "--address", cluster.address]
            call += ["--python", sys.executable, "--out", "cluster"]
            place = folder / "cluster" / "engines"
            log = place / "logs" / "ray.log"
            start = lambda: subprocess.Popen(
                call, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
            started = time.monotonic()
            if small:
                going = start()
                common.until("cases", lambda: common.parts_done(place) >= 6, 180, going)
                going.send_signal(signal.SIGINT)
                said = common.ended(going, "the end after Ctrl-C", 90)
                assert going.returncode == 130 and "are done and kept" in said[1], said
                common.until("the end of the workers", lambda: not workers(), 30)
                print(f"interrupted: no worker is left, {common.parts_done(place)} of {cases} cases are kept", flush=True)
            before = common.parts_done(place)
            going = start()
            common.until("more cases", lambda: common.parts_done(place) >= before + 6 and len(workers()) == 2, 180, going)
            # A power cut: the raylet alone would not do, as a task may outlive it.
            common.kill(common.below(lost.all_processes["raylet"][0].process.pid))
            killed, kept = time.monotonic(), common.parts_done(place)
            assert kept < cases, "the sweep was over before the kill"
            common.until("the end of the lost node's worker", lambda: len(workers()) < 2, 60)
            said = common.ended(going, "the end of the sweep", 500)
            assert going.returncode == 0, said
            print(f"a node killed at {kept} of {cases} cases; all done {time.monotonic() - killed:.0f} s later", flush=True)
            ended = [line for line in log.read_text().splitlines() if line.startswith("shard ")]
            assert len(ended) == 2 and not any("failed" in line for line in ended), ended
            print(f"on Ray: {time.monotonic() - started:.0f} s", flush=True)
            common.compare(place / "results.parquet", expected, cases)
            # Called again, there is nothing to hand over.
            size = log.stat().st_size
            common.run(call, cwd=folder)
            assert log.stat().st_size == size
        except SystemExit:
            raise
        except BaseException:
            log = folder / "cluster" / "engines" / "logs" / "ray.log"
            if log.exists():
                print(f"--- {log}\n{log.read_text(errors='replace')[-6000:]}", file=sys.stderr)
            raise
        finally:
            if cluster:
                cluster.shutdown()
            common.kill(ours())
        common.until("the end of all processes", lambda: not ours(), 30)


if __name__ == "__main__":
    main()
