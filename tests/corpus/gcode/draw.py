"""Draws programs in the manner of common CAM programs, and the moves that they mean.

Each program NAME.ngc has a NAME.moves: a line for each move with its kind (R rapid, L line, A arc), its end and, for an
arc, the point half-way, in mm. The moves come from what was drawn, not from reading the program: this script holds no
interpreter. Run it in this folder: it writes the same files every time.
"""
import math
import random

IN = 25.4


class Post:
    """Writes moves in the words of one program."""

    def __init__(self, unit=1.0, digits=4, numbers=0, join=" ", lower=False, steps=False, end="\n", modal=True, letters="IJK"):
        self.unit, self.digits, self.number, self.step, self.join = unit, digits, numbers, numbers, join
        self.lower, self.steps, self.end, self.modal = lower, steps, end, modal
        self.lines, self.moves, self.at, self.mode = [], [], [0.0, 0.0, 0.0], None
        self.centre_absolute = False

    def say(self, text, plain=False):
        if self.step and not plain:
            text = f"N{self.number}{self.join}{text}"
            self.number += self.step
        self.lines.append(text.lower() if self.lower else text)

    def num(self, value):
        text = f"{value:.{self.digits}f}"
        return text.rstrip("0") if "." in text else text

    def snap(self, point):
        """The place that the digits can say."""
        return [round(c / self.unit, self.digits) * self.unit for c in point]

    def words(self, point, names="XYZ", all_axes=False):
        out = []
        for k, name in enumerate("XYZ"):
            if name not in names:
                continue
            value = (point[k] - self.at[k] if self.steps else point[k]) / self.unit
            if all_axes or not self.modal or abs(point[k] - self.at[k]) > 1e-12:
                out.append(name + self.num(value))
        return out

    def go(self, kind, word, x=None, y=None, z=None, extra=()):
        point = self.snap([self.at[k] if v is None else v for k, v in enumerate((x, y, z))])
        words = self.words(point, "".join(n for n, v in zip("XYZ", (x, y, z)) if v is not None))
        if not words:
            return
        head = [] if self.modal and self.mode == word else [word]
        self.mode = word
        self.say(self.join.join(head + words + list(extra)))
        self.at = point
        self.moves.append((kind, *point))

    def rapid(self, x=None, y=None, z=None, word="G0"):
        self.go("R", word, x, y, z)

    def line(self, x=None, y=None, z=None, feed=None, word="G1"):
        self.go("L", word, x, y, z, [] if feed is None else ["F" + self.num(feed)])

    def arc(self, plane, centre, angle, climb=0.0, radius_word=False, word=None):
        """About a centre (in the plane's own axes) by an angle, counter-clockwise seen against its third axis."""
        a, b, c = {"XY": (0, 1, 2), "ZX": (2, 0, 1), "YZ": (1, 2, 0)}[plane]
        # Of the words written: the centre's digits count, so the end is put on the circle that they say.
        offset = [round((centre[k] - self.at[i]) / self.unit, self.digits) * self.unit for k, i in enumerate((a, b))]
        middle = [self.at[a] + offset[0], self.at[b] + offset[1]]
        r, from_angle = math.hypot(*offset), math.atan2(-offset[1], -offset[0])

        def on(t):
            p = [0.0, 0.0, 0.0]
            p[a] = middle[0] + r * math.cos(from_angle + t * angle)
            p[b] = middle[1] + r * math.sin(from_angle + t * angle)
            p[c] = self.at[c] + t * climb
            return p

        whole = abs(abs(angle) - 2 * math.pi) < 1e-9
        end = self.at[:] if whole else self.snap(on(1))
        if whole:
            end[c] = self.snap(on(1))[c]
        half = on(0.5)
        mode = word or ("G3" if angle > 0 else "G2")
        words = [] if self.modal and self.mode == mode else [mode]
        self.mode = mode
        names = "".join("XYZ"[k] for k in (a, b) + ((c,) if climb else ()))
        words += [] if whole and not climb else self.words(end, names, all_axes=True)
        if radius_word:
            words.append("R" + self.num(r / self.unit * (-1 if abs(angle) > math.pi else 1)))
        else:
            base = [0.0, 0.0] if not self.centre_absolute else [self.at[a], self.at[b]]
            pairs = sorted(zip((a, b), offset, base))
            words += ["IJK"[k] + self.num((o + s) / self.unit) for k, o, s in pairs]
        self.say(self.join.join(words))
        self.at = end
        self.moves.append(("A", *end, *half))

    def save(self, name, last_end=True):
        text = self.end.join(self.lines) + (self.end if last_end else "")
        with open(name + ".ngc", "w", newline="", encoding="utf-8") as out:
            out.write(text)
        with open(name + ".moves", "w", encoding="utf-8") as out:
            for move in self.moves:
                out.write(" ".join([move[0]] + [f"{c:.9f}" for c in move[1:]]) + "\n")


def relief(x, y):
    return -0.3 + 0.2 * math.sin(0.9 * x + 0.3) * math.cos(0.7 * y)


def raster(p, feed, rows=4, points=9, zigzag=True, safe=5.0):
    p.rapid(z=safe)
    for row in range(rows):
        xs = [10.0 * k / (points - 1) for k in range(points)]
        if zigzag and row % 2:
            xs.reverse()
        y = 2.5 * row
        if row == 0 or not zigzag:
            p.rapid(xs[0], y)
            p.line(z=relief(xs[0], y), feed=feed / 3)
        for k, x in enumerate(xs):
            p.line(x, y, relief(x, y), feed=feed if k == 0 or (k == 1 and (row == 0 or not zigzag)) else None)
        if not zigzag:
            p.rapid(z=safe)
    p.rapid(z=safe)


def hsm(p, feed, plane="XY"):
    """Ramps, entries and links by arcs, as adaptive strategies post them."""
    p.rapid(z=10.0)
    p.rapid(6.0, 0.0)
    p.line(z=1.0, feed=feed / 4)
    for k in range(3):
        p.arc("XY", (3.0, 0.0), 2 * math.pi, -0.5)
    p.line(6.0, 4.0, feed=feed)
    p.arc("XY", (3.0, 4.0), math.pi)
    p.line(0.0, -1.0)
    p.arc("XY", (1.5, -1.0), 0.5 * math.pi)
    p.arc("XY", (1.5, -4.0), -1.2)
    p.rapid(z=10.0)


def scallops(p, feed, plane):
    """Lines and lifts in an upright plane."""
    axis, other = (0, 1) if plane == "ZX" else (1, 0)
    p.rapid(z=8.0)
    p.rapid(0.0, 0.0)
    p.line(z=1.0, feed=feed)
    for k in range(4):
        turn = 1 if k % 2 == 0 else -1
        if plane == "ZX":
            p.arc("ZX", (p.at[2], p.at[0] + 1.0), turn * math.pi * (0.5 if k > 1 else 1.0))
        else:
            p.arc("YZ", (p.at[1] + 1.0, p.at[2]), turn * math.pi * (0.5 if k > 1 else 1.0))
        step = [p.at[0], p.at[1]]
        step[other] += 0.5
        p.line(step[0], step[1])
    p.rapid(z=8.0)


def fusion(name, unit, digits, arcs):
    p = Post(unit, digits, 5 if arcs else 0, join=" ")
    p.say("%", True)
    p.say("(1001)", True)
    p.say("(Machine)", True)
    p.say("(  vendor: none)", True)
    p.say("(T1 D=1. CR=0.5 - ZMIN=-0.5 - ball end mill)", True)
    p.say("G90 G94 G17 G91.1" if arcs else "G90 G94")
    p.say("G20" if unit == IN else "G21")
    p.say("(Parallel1)", True)
    p.say("T1 M6")
    p.say("S15000 M3")
    p.say("G54")
    p.say("M8")
    p.say("G17")
    feed = 500 / unit
    hsm(p, feed) if arcs else raster(p, feed)
    p.say("M9")
    p.say("M5")
    p.say("M30")
    p.say("%", True)
    p.save(name)


def freecad(name, arcs, unit=1.0):
    p = Post(unit, 3 if unit == 1.0 else 4, modal=False)
    p.say("(Exported by a CAM workbench)")
    p.say("(Post Processor: linuxcnc_post)")
    p.say("(begin preamble)")
    p.say("G17 G54 G40 G49 G80 G90")
    p.say("G20" if unit == IN else "G21")
    p.say("(begin operation: Default Tool)")
    p.say("M5")
    p.say("M6 T1")
    p.say("M3 S12000")
    p.say("(finish operation: Default Tool)")
    hsm(p, 300 / unit) if arcs else raster(p, 300 / unit, zigzag=False)
    p.say("(begin postamble)")
    p.say("M05")
    p.say("G17 G54 G90 G80 G40")
    p.say("M2")
    p.save(name)


def wizard(name, steps, unit=1.0):
    """A pocket by circles, as the wizards of hobby controls write it."""
    p = Post(unit, 4, 10, join="", steps=False, end="\r\n")
    p.say("G%d" % (20 if unit == IN else 21))
    p.say("G40 G80 G17 G90")
    p.say("M6T1(TOOL DIA. 3.)")
    p.say("M03S8000")
    p.rapid(z=6.35, word="G00")
    p.rapid(10.0, 10.0, word="G00")
    p.line(z=-1.0, feed=150 / unit, word="G01")
    if steps:
        p.say("G91")
        p.steps = True
    for radius in (1.0, 2.0, 3.0):
        p.line(10.0 + radius, 10.0, word="G01", feed=400 / unit)
        p.arc("XY", (10.0, 10.0), 2 * math.pi, word="G03")
        p.arc("XY", (10.0, 10.0), -2 * math.pi, word="G02")
    if steps:
        p.say("G90")
        p.steps = False
    p.rapid(z=6.35, word="G00")
    p.say("M5M9")
    p.say("M30")
    p.save(name, last_end=False)


def pycam(name, unit=1.0):
    p = Post(unit, 5)
    p.say("; Estimated time: 3 minutes")
    p.say("G40 (disable tool radius compensation)")
    p.say("G49 (disable tool length compensation)")
    p.say("G80 (cancel modal motion)")
    p.say("G54 (select coordinate system 1)")
    p.say("G90 (use absolute coordinates)")
    p.say("G%d ; unit" % (20 if unit == IN else 21))
    p.say("S1000 ; spindle speed")
    p.say("T1 M6")
    p.say("M3 ; start spindle")
    p.say("G04 P3 (wait for 3 seconds)")
    p.say("F%s" % p.num(200 / unit))
    raster(p, 200 / unit)
    p.say("M5 ; stop spindle")
    p.say("M2 ; end program")
    p.save(name)


def upright(name, plane, unit=1.0, radius_word=False, lower=False, centre_absolute=False):
    p = Post(unit, 5 if unit == IN else 4, lower=lower)
    p.say("(lift and lead by arcs) G90 G94")
    p.say("G20" if unit == IN else "G21")
    p.say(("G18" if plane == "ZX" else "G19") + (" G90.1" if centre_absolute else " G91.1"))
    p.centre_absolute = centre_absolute
    p.say("M3 S9000")
    scallops(p, 250 / unit, plane)
    p.say("G17")
    p.say("M5")
    p.say("M2")
    p.save(name)


def stepwise(name, unit=1.0, blanks=False):
    """G91 throughout, with blanks within words and a mix of G90."""
    p = Post(unit, 4, join="  " if blanks else "")
    p.say("G21 G90 G17" if unit == 1.0 else "G20 G90 G17")
    p.say("M3 S5000")
    p.rapid(z=5.0)
    p.rapid(0.0, 0.0)
    p.rapid(2.5, 7.0)
    p.say("G91")
    p.steps = True
    rng = random.Random(5)
    p.line(z=0.5, feed=120 / unit)
    for _ in range(12):
        p.line(*[p.at[k] + rng.uniform(-2, 2) for k in range(2)])
        p.line(z=rng.uniform(-1, 0))
    p.arc("XY", (p.at[0] + 2.0, p.at[1] + 1.0), -1.0, -0.25)
    p.say("G90")
    p.steps = False
    p.rapid(z=5.0)
    p.say("M5")
    p.say("M2")
    p.lines = [line.replace("X-", "X - ").replace("Y", "Y ") for line in p.lines] if blanks else p.lines
    p.save(name)


def by_radius(name, unit=1.0):
    p = Post(unit, 6)
    p.say("G%d G90 G17 G40" % (20 if unit == IN else 21))
    p.say("M3 S6000")
    p.rapid(z=3.0)
    p.rapid(1.0, 2.0)
    p.line(z=-0.5, feed=90 / unit)
    for angle in (0.4, -0.9, 1.5, -2.5, 4.0, -5.0):
        p.arc("XY", (p.at[0] + 1.3, p.at[1] - 0.8), angle, radius_word=True)
    p.rapid(z=3.0)
    p.say("M30")
    p.save(name)


def main():
    for k, (unit, digits, arcs) in enumerate([(1.0, 3, False), (1.0, 3, True), (IN, 4, False), (IN, 5, True), (1.0, 5, True), (1.0, 4, True)]):
        fusion(f"adaptive-{k + 1}", unit, digits, arcs)
    for k, (arcs, unit) in enumerate([(False, 1.0), (True, 1.0), (False, IN), (True, IN)]):
        freecad(f"workbench-{k + 1}", arcs, unit)
    for k, (steps, unit) in enumerate([(False, 1.0), (True, 1.0), (False, IN), (True, IN)]):
        wizard(f"wizard-{k + 1}", steps, unit)
    for k, unit in enumerate([1.0, IN]):
        pycam(f"parallel-{k + 1}", unit)
    k = 0
    for plane in ("ZX", "YZ"):
        for unit, radius_word, lower, absolute in [(1.0, 0, 0, 0), (IN, 0, 1, 0), (1.0, 0, 0, 1), (IN, 0, 0, 1)]:
            k += 1
            upright(f"upright-{k}", plane, unit, radius_word, lower, absolute)
    for k, (unit, blanks) in enumerate([(1.0, False), (IN, False), (1.0, True), (IN, True)]):
        stepwise(f"steps-{k + 1}", unit, blanks)
    for k, unit in enumerate([1.0, IN]):
        by_radius(f"radius-{k + 1}", unit)
    p = Post(1.0, 4, end="\r")
    p.say("g21g90g94(all in one file of old line ends)")
    p.say("/m8")
    p.say("m3s2000")
    raster(p, 100)
    p.say("m2")
    p.save("old-line-ends-1")


main()
