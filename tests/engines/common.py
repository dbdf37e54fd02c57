"""What the tests of engines share: a small sweep, its table, processes and their end."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import pyarrow.parquet as parquet

SCENARIO = """format = 1
kind = "scenario"
name = "short"
time_limit_s = 60.0
[duct]
width_m = 0.5
height_m = 0.3
run = [{ straight_m = 1.3 }]
[perception]
pipeline = "truth"
[pass]
completed = true
"""
SWEEP = """format = 1
kind = "sweep"
name = "engines"
base = "short.toml"
replicates = REPLICATES
[factor]
duct.width_m = [0.4, 0.5, 0.6]
robot.speed_m_s = [0.3, 0.5]
"""
STUDY = """format = 1
kind = "study"
name = "engines"
runs = RUNS
[parameter]
control.koh-cho.landing = { from = 0.005, to = 0.1, scale = "log" }
control.koh-cho.linear_lateral_mm = { from = 2.0, to = 50.0, scale = "log" }
[train]
base = "short.toml"
replicates = 2
[held_out]
base = "short.toml"
replicates = 6
seed = 1001
[scenario]
start.lateral_m = 0.05
pass.settle_m = 0.0
"""
POINTS = 6
# Columns that depend on the machine.
OF_THE_MACHINE = {"wall_time_s", "real_time_factor", "host"}


# Exit code of a test that this machine does not allow, as automake's.
NOT_HERE = 77
# What is waited for, to be said where it never comes.
waited_for = "nothing yet"


def not_here(why):
    """Ends a test that this machine does not allow. What was begun is ended by whoever called this."""
    print(f"this machine does not allow it: {why}", flush=True)
    sys.exit(NOT_HERE)


def within(seconds):
    """A test that has not ended after so many seconds fails, and says what it waited for."""

    def over(*_):
        raise AssertionError(f"not over within {seconds} s; it waited for {waited_for}")

    signal.signal(signal.SIGALRM, over)
    # Ended from outside it takes along what it has started, too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    signal.alarm(seconds)


def write_sweep(folder, replicates):
    """The sweep's file, of cases of a tenth of a second."""
    (folder / "short.toml").write_text(SCENARIO)
    path = folder / "engines.toml"
    path.write_text(SWEEP.replace("REPLICATES", str(replicates)))
    return path


def write_study(folder, runs, objectives=("lateral_rms_m",)):
    """A study's file, of runs of a tenth of a second: of these metrics."""
    (folder / "short.toml").write_text(SCENARIO)
    names = [""] if len(objectives) == 1 else [f".{metric}" for metric in objectives]
    tables = [f"[objective{name}]\nweights = {{ {metric} = 1.0 }}\n" for name, metric in zip(names, objectives)]
    path = folder / f"study-{len(objectives)}.toml"
    path.write_text(STUDY.replace("RUNS", str(runs)) + "".join(tables))
    return path


def tuned(out, name="engines"):
    """What a study came to: its candidates and its best, to the bit."""
    folder = pathlib.Path(out) / name
    return [(folder / name).read_bytes() for name in ("trials.parquet", "summary.json", "best.toml")]


def run(command, expect=0, **more):
    """Runs a program to its end; what it said on standard output."""
    global waited_for
    waited_for = " ".join(str(word) for word in command)
    ran = subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=900, **more)
    if ran.returncode != expect:
        raise AssertionError(f"{command}: exit code {ran.returncode}, not {expect}\n{ran.stdout}\n{ran.stderr}")
    return ran


def rows(table):
    """Rows by the hash of their case, without what depends on the machine; none may be there twice."""
    table = parquet.read_table(table)
    kept = [name for name in table.column_names if name not in OF_THE_MACHINE]
    # As text: NaN is equal to itself then.
    found = sorted((row["hash"], repr([row[name] for name in kept])) for row in table.select(kept).to_pylist())
    assert len({hash for hash, _ in found}) == len(found), "a case is there twice"
    return found


def local_rows(ductloop, sweep, folder):
    """The same sweep in one call on this machine."""
    run([ductloop, "sweep", sweep, "--out", folder / "local", "--quiet"])
    return rows(folder / "local" / "engines" / "results.parquet")


def compare(table, expected, cases):
    """Every case once, and the same to the bit as on this machine."""
    found = rows(table)
    assert len(found) == len(expected) == cases, f"{len(found)} rows, {len(expected)} of the local sweep, {cases} cases"
    different = [a for a, b in zip(found, expected) if a != b]
    assert not different, f"{len(different)} rows differ, the first: {different[0]}"
    print(f"{cases} cases: none lost, none twice, the same to the bit as on this machine alone", flush=True)


def parts_done(place):
    """Cases whose parts are in a sweep's folder."""
    names = [path.name for path in (pathlib.Path(place) / "parts").glob("*.parquet")]
    return sum(int(name.split("-")[1]) if name.startswith("pack-") else 1 for name in names)


def until(what, is_so, seconds, process=None):
    """Waits until something is so."""
    global waited_for
    waited_for = what
    started = time.monotonic()
    while not is_so():
        if process is not None and process.poll() is not None:
            raise AssertionError(f"it ended with {process.returncode} before {what}: {process.communicate()}")
        if time.monotonic() - started > seconds:
            raise AssertionError(f"{what} did not come within {seconds} s")
        time.sleep(0.1)
    return time.monotonic() - started


def ended(process, what, seconds):
    """What a process said on standard output and standard error, once it has ended."""
    global waited_for
    waited_for = what
    return process.communicate(timeout=seconds)


def processes(is_one):
    """Numbers of the processes of which `is_one(command line, environment)` holds; other users' are not looked at."""
    found = []
    for folder in pathlib.Path("/proc").iterdir():
        if folder.name.isdigit() and int(folder.name) != os.getpid():
            try:
                command = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
                environment = (folder / "environ").read_bytes().split(b"\0")
            except OSError:
                continue
            if command and is_one(command, environment):
                found.append(int(folder.name))
    return found


def parent(number):
    try:
        return int(pathlib.Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()[1])
    except OSError:
        return 0


def below(number):
    """A process and all that descends from it."""
    found = [number]
    for one in found:
        found += [other for other in processes(lambda *_: True) if parent(other) == one]
    return found


def kill(numbers):
    """As a power cut would."""
    for number in numbers:
        try:
            os.kill(number, signal.SIGKILL)
        except ProcessLookupError:
            pass
