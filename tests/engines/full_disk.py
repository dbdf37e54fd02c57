"""A disk that fills up in mid-sweep: a small file system in memory, mounted where nobody else sees it.

full_disk.py DUCTLOOP. Exit code 77 where that may not be mounted: it takes root, or a user who may be root of a name space of his own.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

import common

REPLICATES = 12
INSIDE = "DUCTLOOP_TEST_INSIDE"


def main():
    ductloop = pathlib.Path(sys.argv[1]).absolute()
    if INSIDE not in os.environ:
        as_root = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--mount"]
        try:
            tried = subprocess.run([*as_root, "sh", "-c", "mount -t tmpfs none /mnt"], capture_output=True, text=True, timeout=30)
        except OSError as error:
            common.not_here(f"no file system can be mounted: {error}")
        if tried.returncode != 0:
            common.not_here(f"no file system can be mounted: {tried.stderr.strip()}")
        os.environ[INSIDE] = "yes"
        os.execvp(as_root[0], [*as_root, sys.executable, *sys.argv])
    common.within(300)
    with tempfile.TemporaryDirectory(prefix="ductloop-disk-") as name:
        folder = pathlib.Path(name)
        sweep = common.write_sweep(folder, REPLICATES)
        cases = REPLICATES * common.POINTS
        expected = common.local_rows(ductloop, sweep, folder)
        disk = folder / "disk"
        disk.mkdir()
        common.run(["mount", "-t", "tmpfs", "-o", "size=256k", "none", disk])
        try:
            call = [ductloop, "sweep", sweep, "--out", disk, "--quiet"]
            said = common.run(call, expect=3, cwd=folder).stderr
            place = disk / "engines"
            assert str(place / "parts") in said and "No space left" in said, said
            kept = common.parts_done(place)
            assert 0 < kept < cases, kept
            print(f"the disk was full at {kept} of {cases} cases: {said.splitlines()[0]}", flush=True)
            # Still full: the same, and nothing that is done is lost.
            common.run(call, expect=3, cwd=folder)
            assert common.parts_done(place) >= kept
            common.run(["mount", "-o", "remount,size=64m", disk])
            told = common.run([ductloop, "sweep", "work", place, "--json", "--quiet"], cwd=folder).stdout
            assert json.loads(told)["found"] >= kept, (told, kept)
            common.run(call, cwd=folder)
            common.compare(place / "results.parquet", expected, cases)
            assert not [path for path in place.rglob("*#*")], "something half written is left"
        finally:
            subprocess.run(["umount", disk], check=False)


if __name__ == "__main__":
    main()
