"""What LinuxCNC's own interpreter makes of a program, a line a move, in mm:

    R x y z                       rapid
    L x y z feed                  line, mm/min
    A x y z feed cx cy turns      arc: its centre in the plane's axes, and whole turns begun, negative clockwise

Positions are doubles as the interpreter has them. Changes of tools (T, M6) are taken out before: they move nothing here,
and without a running machine the module ends the process at them. Exit code 3: the interpreter is not installed.
"""
import os
import re
import sys
import tempfile

sys.path.append("/usr/lib/python3/dist-packages")
try:
    import gcode
except ImportError as why:
    print(f"LinuxCNC's python module gcode: {why}")
    sys.exit(3)

MM = 25.4


class Canon:
    """Listens to the interpreter; lengths come in inches."""

    def __init__(self, parameters):
        self.parameter_file, self.plane, self.feed, self.offset = parameters, 1, 0.0, None

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *arguments: None

    def set_plane(self, plane):
        self.plane = plane

    def set_feed_rate(self, feed):
        self.feed = feed * MM

    def say(self, kind, *numbers):
        print(kind, *[f"{number:.9f}" for number in numbers])

    def straight_traverse(self, x, y, z, *rest):
        self.say("R", x * MM, y * MM, z * MM)

    def straight_feed(self, x, y, z, *rest):
        self.say("L", x * MM, y * MM, z * MM, self.feed)

    def arc_feed(self, first, second, centre_first, centre_second, turns, third, *rest):
        ends = {1: (first, second, third), 2: (third, first, second), 3: (second, third, first)}[self.plane]
        self.say("A", *[c * MM for c in ends], self.feed, centre_first * MM, centre_second * MM, turns)

    def get_external_length_units(self):
        return 1.0

    def get_external_angular_units(self):
        return 1.0

    def get_axis_mask(self):
        return 7

    def get_block_delete(self):
        return False

    def get_tool(self, pocket):
        return (pocket,) + (0.0,) * 12 + (0,)

    def check_abort(self):
        return False


def without_tools(text):
    """The program with T and M6 blanked, comments left as they are."""
    parts = re.split(r"(\([^)\n]*\)|;[^\n]*)", text)
    return "".join(part if k % 2 else re.sub(r"(?i)T\d+|M0?6(?!\d)", "", part) for k, part in enumerate(parts))


def main():
    with tempfile.TemporaryDirectory() as folder:
        parameters = os.path.join(folder, "parameters")
        open(parameters, "w").close()
        program = os.path.join(folder, "program.ngc")
        with open(sys.argv[1], newline="", encoding="utf-8") as given, open(program, "w", newline="", encoding="utf-8") as out:
            out.write(without_tools(given.read()))
        result, line = gcode.parse(program, Canon(parameters), "", "")
    if result > gcode.MIN_ERROR:
        sys.exit(f"line {line}: {gcode.strerror(result)}")


main()
