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
        parameters, step, best = message["parameters"], 0.2, (math.inf, math.inf)
        parent = [0.5] * len(parameters)  # as shares of the ranges, in the logarithm where they are logarithmic
        scale = lambda p, x: math.log(x) if p["scale"] == "log" else x
        random.seed(message["seed"])
        say({"ready": "(1+1) evolution"})
    elif message["message"] == "ask":
        values = {}
        for share, p in zip(parent, parameters):
            share = min(1, max(0, share + random.gauss(0, step)))
            value = scale(p, p["from"]) + share * (scale(p, p["to"]) - scale(p, p["from"]))
            value = min(p["to"], max(p["from"], math.exp(value) if p["scale"] == "log" else value))
            values[p["path"]] = round(value) if p["whole"] else value
        say({"candidates": [values]})
    elif message["message"] == "tell":
        for told in message["trials"]:  # what an earlier call proposed is learned from like what was asked for
            rank = (told["violation"], math.inf if told["costs"][0] is None else told["costs"][0])
            if told["values"] and rank <= best:
                best, step = rank, step * 1.5
                parent = [(scale(p, told["values"][p["path"]]) - scale(p, p["from"])) / (scale(p, p["to"]) - scale(p, p["from"])) for p in parameters]
            elif told["trial"] > 0:
                step *= 1.5 ** -0.25
