"""Tip heights of this program beside OpenCAMLib's drop cutter, at the same places over the same STL, a thread each.

    python3 benches/rivals/tips.py MACHINING PLATE.stl CUTTER [PLACES [THEIRS]]

MACHINING is the built example `machining`; CUTTER ball:D, bull:D,CORNER or cone:ANGLE,TIP,D as the program spells it
(OpenCAMLib's cone is pointed: take the least TIP there is). OpenCAMLib (pip install opencamlib) is asked at every n-th of
the PLACES [100000], THEIRS of them [2000]. Prints both rates in places a CPU second without and with the building of either
tree, their ratio, and by how much heights differ.
"""
import json
import math
import subprocess
import sys
import tempfile
import time

import numpy as np
import opencamlib


def cutter(text, length):
    shape, sizes = text.split(":")
    sizes = [float(size) for size in sizes.split(",")]
    match shape:
        case "ball":
            return opencamlib.BallCutter(sizes[0], length)
        case "bull":
            return opencamlib.BullCutter(sizes[0], sizes[1], length)
        case "cone":
            return opencamlib.ConeCutter(sizes[2], math.radians(sizes[0] / 2), length)
    sys.exit(f"{text}: not a cutter that both know")


def surface(file):
    raw = open(file, "rb").read()
    count = int.from_bytes(raw[80:84], "little")
    records = np.frombuffer(raw, np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]), count, 84)
    corners = records["v"].astype(float)
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0
    found = opencamlib.STLSurf()
    for triangle in corners[up]:
        found.addTriangle(opencamlib.Triangle(*(opencamlib.Point(*map(float, corner)) for corner in triangle)))
    return found


def main(machining, plate, spelled, places=100_000, theirs=2_000):
    with tempfile.NamedTemporaryFile() as out:
        said = json.loads(subprocess.check_output([machining, "tips", plate, spelled, str(places), out.name]))
        ours = np.fromfile(out.name, "<f8").reshape(-1, 3)
    asked = ours[:: max(1, len(ours) // int(theirs))]
    triangles, tool = surface(plate), cutter(spelled, 50.0)
    batch = opencamlib.BatchDropCutter()
    batch.setThreads(1)
    started = time.process_time()
    batch.setSTL(triangles)
    batch.setCutter(tool)
    building = time.process_time() - started
    below = float(ours[np.isfinite(ours[:, 2]), 2].min()) - 1
    for x, y, _ in asked:
        batch.appendPoint(opencamlib.CLPoint(float(x), float(y), below))
    started = time.process_time()
    batch.run()
    seconds = time.process_time() - started
    heights = np.array([point.z for point in batch.getCLPoints()])
    apart = 1e3 * np.abs(heights - asked[:, 2])
    rate = len(asked) / seconds
    whole = [count / (count / speed + built) for count, speed, built in
             [(int(places), said["places_per_s"], said["building_s"]), (int(places), rate, building)]]  # fmt: skip
    print(json.dumps({
        "cutter": spelled, "triangles": said["triangles"], "ours_per_s": round(said["places_per_s"]),
        "theirs_per_s": round(rate), "ratio": round(said["places_per_s"] / rate), "ratio_with_building": round(whole[0] / whole[1]),
        "building_s": [round(said["building_s"], 3), round(building, 3)], "places_compared": len(asked),
        "apart_um": {"most": float(apart.max()), "99.9 %": float(np.quantile(apart, 0.999)), "median": float(np.median(apart))},
        "beyond_0.05_um": int((apart > 0.05).sum()), "of_them_ours_higher": int(((apart > 0.05) & (asked[:, 2] > heights)).sum()),
    }))  # fmt: skip


if __name__ == "__main__":
    main(*sys.argv[1:])
