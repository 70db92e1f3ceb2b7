"""The surface that a machine leaves of a program: its control rounds corners, its drives go in whole steps and cannot follow
them at once, and a ball sweeps what they do. Nothing of ours: no samples of a drive, no tree, no closed form of a sweep.

    machined_in_python.py MOVES PLACES JSON

MOVES holds lines as `moves_of_linuxcnc.py` prints them, PLACES a place a line, x and y in mm as the program counts. JSON is
an object, lengths in mm: "radius" of the ball; "step" of the drives; "smoothing", the standard deviation of the Gaussian
that drives lag by along the way; "ends", whether the control takes ends of moves to whole steps before it goes there, as
GRBL's lround does; "blending", P of LinuxCNC's G64, or 0; "zero", where the program's zero stands as drives count.

Prints for each place height, slope along x and slope along y of the least underside of the ball over all passes, heights as
drives count. Passes are runs of cuts along x; a plunge is none. Exit code 3: NumPy is not installed.
"""
import json
import math
import sys

try:
    import numpy as np
except ImportError as why:
    print(f"NumPy: {why}")
    sys.exit(3)

# From one place along a pass at which the tip's height is reckoned to the next, mm.
FINE = 0.002
# Of a smoothed step nothing is left farther away than so many standard deviations.
DEVIATIONS = 6.0


def passes(path):
    """Runs of cuts that go along x, as arrays of ends."""
    found, at, run = [], None, []
    for line in open(path):
        kind, *numbers = line.split()
        to = np.array([float(number) for number in numbers[:3]])
        level = at is not None and np.hypot(*(to - at)[:2]) > 1e-9
        if kind == "L" and level:
            run = run or [at]
            run.append(to)
        elif run:
            found.append(np.array(run))
            run = []
        at = to
    if run:
        found.append(np.array(run))
    return found


def blended(ends, tolerance):
    """With a parabola in place of every corner: it leaves the way and joins it again as far from the corner as it may, half
    of the shorter move, or where its middle passes the corner by the tolerance."""
    way = np.diff(ends, axis=0)
    length = np.linalg.norm(way, axis=1)
    along = way / length[:, None]
    turn = np.linalg.norm(np.diff(along, axis=0), axis=1)
    # Half way along the parabola is a quarter of |turn| times its legs' length from the corner.
    legs = np.minimum(0.5 * np.minimum(length[:-1], length[1:]), 4.0 * tolerance / np.maximum(turn, 1e-12))[:, None]
    corner = ends[1:-1]
    before, after = corner - legs * along[:-1], corner + legs * along[1:]
    shares = np.linspace(0.0, 1.0, 9)[None, :, None]
    curve = (1 - shares) ** 2 * before[:, None] + 2 * shares * (1 - shares) * corner[:, None] + shares**2 * after[:, None]
    return np.concatenate([ends[:1], curve.reshape(-1, 3), ends[-1:]])


def whole(values, step):
    """The nearest whole steps, halves away from zero."""
    return np.sign(values) * np.floor(np.abs(values) / step + 0.5) * step


def normal_law():
    """The share of a Gaussian below a number of deviations."""
    at = np.linspace(-DEVIATIONS, DEVIATIONS, 6001)
    return at, np.array([0.5 * math.erfc(-t / math.sqrt(2.0)) for t in at])


def steps_taken(ends, step):
    """Where along x a drive that is led along `ends` steps up (+1) or down (-1), and how high it stands before, in steps."""
    x, z = ends[:, 0], ends[:, 2] / step
    # A step is taken half way to it.
    level = np.floor(z + 0.5).astype(int)
    places, signs = [], []
    for k in np.nonzero(np.diff(level))[0]:
        up = level[k + 1] > level[k]
        crossed = np.arange(level[k], level[k + 1]) + 0.5 if up else np.arange(level[k], level[k + 1], -1) - 0.5
        places.append(x[k] + (x[k + 1] - x[k]) * (crossed - z[k]) / (z[k + 1] - z[k]))
        signs.append(np.full(len(crossed), 1.0 if up else -1.0))
    if not places:
        return np.empty(0), np.empty(0), level[0]
    return np.concatenate(places), np.concatenate(signs), level[0]


def heights(ends, machine, law, x):
    """Heights of the tip at places `x` along a pass, as a drive leads it that lags behind its own steps."""
    step, smoothing = machine["step"], machine["smoothing"]
    places, signs, level = steps_taken(ends, step)
    wide = int(DEVIATIONS * smoothing / FINE) + 1
    # Each step is taken by a share that grows as the Gaussian's law says, and is there in all beyond.
    nearest = np.rint((places - x[0]) / FINE).astype(int)
    at = nearest[:, None] + np.arange(-wide, wide + 1)
    share = signs[:, None] * np.interp((x[0] + at * FINE - places[:, None]) / max(smoothing, 1e-9), *law)
    inside = (at >= 0) & (at < len(x))
    rising = np.bincount(at[inside], share[inside], minlength=len(x))
    there = np.bincount(np.clip(nearest + wide + 1, 0, len(x)), signs, minlength=len(x) + 1)
    return step * (level + rising + np.cumsum(there)[: len(x)])


def least(place, within, tracks, radius):
    """The least underside over a place of balls whose axes are `within` some distance, and from that ball's axis to the place."""
    ys, x, z = tracks
    low, high = np.searchsorted(ys, [place[1] - within, place[1] + within])
    first, last = np.searchsorted(x, [place[0] - within, place[0] + within])
    aside, across = place[0] - x[first:last], place[1] - ys[low:high, None]
    under = radius**2 - aside**2 - across**2
    height = np.where(under >= 0.0, z[low:high, first:last] - np.sqrt(np.maximum(under, 0.0)), np.inf)
    j, i = np.unravel_index(np.argmin(height), height.shape)
    found, along = height[j, i], aside[i]
    if 0 < i < len(aside) - 1:
        # Between the places that were reckoned: the parabola through three of them.
        before, here, after = height[j, i - 1 : i + 2]
        bend = before - 2 * here + after
        if 0.0 < bend < math.inf:
            shift = 0.5 * (before - after) / bend
            found, along = here - 0.25 * (before - after) * shift, along - shift * FINE
    return found + radius, along, across[j, 0]


def main():
    machine = json.loads(sys.argv[3])
    places = np.loadtxt(sys.argv[2], ndmin=2)
    zero, radius, law = np.array(machine["zero"]), machine["radius"], normal_law()
    found = []
    for ends in passes(sys.argv[1]):
        ends = ends + zero
        if machine["ends"]:
            ends = whole(ends, machine["step"])
        found.append(blended(ends, machine["blending"]) if machine["blending"] > 0.0 else ends)
        assert np.ptp(ends[:, 1]) < 1e-9, "a pass that does not go along x"
    found.sort(key=lambda ends: ends[0, 1])
    low, high = (limit(limit(ends[:, 0]) for ends in found) for limit in (min, max))
    x = np.arange(math.floor(low / FINE), math.ceil(high / FINE) + 1) * FINE
    tracks = np.array([ends[0, 1] for ends in found]), x, np.array([heights(ends, machine, law, x) for ends in found])
    for place in places + zero[:2]:
        # Slopes of a third touch within that; what touches near the rim of the search is searched for under all of the ball.
        within = 0.35 * radius
        height, along, across = least(place, within, tracks, radius)
        if math.hypot(along, across) > 0.9 * within:
            height, along, across = least(place, radius, tracks, radius)
        rise = 1.0 / math.sqrt(radius**2 - along**2 - across**2)
        print(f"{height:.9f} {along * rise:.9f} {across * rise:.9f}")


main()
