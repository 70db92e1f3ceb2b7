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
from mitsuba_here import ready

mi = ready("llvm_ad_mono")
try:
    import numpy as np
    from PIL import Image
    from scipy.ndimage import gaussian_filter
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)

folder, image, blur, flip, particles = sys.argv[1:]
scene = mi.load_file(os.path.join(folder, "scene.xml"))
rendered = np.array(mi.render(scene, spp=int(particles), seed=7)).astype(float)[:, :, 0]
measured = np.asarray(Image.open(image)).astype(float)
if flip == "1":
    measured = measured[:, ::-1]
seen = [gaussian_filter(light / light.sum(), float(blur), mode="constant") for light in (rendered, measured)]
print(json.dumps({"tv": 0.5 * np.abs(seen[0] - seen[1]).sum(), "light": rendered.sum() / rendered.size}))
