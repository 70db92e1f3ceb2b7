"""Reads the files of a design's folder with programs of others, and prints what they find as JSON.

    python read_files.py DIR

trimesh reads STL, OBJ, PLY and 3MF, manifold3d judges the solids, Pillow and tifffile read the height map; heights are
taken from the triangles. Exit 3 if a package is missing.
"""

import json
import os
import sys

try:
    import lxml  # noqa: F401 (trimesh reads 3MF with it)
    import manifold3d
    import networkx  # noqa: F401
    import numpy as np
    import tifffile
    import trimesh
    from PIL import Image
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)

folder = sys.argv[1]


def load(name):
    return trimesh.load(os.path.join(folder, name), force="mesh", process=False)


def corners(mesh):
    """The corners of all triangles in single precision, in order."""
    return np.asarray(mesh.vertices, dtype=np.float32)[np.asarray(mesh.faces)]


stl = load("plate.stl")
report = {"triangles": len(stl.faces)}
for name in ["plate.obj", "plate.ply", "plate.3mf"]:
    mesh = load(name)
    body = manifold3d.Manifold(
        manifold3d.Mesh(
            vert_properties=np.asarray(mesh.vertices, dtype=np.float32),
            tri_verts=np.asarray(mesh.faces, dtype=np.uint32),
        )
    )
    report[name] = {
        "same": bool(np.array_equal(corners(mesh), corners(stl))),
        "watertight": bool(mesh.is_watertight and mesh.is_volume),
        "manifold": body.status() == manifold3d.Error.NoError,
        "extents": mesh.extents.tolist(),
        "units": mesh.units,
    }

path = os.path.join(folder, "heightmap.tiff")
with tifffile.TiffFile(path) as file:
    page = file.pages[0]
    grey = page.asarray()
    scale = json.loads(page.description)
    pixels = page.tags["XResolution"].value
pillow = np.asarray(Image.open(path))
heights = scale["z_low_mm"] + grey / 65535 * (scale["z_high_mm"] - scale["z_low_mm"])

# The highest triangle that faces up over some pixels' centres.
up = corners(stl).astype(float)
normals = np.cross(up[:, 1] - up[:, 0], up[:, 2] - up[:, 0])
up, normals = up[normals[:, 2] > 0], normals[normals[:, 2] > 0]
worst = 0.0
for row, column in np.random.default_rng(1).integers(0, grey.shape, (400, 2)):
    x = scale["lower_left_mm"][0] + (column + 0.5) * scale["mm_per_pixel"][0]
    y = scale["lower_left_mm"][1] + (grey.shape[0] - row - 0.5) * scale["mm_per_pixel"][1]
    edges = np.roll(up, -1, axis=1)[:, :, :2] - up[:, :, :2]
    beside = edges[:, :, 0] * (y - up[:, :, 1]) - edges[:, :, 1] * (x - up[:, :, 0])
    inside = (beside >= 0).all(axis=1)
    first, normal = up[inside][:, 0], normals[inside]
    z = first[:, 2] - (normal[:, 0] * (x - first[:, 0]) + normal[:, 1] * (y - first[:, 1])) / normal[:, 2]
    worst = max(worst, np.abs(z - heights[row, column]).min())
report["heightmap.tiff"] = {
    "bits": int(page.bitspersample),
    "alike": bool(np.array_equal(pillow, grey) and np.array_equal(np.asarray(Image.open(path[:-4] + "png")), grey)),
    "step_mm": (scale["z_high_mm"] - scale["z_low_mm"]) / 65535,
    "worst_mm": float(worst),
    "pixels_per_cm": pixels[0] / pixels[1],
    "mm_per_pixel": scale["mm_per_pixel"],
}
print(json.dumps(report))
