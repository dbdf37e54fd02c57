#!/usr/bin/env python3
"""An optimiser of one's own for `ductloop tune`: (1+1) evolution with the one-fifth rule, over lines of JSON (docs/tuning.md).

    ductloop tune smoke --optimiser 'python3 examples/optimiser.py'
"""
import json, math, random, sys

def say(message):
    print(json.dumps(message), flush=True)

for line in sys.stdin:
    message = json.loads(line)
    if message["message"] == "begin":
        parameters, step, best = message["parameters"], 0.2, None
        parent = [0.5] * len(parameters)  # as shares of the ranges
        random.seed(message["seed"])
        say({"ready": "(1+1) evolution"})
    elif message["message"] == "ask":
        child = [min(1, max(0, share + random.gauss(0, step))) for share in parent]
        values = {}
        for share, p in zip(child, parameters):
            between = lambda a, b: a + share * (b - a)
            log = p["scale"] == "log"
            value = math.exp(between(math.log(p["from"]), math.log(p["to"]))) if log else between(p["from"], p["to"])
            value = min(p["to"], max(p["from"], value))
            values[p["path"]] = round(value) if p["whole"] else value
        say({"candidates": [values]})
    elif message["message"] == "tell" and message["trials"][0]["trial"] > 0 and not message["trials"][0]["is_replayed"]:
        told = message["trials"][0]
        rank = (told["violation"], told["costs"][0] if told["costs"][0] is not None else math.inf)
        if best is None or rank <= best:
            parent, best, step = child, rank, step * 1.5
        else:
            step *= 1.5 ** -0.25
