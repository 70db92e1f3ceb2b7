"""The surface that a ball leaves along a program, by a search of its own: no closed form, no tree, nothing of ours.

    sweep_in_python.py MOVES PLACES RADIUS

MOVES holds lines as `moves_of_linuxcnc.py` prints them, PLACES a place a line, x and y in mm. Prints for each place the
least height of the ball's underside over all cuts that pass within its radius, mm. Exit code 3: NumPy is not installed.
"""
import sys

try:
    import numpy as np
except ImportError as why:
    print(f"NumPy: {why}")
    sys.exit(3)

GOLDEN = (5**0.5 - 1) / 2


def cuts(path):
    """From and to of every cut."""
    at, found = np.full(3, np.nan), []
    for line in open(path):
        kind, *numbers = line.split()
        to = np.array([float(number) for number in numbers[:3]])
        if kind == "L":
            found.append((at, to))
        at = to
    return np.array([pair for pair in found if np.isfinite(pair).all()])


def main():
    moves, places, radius = cuts(sys.argv[1]), np.loadtxt(sys.argv[2], ndmin=2), float(sys.argv[3])
    start, way = moves[:, 0], moves[:, 1] - moves[:, 0]
    low = np.minimum(start, moves[:, 1])[:, :2] - radius
    high = np.maximum(start, moves[:, 1])[:, :2] + radius
    for place in places:
        near = np.all((place >= low) & (place <= high), axis=1)
        begin, along = start[near], way[near]

        def underside(share):
            aside = np.hypot(*(begin[:, :2] + share[:, None] * along[:, :2] - place).T)
            sphere = radius - np.sqrt(np.maximum(radius**2 - aside**2, 0.0))
            # Beyond its radius a ball leaves nothing: far above, and rising, so that the search goes inward.
            return begin[:, 2] + share * along[:, 2] + np.where(aside <= radius, sphere, 1e3 + aside)

        left, right = np.zeros(len(begin)), np.ones(len(begin))
        # A convex function of the share: its least value by golden section.
        for _ in range(60):
            a, b = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
            lower = underside(a) < underside(b)
            left, right = np.where(lower, left, a), np.where(lower, b, right)
        least = [underside(share) for share in (left, right, np.zeros(len(begin)), np.ones(len(begin)))]
        print(f"{min(values.min() for values in least):.9f}")


main()
