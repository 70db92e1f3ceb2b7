"""Mitsuba 3 as the scripts beside this one take it: its LLVM found, and exit code 3 where something is missing."""

import os
import sys


def ready(variant):
    """The module with `variant` chosen and running, or the end of the program."""
    # Mitsuba's own choice of LLVM may be too old for its rough lobes: the referee's folder has a newer one.
    home = os.environ.get("REFEREE_HOME", os.path.expanduser("~/.cache/facetmill-referee"))
    library = os.path.join(home, "llvm/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1")
    if os.path.exists(library):
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", library)
    try:
        import drjit as dr
        import mitsuba as mi
        mi.set_variant(variant)
        dr.eval(mi.Float(1) + 1)
        return mi
    except Exception as missing:
        print(f"missing: {missing}")
        sys.exit(3)
