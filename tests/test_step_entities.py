"""Every STEP entity that can bound a container arrives, and its patches are the surface that OCC has."""

import re
from pathlib import Path

import numpy as np
import pytest

from glassworkbench.freecad import FreeCAD, Part
from glassworkbench.mold import read_mold
from glassworkbench.mold.patches import face_patches, locate
from glassworkbench.mold.read import read_shape
from glassworkbench.mold.step_entities import count_entities

TURN = 2.0 * np.pi
HEAD = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION((''),'2;1');
FILE_NAME('','2026-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
#1=APPLICATION_CONTEXT('');
#2=PRODUCT_CONTEXT('',#1,'mechanical');
#3=PRODUCT('p','p','',(#2));
#4=PRODUCT_DEFINITION_FORMATION('','',#3);
#5=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design');
#6=PRODUCT_DEFINITION('design','',#4,#5);
#7=PRODUCT_DEFINITION_SHAPE('','',#6);
#8=SHAPE_DEFINITION_REPRESENTATION(#7,#9);
#9=GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION('',(#17),#10);
#10=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#14))
GLOBAL_UNIT_ASSIGNED_CONTEXT((#11,#12,#13))REPRESENTATION_CONTEXT('',''));
#11=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#12=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#13=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());
#14=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),#11,'','');
#17=GEOMETRIC_SET('',(#20));
"""
AXES = """#30=AXIS2_PLACEMENT_3D('',#31,#32,#33);
#31=CARTESIAN_POINT('',(1.,2.,3.));
#32=DIRECTION('',(0.,0.,1.));
#33=DIRECTION('',(1.,0.,0.));
"""


def at(x, y, z):
    return FreeCAD.Vector(x, y, z)


def write(tmp_path, entities, head=HEAD) -> Path:
    path = tmp_path / "surface.step"
    path.write_text(head + AXES + entities + "ENDSEC;\nEND-ISO-10303-21;\n")
    return path


def assert_patches_are_the_surface(face):
    """Compare at 1000 points: to 1e-9 mm where the patches are exact, else to the error that they state."""
    patches = face_patches(face)
    surface = face.Surface
    u0, u1, v0, v1 = face.ParameterRange
    rng = np.random.default_rng(11)
    parameters = np.column_stack([rng.uniform(u0, u1, 1000), rng.uniform(v0, v1, 1000)])
    points = np.array([tuple(surface.value(*uv)) for uv in parameters])
    for start in (parameters, None):
        numbers, uv = locate(patches, points, start)
        assert np.all((uv >= 0.0) & (uv <= 1.0))
        assert np.linalg.norm(patches.points(numbers, uv) - points, axis=1).max() < max(patches.error_mm, 1e-9)
    # And back: what the patches say lies on OCC's surface.
    numbers, uv = rng.integers(len(patches.controls), size=100), rng.uniform(size=(100, 2))
    for point in patches.points(numbers, uv):
        assert face_distance(surface, point) < max(patches.error_mm, 1e-9)
    return patches


def face_distance(surface, point):
    return (surface.value(*surface.parameter(at(*point))) - at(*point)).Length


def spline_curve():
    curve = Part.BSplineCurve()
    curve.interpolate([at(20, 0, 0), at(25, 0, 20), at(15, 0, 40), at(16, 0, 60)])
    return curve


def circle(x=0.0, radius=8.0, normal=(0, 0, 1)):
    return Part.Circle(at(x, 0, 0), at(*normal), radius)


def conic(kind):
    curve = getattr(Part, kind)()
    if kind == "Parabola":
        curve.Focal = 2.0
    else:
        curve.MajorRadius, curve.MinorRadius = 10.0, 5.0
    return curve


def spline_surface(rational):
    surface = Part.BSplineSurface()
    rng = np.random.default_rng(3)
    poles = [[at(10 * i, 10 * j, 4 * rng.uniform()) for j in range(5)] for i in range(6)]
    weights = rng.uniform(0.5, 2.0, (6, 5)).tolist() if rational else [[1.0] * 5] * 6
    knots = [0, 1, 3, 4], [0, 0.3, 1]
    surface.buildFromPolesMultsKnots(poles, [4, 1, 1, 4], [3, 2, 3], *knots, False, False, 3, 2, weights)
    return surface


def extruded(curve, low, high):
    return Part.SurfaceOfExtrusion(curve, at(0, 0.1, 1)).toShape(low, high, 0, 10)


def revolved(curve, low, high, turn=(0.0, TURN)):
    return Part.SurfaceOfRevolution(curve, at(0, 0, 0), at(0, 0, 1)).toShape(*turn, low, high)


def elementary(kind, bounds, **sizes):
    surface = Part.Cone(at(0, 0, 0), at(0, 0, 40), 20, 10) if kind == "Cone" else getattr(Part, kind)()
    for name, size in sizes.items():
        setattr(surface, name, size)
    return surface.toShape(*bounds)


FACES = {
    "PLANE": lambda: elementary("Plane", (-3, 4, -5, 6)),
    "CYLINDRICAL_SURFACE": lambda: elementary("Cylinder", (0, TURN, 0, 30), Radius=20.0),
    "CONICAL_SURFACE": lambda: elementary("Cone", (0, TURN, 0, 30)),
    "SPHERICAL_SURFACE": lambda: elementary("Sphere", (0, TURN, -0.5 * np.pi, 0.5 * np.pi), Radius=12.0),
    "TOROIDAL_SURFACE": lambda: elementary("Toroid", (0, TURN, 0, TURN), MajorRadius=20.0, MinorRadius=4.0),
    "LINE": lambda: revolved(Part.LineSegment(at(10, 0, 0), at(14, 0, 30)), 0, 30, (0.5, 3.0)),
    "CIRCLE": lambda: extruded(circle(), 0, TURN),
    "ELLIPSE": lambda: extruded(Part.Ellipse(at(0, 0, 0), 20, 10), 0, TURN),
    "PARABOLA": lambda: extruded(conic("Parabola"), -5, 5),
    "HYPERBOLA": lambda: extruded(conic("Hyperbola"), -1, 1),
    "B_SPLINE_CURVE_WITH_KNOTS": lambda: extruded(spline_curve(), 0, spline_curve().LastParameter),
    "SURFACE_OF_LINEAR_EXTRUSION": lambda: extruded(circle(), 0.1, 1.9),
    "SURFACE_OF_REVOLUTION": lambda: revolved(spline_curve(), 0, spline_curve().LastParameter),
    "B_SPLINE_SURFACE_WITH_KNOTS": lambda: spline_surface(False).toShape(),
    "RATIONAL_B_SPLINE_SURFACE": lambda: spline_surface(True).toShape(),
    "OFFSET_SURFACE": lambda: Part.OffsetSurface(revolved(spline_curve(), 0, 60).Surface, 2.0).toShape(0, TURN, 0, 60),
}


@pytest.mark.parametrize("entity", FACES)
def test_an_entity_that_occ_writes_arrives_as_patches(tmp_path, entity):
    path = tmp_path / "face.step"
    FACES[entity]().exportStep(str(path))
    assert re.search(rf"\b{entity}\s*\(", path.read_text())
    (face,) = read_shape(path).Faces
    patches = assert_patches_are_the_surface(face)
    assert (patches.error_mm > 0.0) == (entity == "OFFSET_SURFACE")
    assert patches.error_mm < 1e-4


TRIANGLE = """#26=POLYLINE('',(#40,#41,#42));
#40=CARTESIAN_POINT('',(-9.,2.,3.));
#41=CARTESIAN_POINT('',(1.,-6.,3.));
#42=CARTESIAN_POINT('',(11.,2.,3.));
"""
HALF_CIRCLE = """#25=TRIMMED_CURVE('',#27,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(3.14159265358979)),.T.,.PARAMETER.);
#27=CIRCLE('',#30,10.);
"""


def test_a_rectangular_trimmed_surface_arrives(tmp_path):
    entities = "#20=RECTANGULAR_TRIMMED_SURFACE('',#21,0.,1.5,0.,20.,.T.,.T.);\n#21=CYLINDRICAL_SURFACE('',#30,8.);\n"
    (face,) = read_shape(write(tmp_path, entities)).Faces
    assert face.Area == pytest.approx(8 * 1.5 * 20, rel=1e-9)
    assert_patches_are_the_surface(face)


def test_a_curve_bounded_surface_arrives_with_a_composite_curve_of_a_trimmed_curve_and_a_polyline(tmp_path):
    entities = """#20=CURVE_BOUNDED_SURFACE('',#21,(#22),.F.);
#21=PLANE('',#30);
#22=BOUNDARY_CURVE('',(#23,#24),.F.);
#23=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#25);
#24=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#26);
"""
    (face,) = read_shape(write(tmp_path, entities + HALF_CIRCLE + TRIANGLE)).Faces
    # OCC joins the boundary to one curve of its own, a little off at the corners.
    assert face.Area == pytest.approx(0.5 * np.pi * 100 + 80, abs=1.0)
    assert_patches_are_the_surface(face)


@pytest.mark.parametrize(
    ("curve", "number", "area"), [(TRIANGLE, 26, 2 * np.hypot(10, 8) * 20), (HALF_CIRCLE, 25, 400)]
)
def test_swept_polylines_and_trimmed_curves_arrive(tmp_path, curve, number, area):
    entities = f"""#20=RECTANGULAR_TRIMMED_SURFACE('',#21,0.,2.,0.,20.,.T.,.T.);
#21=SURFACE_OF_LINEAR_EXTRUSION('',#{number},#22);
#22=VECTOR('',#32,1.);
"""
    (face,) = read_shape(write(tmp_path, entities + curve)).Faces
    assert face.Area == pytest.approx(area, rel=1e-9)
    assert_patches_are_the_surface(face)


SEED_POLES = (
    ((0.0, 1.629613349067e2, -3.284607848130e1), (1.956590335226e-14, 1.489368855047e2, -3.822341141259e1),
     (2.481786542645e-14, 1.341581379339e2, -4.090473771141e1),
     (2.097156146846e-14, 1.191385086726e2, -4.079690759637e1)),
    ((2.021343062411e1, 1.629613349067e2, -3.284607848130e1), (2.352263376723e1, 1.489368855047e2, -3.822341141259e1),
     (2.517271821043e1, 1.341581379339e2, -4.090473771141e1), (2.510635970889e1, 1.191385086726e2, -4.079690759637e1)),
    ((3.405047605874e1, 1.629613349067e2, -1.811112170376e1), (3.962498463641e1, 1.489368855047e2, -2.107614936195e1),
     (4.240462960973e1, 1.341581379339e2, -2.255461586909e1), (4.229284558801e1, 1.191385086726e2, -2.249515901984e1)),
    ((3.278126424839e1, 1.629613349067e2, 2.062422332341), (3.814798624147e1, 1.489368855047e2, 2.400067860779),
     (4.082402155533e1, 1.341581379339e2, 2.568429732110), (4.071640421840e1, 1.191385086726e2, 2.561659023166)),
)  # fmt: skip
"""The quoted poles, a bottle's shoulder; the first of them completed from its neighbour at the same height."""


def test_the_quoted_rational_shoulder_arrives(tmp_path):
    mirrored = [[(-x, y, z) for x, y, z in row] for row in SEED_POLES[:0:-1]]
    poles = [*mirrored, *SEED_POLES]
    outer = [1.197664505200, 1.183795474926, 1.183795474926, 1.197664505200]
    inner = [9.457933490053e-1, 9.348410025564e-1, 9.348410025564e-1, 9.457933490053e-1]
    weights = [outer, inner, inner, outer, inner, inner, outer]

    def listed(rows):
        return "(" + ",".join("(" + ",".join(row) + ")" for row in rows) + ")"

    numbers = listed([[f"#{100 + 4 * i + j}" for j in range(4)] for i in range(7)])
    entities = f"""#20=RECTANGULAR_TRIMMED_SURFACE('',#21,0.,2.,0.,1.,.T.,.T.);
#21=(BOUNDED_SURFACE()B_SPLINE_SURFACE(3,3,{numbers},.UNSPECIFIED.,.F.,.F.,.F.)
B_SPLINE_SURFACE_WITH_KNOTS((4,3,4),(4,4),(0.E0,1.E0,2.E0),(0.E0,1.E0),.UNSPECIFIED.)
GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE({listed([list(map(repr, row)) for row in weights])})
REPRESENTATION_ITEM('')SURFACE());
"""
    for number, (x, y, z) in enumerate((pole for row in poles for pole in row), start=100):
        entities += f"#{number}=CARTESIAN_POINT('',({x:.15E},{y:.15E},{z:.15E}));\n"
    (face,) = read_shape(write(tmp_path, entities)).Faces
    patches = assert_patches_are_the_surface(face)
    assert patches.degrees == (3, 3)
    controls = np.array([[(*pole, 1.0) for pole in row] for row in poles]) * np.array(weights)[:, :, None]
    assert patches.controls == pytest.approx(np.array([controls[:4], controls[3:]]), abs=1e-12)
    # The quoted numbers have 13 digits, and make a body of revolution about the y axis.
    at_top = patches.points(np.zeros(50, dtype=int), np.column_stack([np.linspace(0, 1, 50), np.zeros(50)]))
    assert np.ptp(np.hypot(at_top[:, 0], at_top[:, 2])) < 0.2


@pytest.mark.parametrize(
    ("unit", "mm"),
    [
        ("#11=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));", 1000.0),
        (
            "#11=(CONVERSION_BASED_UNIT('INCH',#15)LENGTH_UNIT()NAMED_UNIT(#16));\n"
            "#15=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#18);\n#18=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));"
            "\n#16=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);",
            25.4,
        ),
    ],
    ids=["metre", "inch"],
)
def test_units_are_honoured(tmp_path, unit, mm):
    head = HEAD.replace("#11=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));", unit)
    assert head != HEAD
    entities = "#20=RECTANGULAR_TRIMMED_SURFACE('',#21,0.,1.5,0.,20.,.T.,.T.);\n#21=CYLINDRICAL_SURFACE('',#30,8.);\n"
    (face,) = read_shape(write(tmp_path, entities, head)).Faces
    assert face.Surface.Radius == pytest.approx(8.0 * mm, rel=1e-12)
    assert face.Surface.Center.x == pytest.approx(mm, rel=1e-12)


@pytest.mark.parametrize(
    "schema",
    [
        "CONFIG_CONTROL_DESIGN",
        "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
        "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
    ],
    ids=["AP203", "AP214", "AP242"],
)
def test_a_manifold_solid_arrives_in_every_application_protocol(tmp_path, schema):
    path = tmp_path / "can.step"
    Part.makeCylinder(20, 60).exportStep(str(path))
    text = re.sub(r"FILE_SCHEMA\(\(.*?\)\);", f"FILE_SCHEMA(('{schema}'));", path.read_text(), flags=re.S)
    assert schema in text
    assert "MANIFOLD_SOLID_BREP" in text
    path.write_text(text)
    assert read_mold(path).anatomy.height_mm == pytest.approx(60, abs=1e-9)


@pytest.mark.parametrize("closed", [True, False])
def test_a_shell_based_surface_model_arrives(tmp_path, closed):
    path = tmp_path / "shell.step"
    faces = Part.makeBox(30, 30, 90).Faces
    Part.makeShell(faces if closed else faces[:5]).exportStep(str(path))
    assert "SHELL_BASED_SURFACE_MODEL" in path.read_text()
    mold = read_mold(path, close_open_shell=not closed)
    assert mold.solid.Volume == pytest.approx(81000, rel=1e-9)
    assert len(mold.repairs) == (0 if closed else 1)
    assert all(assert_patches_are_the_surface(face).degrees == (1, 1) for face in mold.upright.Faces)


@pytest.mark.parametrize("name", ["jar", "wine_bottle"])
def test_mesh_nodes_of_a_mold_are_found_on_its_patches(name):
    mold = read_mold(Path(__file__).resolve().parent.parent / "examples" / "molds" / f"{name}.step")
    mold.upright.tessellate(0.5)
    for face in mold.upright.Faces:
        parameters = np.array(face.getUVNodes())
        nodes = np.array([tuple(face.Surface.value(*uv)) for uv in parameters])
        patches = face_patches(face)
        assert np.linalg.norm(patches.points(*locate(patches, nodes, parameters)) - nodes, axis=1).max() < 1e-9


def test_an_instance_of_several_types_counts_once_as_what_it_is():
    data = """#1=( BOUNDED_SURFACE() B_SPLINE_SURFACE(3,3,((#2,#3),(#4,#5)),.U.,.F.)
    GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_SURFACE(((1.,1.),(1.,0.7)))
    REPRESENTATION_ITEM('a;)') SURFACE() );
    #6=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
    #7=PLANE('#8=PLANE(',#9); /* #10=PLANE('',#9); */ #11 = PLANE ('it''s',#9);"""
    assert count_entities(data) == {"PLANE": 2, "RATIONAL_B_SPLINE_SURFACE": 1, "LENGTH_UNIT+NAMED_UNIT+SI_UNIT": 1}
