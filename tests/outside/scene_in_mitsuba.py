"""Renders a design's scene.xml with Mitsuba 3 as it is, and compares it with an image that the program measured.

    python scene_in_mitsuba.py DIR IMAGE.tiff BLUR_PIXELS FLIP PARTICLES

BLUR_PIXELS is a standard deviation; FLIP is 1 where the scene is seen from the plate's side and the image from above it;
PARTICLES are for each pixel. Prints the share of light that lies elsewhere and the sum of the scene's light, as JSON. Exit
3 if a package is missing.
"""

import json
import os
import sys

sys.dont_write_bytecode = True
home = os.environ.get("REFEREE_HOME", os.path.expanduser("~/.cache/facetmill-referee"))
llvm = os.path.join(home, "llvm/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1")
if os.path.exists(llvm):
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", llvm)
try:
    import mitsuba as mi
    import numpy as np
    from PIL import Image
    from scipy.ndimage import gaussian_filter
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)
try:
    mi.set_variant("llvm_ad_mono")
    mi.Float(1) + 1
except Exception as why:
    print(f"missing: a usable LLVM ({why})")
    sys.exit(3)

folder, image, blur, flip, particles = sys.argv[1:]
scene = mi.load_file(os.path.join(folder, "scene.xml"))
rendered = np.array(mi.render(scene, spp=int(particles), seed=7)).astype(float)[:, :, 0]
measured = np.asarray(Image.open(image)).astype(float)
if flip == "1":
    measured = measured[:, ::-1]
seen = [gaussian_filter(light / light.sum(), float(blur), mode="constant") for light in (rendered, measured)]
print(json.dumps({"tv": 0.5 * np.abs(seen[0] - seen[1]).sum(), "light": rendered.sum() / rendered.size}))
