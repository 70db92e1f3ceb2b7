"""Judges STL files with manifold3d and trimesh: one line a file, exit 0 if all are sound, 1 if not, 3 if a judge is missing."""

import sys

try:
    import manifold3d
    import numpy as np
    import trimesh
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)

RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def faults(path):
    """What is wrong with the file, and its triangle count and volume."""
    with open(path, "rb") as file:
        count = int.from_bytes(file.read(84)[80:], "little")
        records = np.frombuffer(file.read(), RECORD)
    wrong = []
    if len(records) != count:
        wrong.append(f"{len(records)} records for a count of {count}")
    # Merged by exact bits only, so that a gap of one rounding step would be seen.
    corners = np.ascontiguousarray(records["corners"]).reshape(-1, 3)
    _, first, ids = np.unique(corners.view("V12").ravel(), return_index=True, return_inverse=True)
    vertices, faces = corners[first], ids.reshape(-1, 3)

    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    forth, back = edges[:, 0] * len(vertices) + edges[:, 1], edges[:, 1] * len(vertices) + edges[:, 0]
    if len(np.unique(forth)) != len(forth):
        wrong.append("an edge is used twice one way")
    if not np.array_equal(np.sort(forth), np.sort(back)):
        wrong.append("an edge is open")

    body = manifold3d.Manifold(manifold3d.Mesh(vert_properties=vertices, tri_verts=faces.astype(np.uint32)))
    if body.status() != manifold3d.Error.NoError:
        wrong.append(f"manifold3d says {body.status()}")
    elif len(body.decompose()) != 1:
        wrong.append(f"manifold3d sees {len(body.decompose())} bodies")

    mesh = trimesh.load(path, file_type="stl")
    if len(mesh.faces) != count:
        wrong.append(f"trimesh keeps {len(mesh.faces)} of {count} triangles")
    for name in ["is_watertight", "is_winding_consistent", "is_volume"]:
        if not getattr(mesh, name):
            wrong.append(f"trimesh: not {name}")
    if not mesh.volume > 0:
        wrong.append(f"trimesh: volume {mesh.volume}")
    if body.status() == manifold3d.Error.NoError and abs(body.volume() / mesh.volume - 1) > 1e-4:
        wrong.append(f"volumes differ: {body.volume()} and {mesh.volume}")
    return wrong, count, mesh.volume


sound = True
for path in sys.argv[1:]:
    wrong, count, volume = faults(path)
    sound &= not wrong
    print(f"{'; '.join(wrong) or 'sound'}: {path}, {count} triangles, {volume:.6g} mm3")
sys.exit(0 if sound else 1)
