"""Reads STEP files with Open CASCADE and prints what it finds as JSON lines.

    python step_in_occ.py FILE...

Solids, faces, whether all faces are planes, whether the shape is valid and its shell closed, volume in mm³, bounds, the
worst tolerance of a vertex, how far vertices lie from the planes of their faces. Exit 3 if its package (cadquery-ocp-novtk) is missing.
"""

import json
import sys

try:
    from OCP.Bnd import Bnd_Box
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GeomAbs import GeomAbs_Plane
    from OCP.GProp import GProp_GProps
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID, TopAbs_VERTEX
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS
except ImportError as missing:
    print(f"missing: {missing.name}")
    sys.exit(3)


def pieces(shape, kind):
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def cast(kind, shape):
    """The names of these casts differ between versions."""
    return (getattr(TopoDS, f"{kind}_s", None) or getattr(TopoDS, kind))(shape)


def static(of, name):
    return getattr(of, f"{name}_s", None) or getattr(of, name)


for path in sys.argv[1:]:
    reader = STEPControl_Reader()
    status = reader.ReadFile(path)
    reader.TransferRoots()
    shape = reader.OneShape()
    faces = [cast("Face", face) for face in pieces(shape, TopAbs_FACE)]
    worst_plane, tolerance = 0.0, 0.0
    planes = 0
    for face in faces:
        surface = BRepAdaptor_Surface(face)
        planes += surface.GetType() == GeomAbs_Plane
        for vertex in pieces(face, TopAbs_VERTEX):
            vertex = cast("Vertex", vertex)
            worst_plane = max(worst_plane, surface.Plane().Distance(static(BRep_Tool, "Pnt")(vertex)))
            tolerance = max(tolerance, static(BRep_Tool, "Tolerance")(vertex))
    properties = GProp_GProps()
    static(BRepGProp, "VolumeProperties")(shape, properties)
    box = Bnd_Box()
    static(BRepBndLib, "AddOptimal")(shape, box, False, False)
    print(
        json.dumps(
            {
                "read": str(status).endswith("RetDone"),
                "solids": len(list(pieces(shape, TopAbs_SOLID))),
                "faces": len(faces),
                "planes": planes,
                "valid": BRepCheck_Analyzer(shape).IsValid(),
                "closed": all(static(BRep_Tool, "IsClosed")(shell) for shell in pieces(shape, TopAbs_SHELL)),
                "volume": properties.Mass(),
                "bounds": [at() for end in (box.CornerMin(), box.CornerMax()) for at in (end.X, end.Y, end.Z)],
                "off_plane": worst_plane,
                "tolerance": tolerance,
            }
        )
    )
