#!/usr/bin/env python3
"""Times OpenCV's stripe chain and ductloop's perceptions on the same frames, in the same run, one thread each.

    python3 benches/opencv_chain.py [--frames 8] [--repeat 50] [--json]

OpenCV's chain is what the paper's needs of it: threshold, 3 x 3 closing, HoughLines with bins of 0.5 px and 0.25 degrees. It finds lines
only: no centres, no planes, no walls. ductloop's times are of all that, by `ductloop perceive --time`.

Frames are rendered by `ductloop render` (the processor's renderer, so the same everywhere). OpenCV comes from PyPI
(opencv-python-headless, numpy) into a virtual environment under target/, made on the first call; DUCTLOOP names the program if it is not to
be built here.
"""

import argparse
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time
import venv

ROOT = pathlib.Path(__file__).resolve().parent.parent
ENVIRONMENT = ROOT / "target" / "opencv-environment"
PACKAGES = ["opencv-python-headless", "numpy"]
SCENARIO = ROOT / "scenarios" / "straight-offset.toml"
# Hough's bins, and the votes that a line needs: a third of an image's width.
BIN_PX, BIN_DEG, VOTES = 0.5, 0.25, 200


def with_opencv():
    """Goes on in a Python that has OpenCV."""
    try:
        import cv2  # noqa: F401
        return
    except ImportError:
        pass
    python = ENVIRONMENT / ("Scripts" if os.name == "nt" else "bin") / "python"
    if pathlib.Path(sys.prefix).resolve() == ENVIRONMENT.resolve():
        sys.exit(f"error: OpenCV cannot be imported in {ENVIRONMENT}; remove that folder and try again")
    if not python.exists():
        print(f"making {ENVIRONMENT} …", file=sys.stderr)
        venv.create(ENVIRONMENT, with_pip=True)
    subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    os.execv(python, [str(python), str(pathlib.Path(__file__).resolve()), *sys.argv[1:]])


def program():
    """The program, built as it is shipped."""
    if named := os.environ.get("DUCTLOOP"):
        return named
    subprocess.run(["cargo", "build", "--release", "--quiet", "--locked"], cwd=ROOT, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return str(target / "release" / ("ductloop.exe" if os.name == "nt" else "ductloop"))


def render(ductloop, folder, count):
    """Frames of a run, a tenth of a second apart."""
    files = []
    for i in range(count):
        files.append(str(pathlib.Path(folder) / f"frame{i}.png"))
        call = [ductloop, "render", str(SCENARIO), "--at-s", str(i / 10), "--renderer", "cpu", "--quiet", "--out", files[-1]]
        subprocess.run(call, check=True)
    return files


def opencv_ms(files, repeat):
    """Medians of OpenCV's stages and of their sum, and how many lines it found in a frame."""
    import cv2
    import numpy

    cv2.setNumThreads(1)
    frames = [cv2.imread(file, cv2.IMREAD_GRAYSCALE) for file in files]
    kernel = numpy.ones((3, 3), numpy.uint8)
    stages = {"threshold": [], "close": [], "hough": []}
    sums, lines = [], []
    for frame in frames:
        # As high above the usual background as the paper's chain has it here.
        level = float(numpy.median(frame)) + 12.0
        for i in range(repeat + 3):
            started = time.perf_counter()
            _, binary = cv2.threshold(frame, level, 255, cv2.THRESH_BINARY)
            thresholded = time.perf_counter()
            binary = cv2.morphologyEx(binary, cv2.MORPH_CLOSE, kernel)
            closed = time.perf_counter()
            found = cv2.HoughLines(binary, BIN_PX, numpy.deg2rad(BIN_DEG), VOTES)
            ended = time.perf_counter()
            if i < 3:
                continue
            for stage, ms in zip(stages, (thresholded - started, closed - thresholded, ended - closed)):
                stages[stage].append(ms * 1e3)
            sums.append((ended - started) * 1e3)
        lines.append(0 if found is None else len(found))
    medians = {stage: statistics.median(times) for stage, times in stages.items()}
    return {"version": cv2.__version__, "ms": statistics.median(sums), "stages_ms": medians, "lines": statistics.median(lines)}


def ductloop_ms(ductloop, files, folder, repeat, pipeline):
    """The median of the frames' medians."""
    rig = [] if pipeline == "ridge" else ["--rig", str(SCENARIO), "--pipeline", pipeline]
    out = str(pathlib.Path(folder) / pipeline)
    call = [ductloop, "perceive", *files, *rig, "--time", str(repeat), "--json", "--out", out]
    document = json.loads(subprocess.run(call, check=True, stdout=subprocess.PIPE).stdout)
    return statistics.median(image["perceive_ms"] for image in document["images"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--frames", type=int, default=8, help="frames to time (8)")
    parser.add_argument("--repeat", type=int, default=50, help="repetitions a frame (50)")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    args = parser.parse_args()
    if args.frames < 1 or args.repeat < 1:
        parser.error("--frames and --repeat must be 1 or more")
    with_opencv()
    ductloop = program()
    with tempfile.TemporaryDirectory() as folder:
        files = render(ductloop, folder, args.frames)
        opencv = opencv_ms(files, args.repeat)
        ours = {pipeline: ductloop_ms(ductloop, files, folder, args.repeat, pipeline) for pipeline in ("robust", "paper", "ridge")}
    ratios = {pipeline: opencv["ms"] / ms for pipeline, ms in ours.items()}
    if args.json:
        result = {"frames": args.frames, "opencv": opencv, "ductloop_ms": ours, "ratio": ratios, "machine": platform.machine()}
        print(json.dumps(result, indent=2))
        return
    stages = ", ".join(f"{stage} {ms:.3f}" for stage, ms in opencv["stages_ms"].items())
    print(f"OpenCV {opencv['version']}, one thread: {opencv['ms']:.3f} ms ({stages}), {opencv['lines']:.0f} lines a frame")
    for pipeline, ms in ours.items():
        print(f"ductloop {pipeline + ',':8} one thread: {ms:.3f} ms; OpenCV's chain takes {ratios[pipeline]:.2f} times as long")


if __name__ == "__main__":
    main()
