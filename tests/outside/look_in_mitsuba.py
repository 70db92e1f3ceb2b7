"""A plate as Mitsuba 3's own path tracer sees it: means and variances of every pixel.

    python look_in_mitsuba.py SCENE.json OUT.json

The scene names an STL file (or the radius of a ball, as a globe with its pole at +y), the metal's eta and k, roughness
and distribution (or a .bsdf file), camera (eye, target, up, width of the field in degrees), the way light goes, pixels, bounces, passes and
paths a pixel in each. Exit 3 if a package is missing.
"""

import json
import sys

sys.dont_write_bytecode = True
from mitsuba_here import ready

scene_file, out_file = sys.argv[1:]
wanted = json.load(open(scene_file))
# A .bsdf file holds red, green and blue; here all the same.
mi = ready("llvm_ad_rgb" if "bsdf" in wanted else "llvm_ad_mono")
try:
    import numpy as np
    import trimesh
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)

if "bsdf" in wanted:
    material = {"type": "measured", "filename": wanted["bsdf"]}
else:
    material = {
        "type": "roughconductor", "distribution": wanted.get("distribution", "ggx"),
        "alpha_u": wanted["alpha"][0], "alpha_v": wanted["alpha"][1],
        "eta": {"type": "spectrum", "value": wanted["eta"]}, "k": {"type": "spectrum", "value": wanted["k"]},
        "specular_reflectance": {"type": "spectrum", "value": 1.0},
    }
shift = np.array(wanted["target"])
if "ball" in wanted:
    upright = mi.ScalarTransform4f().rotate([1, 0, 0], -90)
    plate = {"type": "sphere", "radius": wanted["ball"], "to_world": upright, "bsdf": material}
else:
    solid = trimesh.load(wanted["stl"], process=False, force="mesh")
    # Around the origin single precision is finest; the triangles stay as they are, each with its own normal.
    corners = (solid.vertices - shift)[solid.faces].reshape(-1, 3).astype(np.float32)
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(material)
    plate = mi.Mesh("plate", len(corners), len(corners) // 3, has_vertex_normals=False, props=properties)
    parameters = mi.traverse(plate)
    parameters["vertex_positions"] = mi.Float(corners.ravel())
    parameters["faces"] = mi.UInt32(np.arange(len(corners), dtype=np.uint32))
    parameters.update()

width, height = wanted["size"]
scene = mi.load_dict({
    "type": "scene",
    "integrator": {"type": "path", "max_depth": wanted["bounces"] + 1, "rr_depth": 1000},
    "sensor": {
        "type": "perspective",
        "fov": wanted["field_of_view"], "fov_axis": "larger",
        "near_clip": 1.0, "far_clip": 1e5,
        "to_world": mi.ScalarTransform4f().look_at(
            origin=list(np.array(wanted["eye"]) - shift), target=[0, 0, 0], up=wanted["up"]
        ),
        "film": {
            "type": "hdrfilm", "width": width, "height": height, "pixel_format": "luminance",
            "component_format": "float32", "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent"},
    },
    "plate": plate,
    "lamp": {
        "type": "directional", "direction": wanted["light_goes"],
        "irradiance": {"type": "rgb" if "bsdf" in wanted else "spectrum", "value": 1.0},
    },
})
total = np.zeros((height, width))
squares = np.zeros((height, width))
passes = wanted["passes"]
for seed in range(passes):
    image = np.array(mi.render(scene, spp=wanted["paths"], seed=1000 + seed)).astype(np.float64).reshape(height, width)
    total += image
    squares += image * image
mean = total / passes
variance = (squares / passes - mean * mean).clip(0) / (passes - 1)
json.dump({"mean": mean.ravel().tolist(), "variance": variance.ravel().tolist()}, open(out_file, "w"))
