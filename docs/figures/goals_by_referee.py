"""docs/goals.md: the design's own slice of five goals as an independent referee sees it.

    python3 docs/figures/goals_by_referee.py REFEREE [GOAL ...]

REFEREE is the folder of the referee (Mitsuba's rays over the written STL; ../shared/referee), run with its own Python. The
slice that each plate should show is computed here, from the published formulas and with Smith's shadowing by a sum over the
density of normals: nothing of it comes from the program. Prints misplaced light at a blur of 1 degree, what leaves the field
counted. About four CPU minutes. Needs NumPy and Pillow, which the referee's Python has.
"""
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/release/facetmill"
STAR = ROOT / "examples/highlights/star.png"
# Of the painted density: its rim, degrees from the normal.
RIM = 30
# Pixels of the wanted slice a side, and samples of each along a side; of the densities; of the shadowing.
PIXELS, SAMPLES, NORMALS, SHADOWS = 512, 4, 256, 128


def square(n, half):
    """Places x, y of an n by n image of the square from -half to half, y downward."""
    at = (np.arange(n) + 0.5) / n * 2 - 1
    return np.meshgrid(half * at, half * at[::-1])


def tangent2(x, y):
    """Squared tangent and squared cosine of the tilt of normals (x, y, .)."""
    cos2 = np.maximum(1 - x**2 - y**2, 1e-9)
    return (1 - cos2) / cos2, cos2


def ggx(x, y, a=0.2):
    t2, c2 = tangent2(x, y)
    return 1 / (c2 * (1 + t2 / a**2)) ** 2


def blinn_phong(x, y, n=40):
    return tangent2(x, y)[1] ** (n / 2)


def shifted_gamma(x, y, a=0.195704, p=0.706913):
    t2, c2 = tangent2(x, y)
    return np.exp(-t2 / a) * (a**2 + t2) ** -p / c2**2


def star(x, y):
    drawn = np.asarray(Image.open(STAR).convert("L"), float) / 255
    light = np.where(drawn <= 0.04045, drawn / 12.92, ((drawn + 0.055) / 1.055) ** 2.4)
    rim, side = math.sin(math.radians(RIM)), len(light)
    column, row = [np.clip(((v / rim + 1) / 2 * side).astype(int), 0, side - 1) for v in (x, -y)]
    return np.where(x**2 + y**2 < rim**2, light[row, column], 0)


def smith(density, half):
    """Share of facets of a density within `half` that is seen from directions x, y, z (Smith 1967)."""
    x, y = square(NORMALS, half)
    within = x**2 + y**2 < half**2
    x, y = x[within], y[within]
    z = np.sqrt(1 - x**2 - y**2)
    area = density(x, y)
    # Facets over area: each stands for its projection, the sum of which is the plate.
    facets, normals = area / z / area.sum(), np.stack([x, y, z])

    def seen(*direction):
        towards = np.stack([v.ravel() for v in direction], 1)
        shares = [v[2] / max(float(np.maximum(v @ normals, 0) @ facets), 1e-12) for v in towards]
        return np.minimum(shares, 1).reshape(direction[0].shape)

    return seen


def directions(n, half):
    x, y = square(n, half)
    return x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 1e-4))


def microfacets(density, half_of_density):
    """d G / cos of a lamp straight above, orthographic, up to a factor."""

    def slice_of(half):
        x, y, z = directions(SAMPLES * PIXELS, half)
        length = np.sqrt(2 + 2 * z)
        value = np.where(x**2 + y**2 < 0.9999, density(x / length, y / length) / z, 0)
        fine = value.reshape(PIXELS, SAMPLES, PIXELS, SAMPLES).mean((1, 3))
        shadow = smith(density, half_of_density)(*directions(SHADOWS, half)).astype(np.float32)
        return fine * np.asarray(Image.fromarray(shadow).resize((PIXELS, PIXELS), Image.BILINEAR))

    return slice_of


def ward(half, along=0.1, across=0.3):
    x, y, z = directions(SAMPLES * PIXELS, half)
    exponent = ((x / along) ** 2 + (y / across) ** 2) / (1 + z) ** 2
    value = np.where(x**2 + y**2 < 0.9999, np.exp(-exponent) / np.sqrt(z), 0)
    return value.reshape(PIXELS, SAMPLES, PIXELS, SAMPLES).mean((1, 3))


GOALS = {
    "ward:0.1,0.3": ward,
    "blinn-phong:40": microfacets(blinn_phong, 0.999),
    "ggx:0.2": microfacets(ggx, 0.999),
    "shifted-gamma:0.195704,0.706913": microfacets(shifted_gamma, 0.999),
    f"ndf:{STAR},{RIM}": microfacets(star, math.sin(math.radians(RIM))),
}


def main(referee, *asked):
    for goal, slice_of in GOALS.items():
        if asked and not any(goal.startswith(name) for name in asked):
            continue
        with tempfile.TemporaryDirectory() as folder:
            plate = f"{folder}/plate"
            subprocess.run([PROGRAM, "design", "--goal", goal, "--no-verify", "--quiet", "-o", plate], check=True)
            field = float(re.search(r"half-field = ([\d.]+)", Path(plate, "recipe.toml").read_text())[1])
            wanted = slice_of(math.sin(math.radians(field)))
            Image.fromarray((wanted / wanted.max() * 65535).round().astype(np.uint16)).save(f"{folder}/wanted.png")
            sent = ["--theta", "0", "--phi", "0", "-H", str(field), "--projection", "orthographic", "-o", f"{folder}/out"]
            subprocess.run([sys.executable, f"{referee}/referee.py", f"{plate}/plate.stl", *sent], check=True, capture_output=True)
            compared = [f"{folder}/out.npz", f"{folder}/wanted.png", "-s", "1", "--mode", "flux", "--linear"]
            said = subprocess.run([sys.executable, f"{referee}/compare.py", *compared], check=True, capture_output=True, text=True)
            figures = json.loads(said.stdout)
            print(f"{goal.replace(str(STAR), 'star.png'):34} field {field:g} deg  TV(1) {figures[0]['tv_incident']:.4f}", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
