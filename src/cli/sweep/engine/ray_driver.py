"""Runs the shards of a sweep as tasks of a Ray cluster; written here by `ductloop sweep --engine ray`, which starts and follows it.

One argument, JSON: `address` (or null), `work` (the command, without its shard), `shards`, `threads` (or null), `retries`.
Ends its tasks when standard input closes. Exit code 0 if every task ended with 0, else 1.
"""

import json
import os
import sys
import threading

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
import ray  # noqa: E402  (the variable comes first)


def work(command, shard):
    """One task: a worker of the sweep, which dies with the process that runs this."""
    import ctypes
    import signal
    import subprocess
    import sys

    def die_with_parent():
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG

    child = subprocess.Popen(
        command + ["--shard", shard], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, preexec_fn=die_with_parent
    )
    try:
        said, _ = child.communicate()
    except BaseException:
        # Cancelled: what is finished is kept, so it may go at once.
        child.kill()
        child.wait()
        raise
    if child.returncode != 0:
        raise RuntimeError(f"shard {shard}: exit code {child.returncode}: {said.decode(errors='replace')[-4000:]}")
    return said.decode(errors="replace").strip()


def main():
    order = json.loads(sys.argv[1])
    stop = threading.Event()

    def listen():
        sys.stdin.buffer.read()
        stop.set()

    threading.Thread(target=listen, daemon=True).start()
    ray.init(**({"address": order["address"]} if order["address"] else {}))
    cores = [int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"]]
    # A task may land on any node, and be begun again on any other: none may ask for more than the smallest has.
    smallest = min((count for count in cores if count > 0), default=1)
    threads = min(order["threads"] or smallest, smallest)
    print(f"{len(cores)} nodes with {cores} cores: {order['shards']} tasks of {threads}", flush=True)
    task = ray.remote(work).options(num_cpus=threads, max_retries=order["retries"], scheduling_strategy="SPREAD")
    command = order["work"] + ["--threads", str(threads)]
    shards = {task.remote(command, f"{index}/{order['shards']}"): index for index in range(1, order["shards"] + 1)}
    pending, failed = list(shards), 0
    while pending and not stop.is_set():
        ended, pending = ray.wait(pending, num_returns=1, timeout=0.5)
        for one in ended:
            try:
                print(f"shard {shards[one]}: {ray.get(one)}", flush=True)
            except Exception as error:
                failed += 1
                print(f"shard {shards[one]} failed: {error}", flush=True)
    for one in pending:
        ray.cancel(one)
    if pending:
        print(f"{len(pending)} tasks cancelled", flush=True)
        ray.wait(pending, num_returns=len(pending), timeout=10)
    ray.shutdown()
    return 1 if failed or pending else 0


if __name__ == "__main__":
    sys.exit(main())
