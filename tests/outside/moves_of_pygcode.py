"""What pygcode (PyPI) makes of a program, a line a move, in mm:

    R x y z                       rapid
    L x y z feed                  line, mm/min

It keeps what is in force by itself; here it is only asked where it stands after each line. Exit code 3: it is not installed.
"""
import sys

try:
    from pygcode import Line, Machine
except ImportError as why:
    print(f"pygcode: {why}")
    sys.exit(3)

KINDS = {"G00": "R", "G01": "L"}


def main():
    machine, before = Machine(), None
    for text in open(sys.argv[1], encoding="ascii"):
        machine.process_block(Line(text.rstrip("\r\n")).block)
        at = tuple(machine.pos.values[axis] for axis in "XYZ")
        if at != before and machine.mode.motion is not None:
            kind = KINDS[str(machine.mode.motion)]
            feed = [float(machine.mode.feed_rate.word.value)] if kind == "L" else []
            print(kind, *[f"{number:.9f}" for number in (*at, *feed)])
        before = at


main()
