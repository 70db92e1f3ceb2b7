"""Asks the independent referee for highlight images: one process for many plates and lamps.

    python referee_image.py REFEREE JOBS.json

JOBS.json lists objects with "plate" (an STL), "image" (where the pixels go, little-endian f64, as shares of incident
light), "eta", "k", "alpha", and whatever else the referee's measure() takes. For each job a line of JSON with the
referee's numbers is printed. Exit 3 if a package is missing.
"""

import json
import sys

# The referee's folder may be read-only, or shared: leave nothing in it.
sys.dont_write_bytecode = True

referee_folder, jobs = sys.argv[1:]
sys.path.insert(0, referee_folder)
try:
    # First: it names the compiler that Mitsuba's rough metal needs, which Mitsuba looks for when it is imported.
    import referee
    import mitsuba  # noqa: F401  (the referee imports it late)
    import trimesh  # noqa: F401
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)

tracers = {}
for job in json.load(open(jobs)):
    path, image = job.pop("plate"), job.pop("image")
    material = referee.Material(job.pop("eta"), job.pop("k"), job.pop("alpha"))
    if path not in tracers:
        plate = referee.Plate.load(path)
        tracers[path] = plate, referee.Tracer(plate)
    plate, tracer = tracers[path]
    measured = referee.measure(plate, material=material, tracer=tracer, **job)
    numbers = measured["numbers"]
    (measured["image"] * numbers["up"]).astype("<f8").tofile(image)
    print(json.dumps(numbers))
