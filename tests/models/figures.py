"""Values of every model at 20 pairs of directions, from the papers' formulas as they stand, for the test that reads figures.txt.

    python3 tests/models/figures.py > tests/models/figures.txt

Shares no code with the program. Smith's shadowing is integrated here by brute force over normals; GGX is Mitsuba's
`roughconductor` where Mitsuba 3 can be imported (the lines that are there were made with it), else by its closed form.
"""
import math
import random

import numpy as np


def direction(theta, phi):
    t, p = math.radians(theta), math.radians(phi)
    return np.array([math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)])


def half(wi, wo):
    h = wi + wo
    return h / np.linalg.norm(h)


def turned(v, degrees):
    a = -math.radians(degrees)
    return np.array([math.cos(a) * v[0] - math.sin(a) * v[1], math.sin(a) * v[0] + math.cos(a) * v[1], v[2]])


def beckmann_d(h, ax, ay):
    e = ((h[0] / ax) ** 2 + (h[1] / ay) ** 2) / h[2] ** 2
    return math.exp(-e) / (math.pi * ax * ay * h[2] ** 4)


def beckmann_g1(v, ax, ay):
    wide = math.hypot(ax * v[0], ay * v[1])
    if wide == 0:
        return 1.0
    a = v[2] / wide
    return 2 / (1 + math.erf(a) + math.exp(-a * a) / (a * math.sqrt(math.pi)))


def grooves(wi, wo, h):
    return min(1, 2 * h[2] * wo[2] / wo.dot(h), 2 * h[2] * wi[2] / wo.dot(h))


# Directions of normals for brute force: midpoints of tilts (even in the square root) and azimuths.
N, M = 3000, 720
edges = (np.pi / 2) * (np.arange(N + 1) / N) ** 2
tilts = (np.pi / 2) * ((np.arange(N) + 0.5) / N) ** 2
widths = edges[1:] - edges[:-1]
azimuths = (np.arange(M) + 0.5) / M * 2 * np.pi


class Isotropic:
    """A density of tilts, normalised over projected area, and Smith's G1 of it."""

    def __init__(self, shape):
        self.shape = shape
        self.rings = shape(tilts) * np.sin(tilts) * widths * 2 * np.pi
        self.norm = np.sum(self.rings * np.cos(tilts))

    def d(self, h):
        return float(self.shape(np.arccos(np.clip(h[2], -1, 1)))) / self.norm

    def g1(self, v):
        theta = math.acos(v[2])
        seen = np.cos(tilts)[:, None] * math.cos(theta) + (np.sin(tilts) * math.sin(theta))[:, None] * np.cos(azimuths)
        area = np.sum(self.rings * np.maximum(seen, 0).mean(axis=1)) / self.norm
        return min(1.0, v[2] / area)

    def smith(self, wi, wo):
        return self.d(half(wi, wo)) * self.g1(wi) * self.g1(wo) / (4 * wi[2] * wo[2])


def oren_nayar(wi, wo, rho, degrees, qualitative):
    s2 = math.radians(degrees) ** 2
    ti, to = math.acos(wi[2]), math.acos(wo[2])
    cosine = math.cos(math.atan2(wi[1], wi[0]) - math.atan2(wo[1], wo[0]))
    a, b = max(ti, to), min(ti, to)
    c1 = 1 - 0.5 * s2 / (s2 + 0.33)
    if qualitative:
        return rho / math.pi * (c1 + 0.45 * s2 / (s2 + 0.09) * max(0, cosine) * math.sin(a) * math.tan(b))
    c2 = 0.45 * s2 / (s2 + 0.09) * (math.sin(a) - (0 if cosine >= 0 else (2 * b / math.pi) ** 3))
    c3 = 0.125 * s2 / (s2 + 0.09) * (4 * a * b / math.pi**2) ** 2
    l1 = rho / math.pi * (c1 + cosine * c2 * math.tan(b) + (1 - abs(cosine)) * c3 * math.tan((a + b) / 2))
    return l1 + 0.17 * rho**2 / math.pi * s2 / (s2 + 0.13) * (1 - cosine * (2 * b / math.pi) ** 2)


def ward(wi, wo, ax, ay):
    h = half(wi, wo)
    e = ((h[0] / ax) ** 2 + (h[1] / ay) ** 2) / h[2] ** 2
    return math.exp(-e) / (4 * math.pi * ax * ay * math.sqrt(wi[2] * wo[2]))


def ward_bounded(wi, wo, ax, ay):
    # As printed, with the half vector not normalised.
    h = wi + wo
    e = ((h[0] / ax) ** 2 + (h[1] / ay) ** 2) / h[2] ** 2
    return math.exp(-e) * h.dot(h) / (math.pi * ax * ay * h[2] ** 4)


def ashikhmin_shirley(wi, wo, nu, nv, rs, rd):
    h = half(wi, wo)
    k = wi.dot(h)
    power = (nu * h[0] ** 2 + nv * h[1] ** 2) / (1 - h[2] ** 2)
    f = rs + (1 - rs) * (1 - k) ** 5
    s = math.sqrt((nu + 1) * (nv + 1)) / (8 * math.pi) * h[2] ** power / (k * max(wi[2], wo[2])) * f
    return s + 28 * rd / (23 * math.pi) * (1 - rs) * (1 - (1 - wi[2] / 2) ** 5) * (1 - (1 - wo[2] / 2) ** 5)


def ggx(ax, ay):
    try:
        import mitsuba as mi

        mi.set_variant("scalar_rgb")
        bsdf = mi.load_dict(
            {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha_u": ax, "alpha_v": ay}
        )

        def value(wi, wo):
            si = mi.SurfaceInteraction3f()
            si.wi = mi.Vector3f(wi.tolist())
            return float(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wo.tolist()))[0]) / wo[2]

    except ImportError:

        def value(wi, wo):
            h = half(wi, wo)
            d = 1 / (math.pi * ax * ay * ((h[0] / ax) ** 2 + (h[1] / ay) ** 2 + h[2] ** 2) ** 2)

            def g1(v):
                return 2 / (1 + math.sqrt(1 + ((ax * v[0]) ** 2 + (ay * v[1]) ** 2) / v[2] ** 2))

            return d * g1(wi) * g1(wo) / (4 * wi[2] * wo[2])

    return value


def lafortune(wi, wo, *lobes):
    return sum(max(0, cx * wi[0] * wo[0] + cy * wi[1] * wo[1] + cz * wi[2] * wo[2]) ** n for cx, cy, cz, n in lobes)


def cook_torrance(wi, wo, m):
    h = half(wi, wo)
    return beckmann_d(h, m, m) * grooves(wi, wo, h) / (4 * wi[2] * wo[2])


def torrance_sparrow(wi, wo, normals):
    h = half(wi, wo)
    return normals.d(h) * grooves(wi, wo, h) / (4 * wi[2] * wo[2])


def beckmann(wi, wo, ax, ay, turn):
    wi, wo = turned(wi, turn), turned(wo, turn)
    smith = beckmann_g1(wi, ax, ay) * beckmann_g1(wo, ax, ay)
    return beckmann_d(half(wi, wo), ax, ay) * smith / (4 * wi[2] * wo[2])


def shifted_gamma(alpha, p):
    x = lambda t: np.tan(t) ** 2
    return lambda t: np.exp(-(alpha**2 + x(t)) / alpha) / (alpha**2 + x(t)) ** p / np.cos(t) ** 4


power40 = Isotropic(lambda t: np.cos(t) ** 40)
gauss = Isotropic(lambda t: np.exp(-((t / 0.3) ** 2)))
steel = Isotropic(shifted_gamma(0.195704, 0.706913))
MODELS = {
    "lambert:0.5": lambda i, o: 0.5 / math.pi,
    "oren-nayar:0.6,30": lambda i, o: oren_nayar(i, o, 0.6, 30, False),
    "oren-nayar-qualitative:0.6,30": lambda i, o: oren_nayar(i, o, 0.6, 30, True),
    "phong:20": lambda i, o: 22 / (2 * math.pi) * max(0, o.dot([-i[0], -i[1], i[2]])) ** 20,
    "blinn-phong:40": power40.smith,
    "gaussian:0.3": lambda i, o: torrance_sparrow(i, o, gauss),
    "beckmann:0.2,0.4,25": lambda i, o: beckmann(i, o, 0.2, 0.4, 25),
    "cook-torrance:0.3": lambda i, o: cook_torrance(i, o, 0.3),
    "ggx:0.2,0.4": ggx(0.2, 0.4),
    "shifted-gamma:0.195704,0.706913": steel.smith,
    "ward:0.1,0.3": lambda i, o: ward(i, o, 0.1, 0.3),
    "ward-bounded:0.1,0.3": lambda i, o: ward_bounded(i, o, 0.1, 0.3),
    "ashikhmin-shirley:20,80,0.3,0.5": lambda i, o: ashikhmin_shirley(i, o, 20, 80, 0.3, 0.5),
    "lafortune:-0.9,-0.9,1,12/-0.4,-0.3,0.5,3": lambda i, o: lafortune(
        i, o, (-0.9, -0.9, 1, 12), (-0.4, -0.3, 0.5, 3)
    ),
}

rng = random.Random(17)
# Viewers around the mirrored light, where lobes are, and some anywhere.
pairs = []
for k in range(20):
    theta, phi = rng.uniform(2, 75), rng.uniform(-180, 180)
    if k % 4:
        pairs.append((theta, phi, min(80, abs(theta + rng.uniform(-20, 20))), phi + 180 + rng.uniform(-25, 25)))
    else:
        pairs.append((theta, phi, rng.uniform(1, 80), rng.uniform(-180, 180)))
print("# theta_i phi_i theta_o phi_o value, degrees and 1/sr; made by figures.py")
for name, value in MODELS.items():
    print(name)
    for a, b, c, d in pairs:
        print(f"{a:.6f} {b:.6f} {c:.6f} {d:.6f} {value(direction(round(a, 6), round(b, 6)), direction(round(c, 6), round(d, 6))):.9e}")
