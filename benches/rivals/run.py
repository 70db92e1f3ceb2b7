#!/usr/bin/env python3
"""Times facetmill beside other programs on the same problems, run by turns: prints medians in CPU seconds, and ratios.

    python benches/rivals/run.py SPEED PLATE [EMBREE_PATHS] [--runs 7] [--paths 4000000]

SPEED is the built example `speed`, PLATE a folder that `facetmill design` left (for the assignment: at most 1000 facets).
W1 is timed against POT's network simplex, the assignment against SciPy's, paths against Embree where its loop is given.
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time

# One thread on either side.
os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import numpy as np
import ot
import scipy
from PIL import Image
from scipy.optimize import linear_sum_assignment

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("speed")
parser.add_argument("plate")
parser.add_argument("embree", nargs="?")
parser.add_argument("--runs", type=int, default=7)
parser.add_argument("--paths", type=int, default=4_000_000)
asked = parser.parse_args()


def ours(*words):
    """One run of SPEED."""
    return json.loads(subprocess.run([asked.speed, *map(str, words)], check=True, capture_output=True, text=True).stdout)


def timed(job):
    """What the job gives, and its CPU seconds in this thread."""
    start = time.thread_time()
    value = job()
    return value, time.thread_time() - start


def median(values):
    """Median with the range, as text and number."""
    middle = statistics.median(values)
    return middle, f"{middle:.4g} s ({min(values):.4g} to {max(values):.4g})"


def say(job, mine, theirs, note=""):
    """One line of the result."""
    (a, text_a), (b, text_b) = median(mine), median(theirs)
    print(f"{job}: {text_a}; rival {text_b}; rival/ours {b / a:.2f} {note}", flush=True)


def light(path):
    """Linear light of a grey sRGB picture, 64 x 64, sum 1."""
    a = np.asarray(Image.open(path).convert("L")).astype(float) / 255
    a = np.where(a <= 0.04045, a / 12.92, ((a + 0.055) / 1.055) ** 2.4)
    assert a.shape == (256, 256), a.shape
    a = a.reshape(64, 4, 64, 4).sum((1, 3))
    return a / a.sum()


def transport_problem(a, b):
    """What has to move, where to, and the angles in degrees between pixels of the default field."""
    u = ((np.arange(64) + 0.5) / 64 * 2 - 1) * np.sin(np.radians(20))
    x, y = np.meshgrid(u, -u)
    o = np.stack([x, y, np.sqrt(1 - x * x - y * y)], -1).reshape(-1, 3)
    a, b = a.ravel(), b.ravel()
    p, q = np.maximum(a - b, 0), np.maximum(b - a, 0)
    i, j = np.nonzero(p > 1e-9 * p.sum())[0], np.nonzero(q > 1e-9 * p.sum())[0]
    chord = np.linalg.norm(o[i][:, None] - o[j][None], axis=2)
    return p[i] / p[i].sum(), q[j] / q[j].sum(), np.degrees(2 * np.arcsin(chord / 2)), p.sum()


def race_w1(name, one, other):
    """POT gets the cost matrix for nothing; ours builds it."""
    p, q, cost, moved = transport_problem(light(one), light(other))
    mine, theirs, values = [], [], []
    for _ in range(asked.runs):
        run = ours("w1", one, other)
        mine.append(run["seconds"])
        value, seconds = timed(lambda: ot.emd2(p, q, cost, numItermax=10_000_000))
        theirs.append(seconds)
        values = [run["w1_deg"], value * moved]
    assert abs(values[0] - values[1]) < 1e-6, values
    say(f"W1 {name}, {len(p)} x {len(q)}", mine, theirs, f"(both {values[0]:.6f} degrees)")


def race_assignment():
    mine, arranging, theirs = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(asked.runs):
            run = ours("assignment", asked.plate, f"{folder}/cost")
            cost = np.fromfile(f"{folder}/cost", "<f8").reshape(run["n"], run["n"])
            (rows, columns), seconds = timed(lambda: linear_sum_assignment(cost))
            assert abs(cost[rows, columns].sum() - run["total"]) < 1e-9 * np.abs(cost).sum()
            mine.append(run["seconds"])
            arranging.append(run["seconds_arranging"])
            theirs.append(seconds)
    say(f"assignment of {run['n']}, no order", mine, theirs)
    say(f"whole transport arrangement of {run['n']}", arranging, theirs)


def race_paths():
    mine, theirs = {}, []
    for _ in range(asked.runs):
        run = ours("paths", asked.plate, asked.paths)
        for job, seconds in run["seconds"].items():
            mine.setdefault(job, []).append(seconds)
        said = subprocess.run([asked.embree, f"{asked.plate}/plate.stl", str(asked.paths), "1"], check=True, capture_output=True, text=True).stdout
        theirs.append(run["paths"] / 1e6 / float(re.search(r"([\d.]+) M paths/CPU-s", said)[1]))
    for job in ["grid", "mesh", "measure"]:
        rate = run["paths"] / 1e6
        note = f"({rate / statistics.median(mine[job]):.2f} against {rate / statistics.median(theirs):.2f} M paths/CPU-s)"
        say(f"{job}, {run['triangles']} triangles", mine[job], theirs, note)
    print(f"planting a tree over {run['triangles']} triangles: {median(mine['planting'])[1]}")


print(f"numpy {np.__version__}, scipy {scipy.__version__}, POT {ot.__version__}, Python {sys.version.split()[0]}")
if asked.embree:
    race_paths()
else:
    pictures = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "highlights")
    race_w1("portrait to letter", f"{pictures}/portrait.png", f"{pictures}/letter.png")
    race_w1("simulated to wanted", f"{asked.plate}/simulated.png", f"{asked.plate}/target.png")
    race_assignment()
