#!/usr/bin/env python3
"""Makes three plates of free triangles from one of a design, for `speed free`: as a decimated file, a scan and a turned plate are.

    python benches/rivals/free_plates.py plate.stl FOLDER

decimated.stl  the relief at 100,000 places at random, joined by Delaunay's triangles and closed
noisy.stl      the same with normal noise of a twentieth of the mean distance of places on its heights
turned.stl     the plate's own triangles, turned by 30 degrees about z
"""

import pathlib
import sys

import numpy as np
import trimesh
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay

PLACES = 100_000
RIM = 317  # places along each side


def closed(xy, z, base):
    """A solid between z over the places xy, which hold the corners of a rectangle, and the height base."""
    triangles = Delaunay(xy).simplices
    a, b, c = (xy[triangles[:, k]] for k in range(3))
    twice_area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[twice_area < 0] = triangles[twice_area < 0][:, [0, 2, 1]]
    triangles = triangles[np.abs(twice_area) > 1e-9]
    edges = {tuple(edge) for pair in ([0, 1], [1, 2], [2, 0]) for edge in triangles[:, pair]}
    rim = [(i, j) for i, j in edges if (j, i) not in edges]
    below = {i: len(xy) + k for k, (i, _) in enumerate(rim)}
    middle = len(xy) + len(rim)
    vertices = np.vstack([np.c_[xy, z], [[*xy[i], base] for i, _ in rim], [[*xy.mean(0), base]]])
    sides = [t for i, j in rim for t in ([i, below[i], below[j]], [i, below[j], j], [below[j], below[i], middle])]
    return trimesh.Trimesh(vertices, np.vstack([triangles, sides]), process=False)


plate = trimesh.load(sys.argv[1], process=False)
folder = pathlib.Path(sys.argv[2])
relief = plate.vertices[np.unique(plate.faces[plate.face_normals[:, 2] > 1e-3])]
low, high = relief[:, :2].min(0), relief[:, :2].max(0)
height = LinearNDInterpolator(relief[:, :2], relief[:, 2])
random = np.random.default_rng(1)
s = np.linspace(0, 1, RIM)
rim = np.unique(np.round(np.vstack([np.c_[s, 0 * s], np.c_[s, 0 * s + 1], np.c_[0 * s, s], np.c_[0 * s + 1, s]]), 9), axis=0)
xy = low + (high - low) * np.vstack([random.random((PLACES, 2)), rim])
z = np.nan_to_num(height(xy), nan=relief[:, 2].mean())
noise = 0.05 * np.sqrt(np.prod(high - low) / PLACES)
closed(xy, z, plate.vertices[:, 2].min()).export(folder / "decimated.stl")
closed(xy, z + random.normal(0, noise, len(z)), plate.vertices[:, 2].min()).export(folder / "noisy.stl")
plate.apply_transform(trimesh.transformations.rotation_matrix(np.radians(30), [0, 0, 1]))
plate.export(folder / "turned.stl")
