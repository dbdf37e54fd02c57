#!/usr/bin/env python3
"""How much sooner seeds are through with two runs at once: `ductloop run --seeds 1..8`, with --jobs 1 and --jobs 2, one thread a run.

    python3 benches/jobs.py [--pairs 3] [--seeds 1..8] [--scenario scenarios/straight.toml]

Pairs in one call, and the median of their ratios, as machines are busy now and then: where others compute at the same time, two runs get
twice the share that one gets, whatever they cost, so the processor time and the load are told beside the ratio. Both must give the same
hashes. DUCTLOOP names the program; without it target/release/ductloop is taken.
"""

import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


def measure(program, options, jobs, out):
    """Seconds, seconds of processor time, and the hashes of all runs."""
    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before, started = used(), time.monotonic()
    args = ["run", options.scenario, "--seeds", options.seeds, "--jobs", str(jobs), "--threads", "1", "--renderer", "cpu"]
    ran = subprocess.run([program, *args, "--json", "--quiet", "--out", out], stdout=subprocess.PIPE, check=True)
    hashes = [run["run_hash"] for run in json.loads(ran.stdout)["runs"]]
    return time.monotonic() - started, used() - before, hashes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--seeds", default="1..8")
    parser.add_argument("--scenario", default=str(ROOT / "scenarios" / "straight.toml"))
    options = parser.parse_args()
    program = os.environ.get("DUCTLOOP", str(ROOT / "target" / "release" / "ductloop"))
    ratios = []
    with tempfile.TemporaryDirectory() as out:
        for _ in range(options.pairs):
            one, two = (measure(program, options, jobs, out) for jobs in (1, 2))
            assert one[2] == two[2], "the hashes differ"
            ratios.append(one[0] / two[0])
            told = "  ".join(f"--jobs {jobs}: {s:.1f} s (processor {cpu:.1f} s)" for jobs, (s, cpu, _) in ((1, one), (2, two)))
            print(f"{told}  ratio {ratios[-1]:.2f}  load {os.getloadavg()[0]:.1f}", flush=True)
    print(f"median ratio {statistics.median(ratios):.2f}")


if __name__ == "__main__":
    main()
