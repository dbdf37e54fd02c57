"""A sweep whose plan and results are in an object store that speaks S3: PyPI's moto, on this machine.

s3.py DUCTLOOP, a program with the feature s3.
"""

import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request

import boto3
import common

REPLICATES = 15
# Within so many seconds a store that cannot be used is told of.
SOON = 20


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def refused(ductloop, sweep, place, words, **environment):
    """What cannot be used is named before anything runs, and soon."""
    started = time.monotonic()
    variables = {name: value for name, value in (os.environ | environment).items() if value is not None}
    said = common.run([ductloop, "sweep", sweep, "--out", place], expect=2, env=variables, cwd=sweep.parent).stderr
    seconds = time.monotonic() - started
    for word in [place, *words]:
        assert word in said, (word, said)
    assert seconds < SOON, seconds
    print(f"refused after {seconds:.1f} s: {said.splitlines()[0]}", flush=True)


def main():
    ductloop = pathlib.Path(sys.argv[1]).absolute()
    common.within(600)
    port = free_port()
    endpoint = f"http://127.0.0.1:{port}"
    for name in [name for name in os.environ if name.startswith("AWS_") or name.lower().endswith("_proxy")]:
        del os.environ[name]
    os.environ.update(
        AWS_ENDPOINT=endpoint, AWS_ALLOW_HTTP="true", AWS_ACCESS_KEY_ID="test", AWS_SECRET_ACCESS_KEY="test", AWS_REGION="us-east-1"
    )
    with tempfile.TemporaryDirectory(prefix="ductloop-s3-") as name:
        folder = pathlib.Path(name)
        sweep = common.write_sweep(folder, REPLICATES)
        cases = REPLICATES * common.POINTS
        expected = common.local_rows(ductloop, sweep, folder)
        log = (folder / "moto.log").open("w")
        server = subprocess.Popen(
            [sys.executable, "-m", "moto.server", "-p", str(port)], stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
        workers = []

        def work(place):
            command = [ductloop, "sweep", "work", place, "--threads", "1", "--json", "--quiet"]
            workers.append(subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
            return workers[-1]

        try:
            request = urllib.request.Request(f"{endpoint}/sweeps", method="PUT")

            def made():
                try:
                    return urllib.request.urlopen(request, timeout=5).status == 200
                except OSError:
                    return False

            common.until("a bucket", made, 60, server)
            place, started = "s3://sweeps/of/mine and yours", time.monotonic()
            common.run([ductloop, "sweep", "plan", sweep, "--out", place], cwd=folder)
            done = lambda: json.loads(common.run([ductloop, "sweep", "status", place, "--json"]).stdout)["done"]
            # Killed without a word: what is finished is kept.
            killed = work(place)
            common.until("cases", lambda: done() >= 6, 120, killed)
            killed.kill()
            common.ended(killed, "the end of a killed worker", 30)
            kept = done()
            assert 6 <= kept < cases, kept
            print(f"a worker killed at {kept} of {cases} cases", flush=True)
            # Two at the same shard at once: the first writer of a case wins, the other's is the same. Meanwhile the store sleeps a while.
            both = [work(place) for _ in range(2)]
            common.until("more cases", lambda: done() >= kept + 10, 120, both[0])
            server.send_signal(signal.SIGSTOP)
            time.sleep(8)
            server.send_signal(signal.SIGCONT)
            for one in both:
                said = common.ended(one, "the end of the work", 400)
                assert one.returncode == 0, said
                assert json.loads(said[0])["found"] >= kept, said
            assert done() == cases
            common.run([ductloop, "sweep", "merge", place])
            print(f"on S3, killed once, then twice at once: {time.monotonic() - started:.0f} s", flush=True)
            store = boto3.client("s3", endpoint_url=endpoint)
            store.download_file("sweeps", "of/mine and yours/results.parquet", str(folder / "results.parquet"))
            common.compare(folder / "results.parquet", expected, cases)
            # In one call, twice: the second time there is nothing to do.
            for _ in range(2):
                started = time.monotonic()
                common.run([ductloop, "sweep", sweep, "--out", "s3://sweeps", "--quiet"], cwd=folder)
                print(f"in one call: {time.monotonic() - started:.0f} s", flush=True)
            # What cannot be used: no bucket, nobody there, somebody who never answers, no keys, wrong keys.
            refused(ductloop, sweep, "s3://none/of/mine", ["NoSuchBucket"])
            nobody = f"http://127.0.0.1:{free_port()}"
            refused(ductloop, sweep, "s3://sweeps/of/mine", [nobody, "refused"], AWS_ENDPOINT=nobody)
            with socket.socket() as silent:
                silent.bind(("127.0.0.1", 0))
                silent.listen()
                mute = f"http://127.0.0.1:{silent.getsockname()[1]}"
                refused(ductloop, sweep, "s3://sweeps/of/mine", [mute], AWS_ENDPOINT=mute)
                no_keys = {"AWS_ACCESS_KEY_ID": None, "AWS_SECRET_ACCESS_KEY": None}
                refused(ductloop, sweep, "s3://sweeps/of/mine", ["AWS_ACCESS_KEY_ID"], AWS_METADATA_ENDPOINT=mute, **no_keys)
            # From now on moto looks at who asks, and knows nobody.
            plain = {"Content-Type": "text/plain"}
            urllib.request.urlopen(urllib.request.Request(f"{endpoint}/moto-api/reset-auth", data=b"0", headers=plain)).read()
            refused(ductloop, sweep, "s3://sweeps/of/mine", ["InvalidAccessKeyId"])
        except BaseException:
            print(f"--- moto\n{(folder / 'moto.log').read_text(errors='replace')[-3000:]}", file=sys.stderr)
            raise
        finally:
            for one in workers:
                one.kill()
            server.send_signal(signal.SIGCONT)
            server.terminate()
            server.wait(timeout=15)


if __name__ == "__main__":
    main()
