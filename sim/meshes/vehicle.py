"""Vehicles of several models, each in any paint. Add one with ``@vehicle_model("name")``."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Literal

import numpy as np

from sim.checks import check
from sim.mesh import Texture, TexturedMesh
from sim.meshes.car_parts import BodyShape, CabinShape, Swatch, add_body, add_cabin, add_mirrors, add_wheels, colour
from sim.meshes.facets import Facets, palette
from sim.meshes.file import MeshFile, mesh_of_file, names_mesh_file
from sim.meshes.large_vehicles import add_bus, add_coach, add_flatbed, add_lorry, add_motorbike, add_tanker

VehicleModel = Callable[[Facets], None]
"""Adds a vehicle's faces: x ahead, y left, z up, standing on z = 0; colours by ``car_parts.colour``."""
VehicleClass = Literal["car", "lorry", "bus", "motorbike"]

VEHICLES: dict[str, VehicleModel] = {}
"""Every model by its name."""
_CLASSES: dict[str, VehicleClass] = {}


def vehicle_model(name: str, of: VehicleClass = "car") -> Callable[[VehicleModel], VehicleModel]:
    """Return a decorator that enters a model into ``VEHICLES``, as one ``of`` a class.

    Raises:
        ValueError: if the name is taken.
    """

    def enter(model: VehicleModel) -> VehicleModel:
        if name in VEHICLES:
            raise ValueError(f"name: expected one that is not taken yet, got {name!r}")
        VEHICLES[name], _CLASSES[name] = model, of
        return model

    return enter


OWN = "own"
"""Kind of a vehicle from a file whose name is no model's."""
_SIDES_M = (0.5, 30.0)
"""Longest side of a vehicle from a file."""


def kind_of(model: str) -> str:
    """Return the kind of a model in truth: its name; of a file what it says (``@kind=``), or a model of its name."""
    if not names_mesh_file(model):
        return model
    file = MeshFile.of(model)
    check("mesh @kind", not file.kind or file.kind in VEHICLES, f"one of {', '.join(VEHICLES)}", repr(model))
    return file.kind or (file.path.stem if file.path.stem in VEHICLES else OWN)


def class_of(model: str) -> VehicleClass:
    """Return the class of a model."""
    return _CLASSES.get(kind_of(model), "car")


def vehicle(model: str, paint_rgb: tuple[int, int, int]) -> TexturedMesh:
    """Return a vehicle on the ground under the centre of its bounds, x ahead.

    Those of one model share shapes, those of one paint textures, and those of both are one mesh.

    Args:
        model: a name in ``VEHICLES``, or a file, see ``file``, which keeps its own colours.
        paint_rgb: sRGB 0-255.

    Raises:
        ValueError: if there is no such model, colour or file.
    """
    if names_mesh_file(model):
        mesh = mesh_of_file(model, _SIDES_M)
        length, width = mesh.size_m[:2]
        wanted = f"a vehicle that is longer than wide, as {model}@yaw=90 may be"
        check("mesh", length >= 0.9 * width, wanted, f"{length:.3g} m by {width:.3g} m")
        return mesh
    if model not in VEHICLES:
        raise ValueError(f"model: expected one of {', '.join(VEHICLES)}, got {model!r}")
    if len(paint_rgb) != 3 or not all(0 <= c <= 255 for c in paint_rgb):
        raise ValueError(f"paint_rgb: expected three numbers from 0 to 255, got {paint_rgb!r}")
    r, g, b = (int(c) for c in paint_rgb)
    return _painted(VEHICLES[model], (r, g, b))


@lru_cache(maxsize=256)
def _painted(model: VehicleModel, rgb: tuple[int, int, int]) -> TexturedMesh:
    return _unpainted(model).with_texture(_paint(rgb))


@cache
def _unpainted(model: VehicleModel) -> TexturedMesh:
    facets = Facets()
    model(facets)
    mesh = facets.mesh(_paint((128, 128, 128)))
    low, high = mesh.vertices_m.min(axis=0), mesh.vertices_m.max(axis=0)
    offset = np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]], dtype=np.float32)
    return TexturedMesh(mesh.vertices_m - offset, mesh.normals, mesh.uv, mesh.faces, mesh.texture)


@lru_cache(maxsize=256)
def _paint(rgb: tuple[int, int, int]) -> Texture:
    def mixed(other: int, share: float) -> tuple[int, int, int]:
        r, g, b = (round(c + share * (other - c)) for c in rgb)
        return (r, g, b)

    stripe, box, roof, cloth, helmet = (table[sum(rgb) % len(table)] for table in _LIVERIES)
    colours = {
        Swatch.PAINT: rgb,
        Swatch.DARK_PAINT: mixed(0, 0.35),
        Swatch.LIGHT_PAINT: mixed(255, 0.12),
        Swatch.GLASS: (34, 40, 46),
        Swatch.BLACK: (20, 20, 21),
        Swatch.LIGHT: (226, 228, 222),
        Swatch.RED: (158, 22, 20),
        Swatch.CHROME: (142, 144, 146),
        Swatch.STRIPE: stripe,
        Swatch.BOX: box,
        Swatch.ROOF: roof,
        Swatch.ALUMINIUM: (176, 178, 178),
        Swatch.WOOD: (132, 106, 74),
        Swatch.AMBER: (214, 140, 30),
        Swatch.CLOTH: cloth,
        Swatch.HELMET: helmet,
    }
    return palette([colours[swatch] for swatch in Swatch])


_LIVERIES: tuple[tuple[tuple[int, int, int], ...], ...] = (
    ((238, 238, 234), (32, 66, 132), (196, 40, 36), (232, 186, 40), (40, 44, 52), (58, 122, 72), (224, 112, 30)),
    ((226, 226, 222), (214, 214, 210), (206, 62, 40), (44, 84, 140), (208, 192, 146)),
    ((198, 200, 198), (174, 178, 180), (208, 204, 192)),
    ((38, 38, 42), (52, 62, 84), (86, 72, 56), (126, 34, 32), (70, 78, 62), (30, 30, 34), (48, 48, 44), (96, 96, 90)),
    ((222, 222, 218), (30, 30, 32), (190, 30, 30), (36, 78, 160)),
)
"""Further colours, one of each row for every paint: of a stripe, a lorry's box, a bus's roof, clothes and a helmet."""


def _add_car(facets: Facets, body: BodyShape, cabin: CabinShape) -> None:
    add_body(facets, body)
    add_cabin(facets, cabin)
    add_wheels(facets, body)
    add_mirrors(facets, cabin.front_base - 0.45, cabin.base + 0.02, 0.5 * body.width)


@vehicle_model("sedan")
def _sedan(facets: Facets) -> None:
    body = BodyShape(4.70, 1.82, 0.24, 0.93, 0.76, 0.96, 0.98, -1.45, 2.78, 0.33)
    cabin = CabinShape(1.05, 0.30, -1.72, -1.02, 0.93, 1.45, 1.66, 0.19, ((0.36, 0.42), (0.86, 1.0)))
    _add_car(facets, body, cabin)


@vehicle_model("hatchback")
def _hatchback(facets: Facets) -> None:
    body = BodyShape(4.05, 1.76, 0.24, 0.95, 0.76, 0.93, 1.02, -1.70, 2.52, 0.32)
    cabin = CabinShape(1.10, 0.36, -1.86, -1.45, 0.95, 1.48, 1.62, 0.18, ((0.38, 0.44), (0.84, 1.0)))
    _add_car(facets, body, cabin)


@vehicle_model("estate")
def _estate(facets: Facets) -> None:
    body = BodyShape(4.75, 1.82, 0.24, 0.95, 0.77, 0.94, 1.02, -2.05, 2.80, 0.33)
    cabin = CabinShape(1.09, 0.34, -2.18, -1.80, 0.95, 1.49, 1.66, 0.17, ((0.29, 0.34), (0.62, 0.67)))
    _add_car(facets, body, cabin)
    _add_roof_rails(facets, (-1.6, 0.1), 0.60, 1.46)


@vehicle_model("suv")
def _suv(facets: Facets) -> None:
    body = BodyShape(4.62, 1.88, 0.32, 1.10, 0.96, 1.08, 1.06, -1.98, 2.72, 0.38)
    cabin = CabinShape(1.12, 0.46, -2.08, -1.74, 1.10, 1.70, 1.72, 0.17, ((0.31, 0.37), (0.66, 0.73)))
    _add_car(facets, body, cabin)
    _add_roof_rails(facets, (-1.5, 0.2), 0.62, 1.67)


@vehicle_model("van")
def _van(facets: Facets) -> None:
    body = BodyShape(5.30, 1.90, 0.30, 1.16, 0.98, 1.14, 1.62, -2.40, 3.20, 0.35)
    cabin = CabinShape(1.72, 1.08, -2.60, -2.52, 1.16, 2.22, 1.82, 0.10, ((0.26, 0.985), (0.99, 1.0)), rear_glass=False)
    _add_car(facets, body, cabin)


@vehicle_model("pickup")
def _pickup(facets: Facets) -> None:
    body = BodyShape(5.25, 1.86, 0.34, 1.08, 0.98, 0.78, 1.22, -0.62, 3.15, 0.39, axle_centre=0.10)
    cabin = CabinShape(1.30, 0.66, -0.62, -0.44, 1.08, 1.74, 1.70, 0.17, ((0.44, 0.52), (0.92, 1.0)))
    _add_car(facets, body, cabin)
    side, tail, floor, rim = 0.90, -2.60, 0.70, 1.10
    paint = colour(Swatch.PAINT)
    facets.box((tail, -side, floor), (-0.66, -side + 0.09, rim), paint)
    facets.box((tail, side - 0.09, floor), (-0.66, side, rim), paint)
    facets.box((tail, -side + 0.09, floor), (tail + 0.08, side - 0.09, rim - 0.02), paint)
    facets.box((tail + 0.08, -side + 0.09, floor), (-0.62, side - 0.09, 0.80), colour(Swatch.BLACK))


def _add_roof_rails(facets: Facets, span_x: tuple[float, float], y: float, z: float) -> None:
    for side in (-1.0, 1.0):
        low, high = sorted((side * y, side * (y + 0.05)))
        facets.box((span_x[0], low, z), (span_x[1], high, z + 0.05), colour(Swatch.CHROME))


CARS = tuple(VEHICLES)
"""The models that are passenger cars or light vans."""
for _name, _class, _model in (
    ("lorry", "lorry", add_lorry),
    ("flatbed", "lorry", add_flatbed),
    ("tanker", "lorry", add_tanker),
    ("bus", "bus", add_bus),
    ("coach", "bus", add_coach),
    ("motorbike", "motorbike", add_motorbike),
):
    vehicle_model(_name, _class)(_model)  # type: ignore[arg-type]
SHIPPED = tuple(VEHICLES)
"""Our models; users' own follow them in ``VEHICLES``."""
