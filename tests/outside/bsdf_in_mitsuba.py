"""Has Mitsuba 3 judge .bsdf files of GGX against its own rough conductor and the closed form, prints JSON.

    python bsdf_in_mitsuba.py FILE ALPHA_U ALPHA_V [PICTURE.png]

Three comparisons, each where the lobe is above 1 % of its peak: eval() against the closed form over pairs of directions;
a sphere under a distant lamp, pixel by pixel, against `roughconductor`; light gathered by sample() against the latter.
What Mitsuba warns of meanwhile is counted. With `-` in place of the roughness the file is of no closed form: then it is
only rendered, its negative and undefined values are counted, and so are the warnings. Exit 3 if a package is missing.
"""

import json
import sys

sys.dont_write_bytecode = True
from mitsuba_here import ready

mi = ready("llvm_ad_rgb")
try:
    import drjit as dr
    import numpy as np
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)



class Warnings(mi.Appender):
    """Counts what Mitsuba warns of, in place of printing it."""

    count = 0

    def append(self, level, text):
        if level >= mi.LogLevel.Warn:
            Warnings.count += 1

    def log_progress(self, progress, name, formatted, eta, ptr):
        pass


logger = mi.logger()
logger.clear_appenders()
counter = Warnings()
logger.add_appender(counter)

path = sys.argv[1]
known = sys.argv[2] != "-"
au, av = (float(sys.argv[2]), float(sys.argv[3])) if known else (1.0, 1.0)
measured = {"type": "measured", "filename": path}
metal = {"type": "roughconductor", "distribution": "ggx", "material": "none", "alpha_u": au, "alpha_v": av}


def direction(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def closed_form(wi, wo):
    """f cosθo of GGX with separable Smith shadowing."""
    m = wi + wo
    m /= np.linalg.norm(m, axis=-1, keepdims=True)
    d = 1 / (np.pi * au * av * ((m[..., 0] / au) ** 2 + (m[..., 1] / av) ** 2 + m[..., 2] ** 2) ** 2)
    g = 1
    for w in (wi, wo):
        g = g * 2 / (1 + np.sqrt(1 + ((au * w[..., 0]) ** 2 + (av * w[..., 1]) ** 2) / w[..., 2] ** 2))
    return d * g / (4 * wi[..., 2])


def pairs(bsdf):
    """Random half vectors about the normal for random light: mean, 99th percentile of the relative error."""
    rng = np.random.default_rng(1)
    n = 200_000
    wi = direction(np.radians(rng.uniform(0, 80, n)), rng.uniform(-np.pi, np.pi, n))
    tilt = np.arctan(max(au, av) * 4 * np.sqrt(rng.uniform(0, 1, n)))
    m = direction(tilt, rng.uniform(-np.pi, np.pi, n))
    wo = 2 * (wi * m).sum(-1, keepdims=True) * m - wi
    keep = (wo[:, 2] > np.cos(np.radians(85))) & ((wi * m).sum(-1) > 0)
    wi, wo = wi[keep], wo[keep]
    wanted = closed_form(wi, wo)
    # The peak over all viewers, for each lamp: the mirror direction is near enough.
    peak = closed_form(wi, wi * np.array([-1, -1, 1]))
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = mi.Vector3f(*wi.T)
    got = np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*wo.T)))[0]
    error = np.abs(got / wanted - 1)[wanted > 0.01 * peak]
    return {"pairs": len(error), "mean": error.mean(), "p99": np.percentile(error, 99), "worst": error.max()}


def sphere(bsdf, light):
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
        "sensor": {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at([0, -4, 1.5], [0, 0, 0], [0, 0, 1]) @ mi.ScalarTransform4f().scale(1.05),
            "film": {"type": "hdrfilm", "width": 256, "height": 256, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
        },
        "lamp": {"type": "directional", "direction": light, "irradiance": {"type": "rgb", "value": 1}},
        "ball": {"type": "sphere", "bsdf": bsdf},
    })
    return np.array(mi.render(scene, spp=16, seed=3))


def spheres():
    """Worst over three lamps of the mean relative error."""
    worst, pictures = {"mean": 0.0}, []
    for light in ([0, 1, -0.3], [1, 0.3, -0.5], [0.7, -0.6, -0.2]):
        wanted, got = sphere(metal, light)[..., 1], sphere(measured, light)[..., 1]
        lit = wanted > 0.01 * wanted.max()
        error = np.abs(got / np.maximum(wanted, 1e-30) - 1)[lit]
        pictures.append(np.concatenate([wanted, got, np.abs(got - wanted) * 10], 1) / wanted.max())
        if error.mean() > worst["mean"]:
            worst = {"mean": error.mean(), "p99": np.percentile(error, 99), "pixels": int(lit.sum())}
    if len(sys.argv) > 4:
        mi.Bitmap(np.concatenate(pictures, 0)[..., None].repeat(3, -1).astype(np.float32)).convert(
            mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, True).write(sys.argv[4])
    return worst


def gathered(bsdfs):
    """Light that sample() brings in from two skies, a white one and one that varies: worst relative difference."""
    worst, n = 0.0, 400_000
    for theta in (5, 35, 65):
        for phi in (20, 130, -100):
            si = dr.zeros(mi.SurfaceInteraction3f, n)
            wi = direction(np.radians(theta), np.radians(phi))
            si.wi = mi.Vector3f(*[mi.Float(float(c)) for c in wi])
            sums = []
            for bsdf in bsdfs:
                sampler = mi.load_dict({"type": "independent"})
                sampler.seed(7, n)
                sample, weight = bsdf.sample(mi.BSDFContext(), si, sampler.next_1d(), sampler.next_2d())
                weight, wo = np.array(weight)[1], np.array(sample.wo)
                sums.append([weight.mean(), (weight * (1 + wo[0])).mean()])
            worst = max(worst, float(np.abs(np.array(sums[1]) / np.array(sums[0]) - 1).max()))
    return worst


def rendered_alone():
    """Balls that wear the file under three lamps: values that no picture may have, and how many are lit at all."""
    odd, lit = 0, 0
    for light in ([0, 1, -0.3], [1, 0.3, -0.5], [0.7, -0.6, -0.2]):
        picture = sphere(measured, light)
        odd += int((~np.isfinite(picture) | (picture < 0)).sum())
        lit += int((picture[..., 1] > 0.01 * picture.max()).sum())
    return {"odd": odd, "lit": lit}


loaded = mi.load_dict(measured)
if known:
    report = {"eval": pairs(loaded), "sphere": spheres(), "gathered": gathered([mi.load_dict(metal), loaded])}
else:
    report = {"alone": rendered_alone()}
report["warnings"] = Warnings.count
print(json.dumps(report, default=float))
