#!/usr/bin/env python3
"""Runs the examples of docs/sweeps.md that read results, as they stand there, on a sweep's real table.

    python3 tests/reading_results.py

DuckDB and polars come from PyPI into a virtual environment under target/, made on the first call; where they cannot be had (no network) it
says so and is skipped. DUCTLOOP names the program if it is not to be built here.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import venv

ROOT = pathlib.Path(__file__).resolve().parent.parent
ENVIRONMENT = ROOT / "target" / "reading-environment"
PACKAGES = ["duckdb", "polars"]


def program():
    """The program, built if nobody names one."""
    if "DUCTLOOP" in os.environ:
        return pathlib.Path(os.environ["DUCTLOOP"]).resolve()
    subprocess.run(["cargo", "build", "--release", "--locked", "--quiet"], cwd=ROOT, check=True)
    return ROOT / "target" / "release" / "ductloop"


def environment():
    """The environment's Python with the packages in it; None where they cannot be had."""
    python = ENVIRONMENT / "bin" / "python"
    have = [python, "-c", "import " + ", ".join(PACKAGES)]
    if python.exists() and subprocess.run(have, capture_output=True).returncode == 0:
        return python
    try:
        venv.create(ENVIRONMENT, with_pip=True, clear=True)
    except (subprocess.CalledProcessError, OSError) as error:
        print(f"skipped: no virtual environment can be made here (Debian: apt-get install python3-venv): {error}")
        return None
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES]
    installed = subprocess.run(install, capture_output=True, text=True)
    if installed.returncode != 0:
        last = (installed.stderr.strip().splitlines() or ["pip does not say why"])[-1]
        print(f"skipped: {' and '.join(PACKAGES)} cannot be had from PyPI: {last}")
        return None
    return python


def examples(language):
    """The document's blocks of a language."""
    text = (ROOT / "docs" / "sweeps.md").read_text()
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def main():
    python = environment()
    if python is None:
        return
    with tempfile.TemporaryDirectory() as folder:
        # The table that the document speaks of, of a sweep small enough for a test: two widths, both rigs.
        sweep = [program(), "sweep", ROOT / "scenarios" / "sweeps" / "duct-width.toml", "--quiet", "--out", "out"]
        for setting in ["replicates=1", "factor.duct.width_m=[0.4, 0.5]", "scenario.duct.run=[{ straight_m = 3.2 }]"]:
            sweep += ["--set", setting]
        subprocess.run(sweep, cwd=folder, check=True)
        made = next(pathlib.Path(folder, "out").iterdir())
        made.rename(pathlib.Path(folder, "out", "duct-width"))
        (sql,) = examples("sql")
        read = "import sys, duckdb; rows = duckdb.sql(sys.argv[1]).fetchall(); print(*rows, sep='\\n'); assert len(rows) == 4, rows"
        subprocess.run([python, "-c", read, sql.strip().rstrip(";")], cwd=folder, check=True)
        (code,) = examples("python")
        told = subprocess.run([python, "-c", code], cwd=folder, check=True, capture_output=True, text=True).stdout
        print(told)
        assert "shape: (4, 4)" in told, told


if __name__ == "__main__":
    sys.exit(main())
