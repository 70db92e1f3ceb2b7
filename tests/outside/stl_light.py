"""Where the triangles of an STL throw light at the first bounce, and how near that is to a drawing. Only Python's own
library, and nothing of the program that it checks.

    python stl_light.py PLATE.stl DRAWING.pgm THETA PHI HALF_FIELD BLUR

Light comes from THETA, PHI (degrees from +z and from +x, counter-clockwise); the image is orthographic around the mirror
direction of the flat plate, HALF_FIELD degrees to its rim; BLUR is the standard deviation in degrees of the Gaussian through
which the two are compared. DRAWING is binary greyscale, sRGB, square; its brightness is radiance. Prints a JSON object:
tv_incident, half the sum of differences where light that is lost counts as missing; efficiency_in_image, the share of the
light inside the image. No triangle shades another here, and nothing bounces twice: for reliefs that are too flat for that.
"""

import json
import math
import struct
import sys


def triangles(path):
    """Corners of every triangle of a binary STL."""
    data = open(path, "rb").read()
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count, "not a binary STL"
    for numbers in struct.iter_unpack("<12fH", memoryview(data)[84:]):
        yield numbers[3:6], numbers[6:9], numbers[9:12]


def drawn(path):
    """Brightness of every pixel of a binary PGM, linear, and the pixels along a side."""
    magic, width, height, most, pixels = open(path, "rb").read().split(maxsplit=4)
    side = int(width)
    assert magic == b"P5" and side == int(height) == int(len(pixels) / side) and most == b"255"
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in (byte / 255 for byte in range(256))]
    return [linear[byte] for byte in pixels], side


def thrown(path, light, half_field, side):
    """Light in every pixel, row 0 on top, as shares of all that falls on the relief."""
    lx, ly, lz = light
    image = [0.0] * (side * side)
    incident = 0.0
    sine = math.sin(math.radians(half_field))
    for a, b, c in triangles(path):
        ux, uy, uz = (b[k] - a[k] for k in range(3))
        vx, vy, vz = (c[k] - a[k] for k in range(3))
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        twice_area = math.sqrt(nx * nx + ny * ny + nz * nz)
        # Walls and the underside are not relief.
        if nz <= 1e-3 * twice_area:
            continue
        nx, ny, nz = nx / twice_area, ny / twice_area, nz / twice_area
        cosine = nx * lx + ny * ly + nz * lz
        if cosine <= 0.0:
            continue
        flux = twice_area * cosine
        incident += flux
        ox, oy, oz = 2 * cosine * nx - lx, 2 * cosine * ny - ly, 2 * cosine * nz - lz
        # The flat plate's mirror direction is (-lx, -ly, lz).
        u, v = (ox + lx) / sine, (oy + ly) / sine
        if oz > 0.0 and abs(u) < 1.0 and abs(v) < 1.0:
            # Shared among the four nearest pixel centres, so that the place within a pixel is not lost.
            x, y = (u + 1) / 2 * side - 0.5, (1 - v) / 2 * side - 0.5
            column, row = math.floor(x), math.floor(y)
            for i, j, share in (
                (0, 0, (column + 1 - x) * (row + 1 - y)), (1, 0, (x - column) * (row + 1 - y)),
                (0, 1, (column + 1 - x) * (y - row)), (1, 1, (x - column) * (y - row)),
            ):
                at = min(max(row + j, 0), side - 1) * side + min(max(column + i, 0), side - 1)
                image[at] += share * flux
    return [flux / incident for flux in image]


def blurred(image, side, deviation):
    """Through a Gaussian of so many pixels; black lies around the image."""
    reach = math.ceil(4 * deviation)
    kernel = [math.exp(-0.5 * (k / deviation) ** 2) for k in range(-reach, reach + 1)]
    whole = sum(kernel)
    for _ in range(2):
        # Rows, then turned so that columns are rows.
        out = [0.0] * (side * side)
        for row in range(side):
            line = [0.0] * reach + image[row * side:(row + 1) * side] + [0.0] * reach
            for column in range(side):
                pieces = line[column:column + 2 * reach + 1]
                out[column * side + row] = sum(k * v for k, v in zip(kernel, pieces)) / whole
        image = out
    return image


def main():
    plate, drawing = sys.argv[1:3]
    theta, phi, half_field, blur = map(float, sys.argv[3:7])
    brightness, side = drawn(drawing)
    theta, phi = math.radians(theta), math.radians(phi)
    light = math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)
    got = thrown(plate, light, half_field, side)
    # Flux is radiance times cos(theta_o) times solid angle, and a pixel of sines covers a solid angle of its area over
    # cos(theta_o): what is drawn is flux already.
    whole = sum(brightness)
    wanted = [value / whole for value in brightness]
    # At the middle of the image an angle of a radian is cos(theta) of a step in sines.
    pixels = math.radians(blur) * math.cos(theta) / math.sin(math.radians(half_field)) * side / 2
    pairs = zip(blurred(got, side, pixels), blurred(wanted, side, pixels))
    print(json.dumps({
        "tv_incident": 0.5 * (sum(abs(a - b) for a, b in pairs) + 1.0 - sum(got)),
        "efficiency_in_image": sum(got),
    }))


main()
