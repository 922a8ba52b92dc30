"""The format of a scene file, as pydantic models: one class a table, one line a key.

Only what can be said of a key by itself is checked here; what two places of a file must agree on is in
:mod:`stiction.scene.references`, and what only a world can tell is told when the world is built.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Discriminator, Field, model_validator

from stiction import shapes
from stiction.checks import nearest
from stiction.scene import fields
from stiction.scene.fields import Flag, Name, Number, Table, Text, Vector, fault
from stiction.scene.model_vehicle import VehicleTable
from stiction.world import SOLVERS

MOST_COPIES = 100_000
"""Bodies of one grid at most: a slip of the finger should not fill the memory."""


class Rotation(Table):
    """A turn about an axis."""

    axis: fields.Direction
    """Direction of the axis; its length does not matter."""
    angle_deg: Number
    """Angle in degrees, by the right-hand rule."""


class _Placed(Table):
    """Something that may be turned, by a rotation or by a quaternion."""

    orientation: fields.Quaternion | None = None
    """Unit quaternion w, x, y, z; normalised here."""
    rotation: Rotation | None = None
    """The same as axis and angle; at most one of the two."""

    @model_validator(mode="after")
    def _one_turn(self) -> _Placed:
        if self.orientation is not None and self.rotation is not None:
            raise fault("must not be given together with orientation.", key="rotation")
        return self


class WorldTable(Table):
    """What holds for the whole world."""

    gravity: Vector = (0.0, 0.0, -9.81)
    """m/s^2"""
    dt: fields.Duration = 1.0 / 60.0
    """Time step, s."""
    solver: Annotated[Literal["micro", "soft", "exact"], fields.word(*SOLVERS)] = "soft"
    """The solver."""
    iterations: Annotated[int, Field(ge=1), fields.whole(1)] | None = None
    """How often a contact may be resolved in a stage of a step, on average; passes a substep of exact."""
    micro_literal: Flag = False
    """Use the slides' friction word for word."""
    restitution_threshold: fields.Speed = 0.25
    """Closing speeds below it do not bounce, m/s."""


class PairTable(Table):
    """One pair of materials. What is left out keeps the value it has in the base table."""

    OTHER_WORDS: ClassVar[dict[str, str]] = {
        "friction": "static", "mu": "static", "mu_s": "static", "mu_d": "dynamic", "mu_k": "dynamic",
        "kinetic": "dynamic", "bounce": "restitution", "material_a": "a", "material_b": "b",
    }  # fmt: skip

    a: Text
    """One material."""
    b: Text
    """The other one, or the same."""
    static: fields.Coefficient | None = None
    """Coefficient of static friction."""
    dynamic: fields.Coefficient | None = None
    """Coefficient of dynamic friction."""
    restitution: fields.Fraction | None = None
    """Coefficient of restitution, 0 to 1."""
    rolling: fields.Arm | None = None
    """Lever arm of rolling resistance, m."""
    torsional: fields.Arm | None = None
    """Lever arm of torsional resistance, m."""
    law: dict[str, Any] | None = None
    """How the dynamic coefficient depends on speed or slip, such as {kind = "stribeck", speed = 0.01}."""
    static_across: fields.Coefficient | None = None
    """Coefficient of static friction across the grain of a body that has one."""
    dynamic_across: fields.Coefficient | None = None
    """The same for dynamic friction."""
    adhesion: fields.Force | None = None
    """Force with which a contact holds on, N."""
    adhesion_pressure: fields.Pressure | None = None
    """The same per area of a face, Pa."""
    tangential_restitution: fields.Fraction | None = None
    """Of impacts that bounce, how much of the slip comes back reversed where friction can hold, 0 to 1."""
    source: Text | None = None
    """Where the numbers come from."""


class MaterialsTable(Table):
    """The pairs of materials."""

    base: Annotated[Literal["default", "lecture", "empty"], fields.word("default", "lecture", "empty")] = "default"
    """The table to start from: all that ships with stiction, the nine rows of the lecture, or none."""
    pairs: tuple[PairTable, ...] = ()
    """Pairs that are added to it or changed in it."""


class FrameTable(_Placed):
    """A frame of reference that bodies can be placed in."""

    position: Vector = (0.0, 0.0, 0.0)
    """Its origin, m."""


class SphereTable(Table):
    """A solid sphere."""

    type: Literal["sphere"]
    radius: fields.Length
    """m"""

    def build(self) -> shapes.Shape:
        """The shape."""
        return shapes.Sphere(self.radius)


class BoxTable(Table):
    """A solid box, centred on its frame."""

    type: Literal["box"]
    size: fields.Lengths
    """Full lengths along x, y and z, m."""

    def build(self) -> shapes.Shape:
        """The shape."""
        return shapes.Box(self.size)


class PlaneTable(Table):
    """Everything below a plane; never dynamic."""

    type: Literal["plane"]
    normal: fields.Direction = (0.0, 0.0, 1.0)
    """Outward direction."""
    offset: Number = 0.0
    """Distance of the surface from the origin along the normal, m."""

    def build(self) -> shapes.Shape:
        """The shape."""
        return shapes.Plane(self.normal, self.offset)


class CapsuleTable(Table):
    """A cylinder along z with half a sphere on each end."""

    type: Literal["capsule"]
    radius: fields.Length
    """m"""
    length: fields.Length
    """Between the centres of the two half spheres, m."""

    def build(self) -> shapes.Shape:
        """The shape."""
        return shapes.Capsule(self.radius, self.length)


class CylinderTable(Table):
    """A solid cylinder along z."""

    type: Literal["cylinder"]
    radius: fields.Length
    """m"""
    length: fields.Length
    """Between the flat ends, m."""

    def build(self) -> shapes.Shape:
        """The shape."""
        return shapes.Cylinder(self.radius, self.length)


class EllipsoidTable(Table):
    """A solid ellipsoid, centred on its frame."""

    type: Literal["ellipsoid"]
    half_extents: fields.Lengths
    """Semi-axes along x, y and z, m."""

    def build(self) -> shapes.Shape:
        """The shape."""
        return shapes.Ellipsoid(self.half_extents)


class HullTable(Table):
    """The convex hull of points."""

    type: Literal["hull"]
    points: fields.Points
    """Four or more points that do not lie in one plane, m."""

    def build(self) -> shapes.Shape:
        """The shape."""
        return shapes.ConvexHull(self.points)


SHAPES = ("box", "sphere", "plane", "capsule", "cylinder", "ellipsoid", "hull")


def _known_type(value: Any) -> Any:
    """The type decides which other keys there are, so it is checked before them."""
    if not isinstance(value, dict):
        raise fault(f'must be a table such as {{type = "box", size = [1, 1, 1]}}, got {value!r}.')
    kind = value.get("type")
    if kind is None:
        raise fault(f"must be given: one of {', '.join(SHAPES)}.", key="type")
    if kind not in SHAPES:
        raise fault(f"must be one of {', '.join(SHAPES)}, got {kind!r}{nearest(kind, SHAPES)}.", key="type")
    return value


ShapeTable = Annotated[
    SphereTable | BoxTable | PlaneTable | CapsuleTable | CylinderTable | EllipsoidTable | HullTable,
    Discriminator("type"),
]


class GridTable(Table):
    """Copies of a body in rows, named ``name[i,j,k]`` from 0."""

    count: fields.Counts
    """How many along x, y and z."""
    step: Vector
    """Distance from one to the next along x, y and z, m."""

    @model_validator(mode="after")
    def _not_too_many(self) -> GridTable:
        nx, ny, nz = self.count
        if nx * ny * nz > MOST_COPIES:
            raise fault(f"must ask for {MOST_COPIES} copies or fewer, got {nx} x {ny} x {nz}.", key="count")
        return self


class BodyTable(_Placed):
    """A body, or a grid of equal ones."""

    name: Name
    """Unique in the scene."""
    shape: Annotated[ShapeTable, BeforeValidator(_known_type)]
    """What it looks like."""
    static: Flag = False
    """It never moves."""
    kinematic: Flag = False
    """It moves as its velocity says, whatever it meets."""
    material: Text = "default"
    """Its name in the table of materials."""
    mass: fields.Kilograms | None = None
    """kg; at most one of mass and density."""
    density: fields.Density | None = None
    """kg/m^3; 1000 if there is no mass either."""
    center_of_mass: Vector | None = None
    """In the shape's frame, m, for a body that is loaded on one side; with it goes inertia."""
    inertia: fields.Inertia | None = None
    """About the centre of mass in the shape's axes, kg m^2: three principal moments, or a tensor of three rows."""
    frame: Text | None = None
    """The frame in which position, orientation and velocities are given; the world if left out."""
    position: Vector = (0.0, 0.0, 0.0)
    """Origin of the shape's frame, m."""
    velocity: Vector = (0.0, 0.0, 0.0)
    """Of the centre of mass, m/s."""
    angular_velocity: Vector = (0.0, 0.0, 0.0)
    """rad/s"""
    surface_velocity: Vector | None = None
    """Of a belt relative to the body, in the shape's axes, m/s."""
    grain: fields.Direction | None = None
    """Direction in the shape's axes along which its surface has its coefficients along; none if left out."""
    grid: GridTable | None = None
    """Copies of it."""

    @model_validator(mode="after")
    def _one_mass(self) -> BodyTable:
        if self.mass is not None and self.density is not None:
            raise fault("must not be given together with mass.", key="density")
        if self.static and self.kinematic:
            raise fault("must not be true where static is true.", key="kinematic")
        if self.center_of_mass is not None and self.inertia is None:
            raise fault("needs inertia beside it, for that of the shape is of its own centre.", key="center_of_mass")
        return self


class PushTable(Table):
    """A force that acts in a window of time."""

    body: Text
    """The body it acts on, a dynamic one."""
    force: Vector
    """N"""
    growth: Vector = (0.0, 0.0, 0.0)
    """By how much the force grows while it acts, N/s."""
    frame: Text | None = None
    """The frame in whose axes force and growth are given; the world's if left out."""
    start: fields.Time = Field(default=0.0, alias="from")
    """When it begins, s."""
    until: fields.Duration | None = None
    """When it ends, s; with the scene if left out."""
    at: Vector | None = None
    """The point it acts at, in the frame of the body's shape, m; the centre of mass if left out."""

    @model_validator(mode="after")
    def _ends_later(self) -> PushTable:
        if self.until is not None and self.until <= self.start:
            raise fault(f"must be later than from ({self.start:g} s), got {self.until:g}.", key="until")
        return self


class SpringTable(Table):
    """A spring without length of its own that pulls a body towards a place, which may move."""

    body: Text
    """The body it pulls, a dynamic one."""
    stiffness: fields.Stiffness
    """Force per length, N/m."""
    anchor: Vector
    """Where its other end is at first, m."""
    velocity: Vector = (0.0, 0.0, 0.0)
    """Velocity of its other end, m/s."""
    frame: Text | None = None
    """The frame in which anchor and velocity are given; the world if left out."""
    at: Vector = (0.0, 0.0, 0.0)
    """The point of the body that it holds, in the frame of the body's shape, m."""


class VelocityChangeTable(Table):
    """A new velocity of a kinematic body from a time on."""

    body: Text
    """The body, a kinematic one."""
    time: fields.Time
    """s; the nearest step is taken."""
    velocity: Vector | None = None
    """m/s; as before if left out."""
    angular_velocity: Vector | None = None
    """rad/s; as before if left out."""
    frame: Text | None = None
    """The frame in whose axes they are given; the world's if left out."""


class SceneTable(Table):
    """A scene: what is there, what happens to it from outside, and what must come of it."""

    title: Text
    """A few words."""
    expect: Text
    """One sentence that says what must happen."""
    duration: fields.Duration
    """Simulated time, s."""
    world: WorldTable = WorldTable()
    """What holds for the whole world."""
    materials: MaterialsTable = MaterialsTable()
    """The pairs of materials."""
    frames: dict[Name, FrameTable] = Field(default_factory=dict)
    """Named frames of reference."""
    bodies: tuple[BodyTable, ...] = ()
    """The bodies, in the order in which they are added to the world."""
    pushes: tuple[PushTable, ...] = ()
    """Forces that act in a window of time."""
    springs: tuple[SpringTable, ...] = ()
    """Springs that pull bodies."""
    velocity_changes: tuple[VelocityChangeTable, ...] = ()
    """New velocities of kinematic bodies."""
    vehicles: tuple[VehicleTable, ...] = ()
    """Wheels under bodies, and their drivers."""
