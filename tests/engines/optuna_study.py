"""A study that Optuna drives: alone, with the optimiser killed in mid-study, and with the study itself killed.

optuna_study.py DUCTLOOP. Called again, both come to what an undisturbed call came to.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import common

SCRIPT = "optuna_optimiser.py"
STUDY = "engines-optuna"


def main():
    ductloop = pathlib.Path(sys.argv[1]).absolute()
    common.within(300)
    with tempfile.TemporaryDirectory(prefix="ductloop-optuna-") as name:
        folder = pathlib.Path(name)
        study = common.write_study(folder, runs=96)
        call = [ductloop, "tune", study, "--engine", "optuna", "--python", sys.executable, "--threads", "2", "--out"]
        common.run([*call, folder / "whole"])
        expected = common.tuned(folder / "whole", STUDY)
        summary = json.loads((folder / "whole" / STUDY / "summary.json").read_text())
        assert summary["optimiser"].startswith("Optuna ") and "TPE" in summary["optimiser"], summary["optimiser"]
        assert summary["best"]["costs"]["cost"] < summary["default"]["costs"]["cost"], summary
        print(f"{summary['optimiser']}: {summary['trials']} candidates, {summary['verdict'][-1]}", flush=True)

        # The optimiser dies, then the study: what was run and proposed is kept, and nothing of either is left behind.
        out = folder / "killed"
        optimisers = lambda: common.processes(lambda line, _: SCRIPT in line and str(out) in line)
        begin = lambda: subprocess.Popen(
            [str(word) for word in [*call, out]], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        generations = lambda: (out / STUDY / "candidates.jsonl").read_text().count("\n") if (out / STUDY / "candidates.jsonl").exists() else 0
        going = begin()
        common.until("two generations", lambda: generations() >= 2, 120, going)
        common.kill(optimisers())
        said = common.ended(going, "the end without an optimiser", 60)
        assert going.returncode == 3 and "signal: 9" in said[1] and "is kept" in said[1], said
        first = generations()
        going = begin()
        common.until("more generations", lambda: generations() >= first + 2, 120, going)
        going.kill()
        common.ended(going, "the end of a killed call", 30)
        common.until("the end of its optimiser", lambda: not optimisers(), 30)
        second = generations()
        common.run([*call, out])
        assert generations() > second > first, (first, second, generations())
        assert common.tuned(out, STUDY) == expected, "another course than without interruption"
        print(f"killed after {first} generations and after {second}: the same candidates and the same best, to the bit", flush=True)

        several = common.write_study(folder, runs=60, objectives=["lateral_rms_m", "control_effort"])
        common.run([*call[:2], several, *call[3:], folder / "several"])
        summary = json.loads((folder / "several" / STUDY / "summary.json").read_text())
        assert "NSGA" in summary["optimiser"] and len(summary["front"]) > 1, summary
        print(f"{summary['optimiser']}: {len(summary['front'])} of {summary['trials']} candidates on the front", flush=True)


if __name__ == "__main__":
    main()
