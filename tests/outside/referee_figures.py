"""Asks the independent referee what a plate does, in one process: measures the STL, compares it with a picture, prints JSON.

    python referee_figures.py REFEREE PLATE.stl PICTURE '{"theta": 30, "half_field": 15, ...}'

The last argument holds the referee's measure() settings, and the picture's "mode". Exit 3 if a package is missing.
"""

import json
import sys

# The referee's folder may be read-only, or shared: leave nothing in it.
sys.dont_write_bytecode = True

referee_folder, plate, picture, settings = sys.argv[1:]
sys.path.insert(0, referee_folder)
try:
    import compare
    import mitsuba  # noqa: F401  (the referee imports it late)
    import ot  # noqa: F401
    import referee
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)

settings = json.loads(settings)
mode = settings.pop("mode")
measured = referee.measure(referee.Plate.load(plate), **settings)
numbers = measured["numbers"]
scores = compare.compare(measured["image"], measured["meta"], numbers, compare.read_target(picture), 1.0, mode)
print(json.dumps({
    **{key: scores[key] for key in ["tv", "tv_incident", "ssim", "efficiency", "w1_deg"]},
    **{key: numbers[key] for key in ["multi_of_up", "blocked_total", "backface", "balance"]},
}))
