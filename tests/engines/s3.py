"""A sweep whose plan and results are in an object store that speaks S3: PyPI's moto, on this machine.

s3.py DUCTLOOP, a program with the feature s3.
"""

import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

import common

REPLICATES = 40


def main():
    ductloop = pathlib.Path(sys.argv[1]).absolute()
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    endpoint = f"http://127.0.0.1:{port}"
    os.environ |= {
        "AWS_ENDPOINT": endpoint,
        "AWS_ALLOW_HTTP": "true",
        "AWS_ACCESS_KEY_ID": "test",
        "AWS_SECRET_ACCESS_KEY": "test",
        "AWS_REGION": "us-east-1",
    }
    with tempfile.TemporaryDirectory(prefix="ductloop-s3-") as name:
        folder = pathlib.Path(name)
        sweep = common.write_sweep(folder, REPLICATES)
        expected = common.local_rows(ductloop, sweep, folder)
        log = (folder / "moto.log").open("w")
        server = subprocess.Popen(
            [sys.executable, "-m", "moto.server", "-p", str(port)], stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
        try:
            request = urllib.request.Request(f"{endpoint}/sweeps", method="PUT", headers={"Host": f"127.0.0.1:{port}"})

            def made():
                try:
                    return urllib.request.urlopen(request, timeout=5).status == 200
                except OSError:
                    return False

            common.until("a bucket", made, 60, server)
            place, started = "s3://sweeps/of/mine", time.monotonic()
            common.run([ductloop, "sweep", "plan", sweep, "--out", place], cwd=folder)
            # Two at the same shard at once: the first writer of a case wins, the other's is the same.
            work = [ductloop, "sweep", "work", place, "--threads", "1", "--quiet"]
            both = [subprocess.Popen(work, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for _ in range(2)]
            for one in both:
                said = one.communicate(timeout=600)[1]
                assert one.returncode == 0, said
            told = common.run([ductloop, "sweep", "status", place, "--json"]).stdout
            assert '"missing": 0' in told, told
            common.run([ductloop, "sweep", "merge", place])
            print(f"on S3, twice at once: {time.monotonic() - started:.0f} s", flush=True)
            table = urllib.request.urlopen(f"{endpoint}/sweeps/of/mine/results.parquet").read()
            (folder / "results.parquet").write_bytes(table)
            common.compare(folder / "results.parquet", expected, REPLICATES * common.POINTS)
            # A bucket that is not there is named before anything runs.
            said = common.run([ductloop, "sweep", sweep, "--out", "s3://none/of/mine"], expect=2).stderr
            assert "s3://none/of/mine" in said, said
        except BaseException:
            print(f"--- moto\n{(folder / 'moto.log').read_text(errors='replace')[-3000:]}", file=sys.stderr)
            raise
        finally:
            server.terminate()
            server.wait(timeout=15)


if __name__ == "__main__":
    main()
