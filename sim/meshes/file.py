"""Meshes from files: GLB, glTF, OBJ, STL, PLY and URDF, wherever a model's name may stand.

A text names a file and how to read it: ``models/lorry.glb``, ``models/lorry.obj@scale=0.01@up=z@yaw=90``:

* ``scale``: factor to metres; 1 unless given.
* ``up``: ``y`` or ``z``, the file's axis that points up. Unless given y for glTF, as its standard says, and for OBJ;
  z for STL, PLY and URDF (REP 103). With y up the front looks along z (glTF 2.0, 3.4), else along x.
* ``yaw``: degrees by which it is turned, counter-clockwise seen from above, so that its front looks along x.
* ``kind``: what it counts as in truth and exports, where a scene has kinds.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray

from sim.checks import check, check_choice
from sim.mesh import Texture, TexturedMesh

_UP = {".glb": "y", ".gltf": "y", ".obj": "y", ".stl": "z", ".ply": "z", ".urdf": "z"}
MOST_TRIANGLES = 100_000
"""More would take longer to draw than a whole town."""
_SMOOTH_COSINE = math.cos(math.radians(40.0))
"""Corners whose normal differs less from that of their face are shaded round."""
_LARGEST_PX, _BORDER_PX, _SWATCH_PX = 1024, 8, 16
_MOST_REPEATS = 4
_COLOURS = 4096
_Rgb = NDArray[np.uint8]


@dataclass(frozen=True)
class MeshFile:
    """A file and how to read it, see the module."""

    path: Path
    scale: float = 1.0
    up: str = "z"
    yaw_deg: float = 0.0
    kind: str = ""

    @classmethod
    def of(cls, text: str) -> MeshFile:
        """Read the text that names a file. Raises ValueError for an option that there is not."""
        name, *options = text.split("@")
        path = Path(name).expanduser()
        values: dict[str, Any] = {"up": _UP[path.suffix.lower()]}
        for option in options:
            key, _, value = option.partition("=")
            good = f"{name} with @scale=NUMBER, @up=y or z, @yaw=DEGREES or @kind=WORD"
            check("mesh", key in ("scale", "up", "yaw", "kind") and bool(value), good, repr(text))
            if key in ("scale", "yaw"):
                number = _number(value)
                check(f"mesh @{key}", math.isfinite(number) and (key == "yaw" or number > 0), "a number", repr(text))
                values["yaw_deg" if key == "yaw" else key] = number
            else:
                check(f"mesh @{key}", key == "kind" or value in ("y", "z"), "y or z", repr(text))
                values[key] = value
        return cls(path.resolve(), **values)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def names_mesh_file(text: str) -> bool:
    """Return whether a text names a file of a mesh, by its ending."""
    return Path(text.split("@")[0]).suffix.lower() in _UP


def mesh_of_file(text: str, within_m: tuple[float, float]) -> TexturedMesh:
    """Return the mesh of a file, its bounds' centre over the origin and its lowest point on the ground.

    Args:
        text: see the module.
        within_m: least and greatest longest side.

    Raises:
        ValueError: for a file that is missing, empty, too detailed or of another size, that lacks a texture, or that
            names one on another computer.
    """
    file = MeshFile.of(text)
    check("mesh", file.path.is_file(), "a file that exists", str(file.path))
    stamp = file.path.stat()
    mesh = _read(file, stamp.st_mtime_ns, stamp.st_size)
    longest_m = float(mesh.size_m.max())
    fits = within_m[0] <= longest_m <= within_m[1]
    size = " x ".join(f"{side:.3g}" for side in mesh.size_m)
    hint = f"; if its unit is not the metre, say {text}@scale=0.01 (centimetres) or 0.001"
    wanted = f"{file.path.name} with a longest side of {within_m[0]:g} to {within_m[1]:g} m"
    check("mesh", fits, wanted, f"{size} m{hint}")
    return mesh


def check_models(field: str, models: Collection[str], known: Iterable[str], read: Callable[[str], object]) -> None:
    """Raise ValueError for a field of a preset that names no model, an unknown one, or a file that does not do.

    A file that is missing passes: a stored set is read where its meshes are not. Who builds an episode of it, or asks
    for its edition, is told.

    Args:
        known: names that are no files.
        read: reads the mesh of a file, and raises ValueError for one that does not do.
    """
    check(field, bool(models), "one model at least", models)
    for model in models:
        if not names_mesh_file(model):
            check_choice(field, model, known)
        elif MeshFile.of(model).path.exists():
            read(model)


def digest_of_files(texts: Iterable[str]) -> str:
    """Return a digest of all meshes that ``texts`` name, with their textures, "" if none does."""
    meshes = [mesh_of_file(text, (0.0, math.inf)) for text in sorted({*filter(names_mesh_file, texts)})]
    parts = [part for each in meshes for part in (each.vertices_m, each.normals, each.uv, each.faces, each.texture.rgb)]
    whole = hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in parts))
    return whole.hexdigest()[:10] if meshes else ""


@lru_cache(maxsize=64)
def _read(file: MeshFile, changed_ns: int, size: int) -> TexturedMesh:
    """Read a file; ``changed_ns`` and ``size`` tell its versions apart."""
    try:
        parts = _urdf_parts(file.path) if file.path.suffix.lower() == ".urdf" else _parts(file.path)
    except Exception as error:
        # Readers of six formats raise anything; what is checked here says it itself.
        if str(error).startswith("mesh: "):
            raise
        wanted = f"a {file.path.suffix[1:]} file that can be read"
        raise ValueError(f"mesh: expected {wanted}, got {file.path.name}: {type(error).__name__}: {error}") from None
    count = sum(len(part.faces) for part in parts)
    check("mesh", count > 0, "triangles", f"{file.path.name} without any")
    wanted = f"at most {MOST_TRIANGLES} triangles (Blender's Decimate makes fewer)"
    check("mesh", count <= MOST_TRIANGLES, wanted, f"{count} in {file.path.name}")
    mesh = _joined(parts)
    check("mesh", bool(np.isfinite(mesh.vertices_m).all()), "finite corners", file.path.name)
    turn = np.eye(3) if file.up == "z" else np.roll(np.eye(3), 1, axis=0)
    c, s = math.cos(math.radians(file.yaw_deg)), math.sin(math.radians(file.yaw_deg))
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ turn
    corners = file.scale * mesh.vertices_m.astype(float) @ turn.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    corners -= (0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2])
    normals = mesh.normals @ turn.T
    return TexturedMesh(corners.astype(np.float32), normals.astype(np.float32), mesh.uv, mesh.faces, mesh.texture)


def _parts(path: Path) -> list[trimesh.Trimesh]:
    for name in _references(path):
        _check_local(name, path)
        check("mesh", (path.parent / name).is_file(), f"the file that {path.name} names", repr(name))
    scene = trimesh.load_scene(path, process=False)
    return [each for each in scene.dump() if isinstance(each, trimesh.Trimesh) and len(each.faces)]


def _check_local(name: str, path: Path) -> None:
    wanted = f"files beside {path.name}, as nothing is fetched"
    check("mesh", "://" not in name or name.startswith("package://"), wanted, repr(name))


def _references(path: Path) -> list[str]:
    """Return the names of other files that a file needs: buffers, materials, textures."""
    if path.suffix.lower() in (".glb", ".gltf"):
        content = path.read_bytes()
        if path.suffix.lower() == ".glb":
            # Twelve bytes of header, then the length and kind of the first chunk, which is JSON (glTF 2.0, 4.4).
            (length,) = struct.unpack_from("<I", content, 12)
            content = content[20 : 20 + length]
        told = json.loads(content)
        uris = [each.get("uri", "") for each in (*told.get("buffers", ()), *told.get("images", ()))]
        return [uri for uri in uris if uri and not uri.startswith("data:")]
    if path.suffix.lower() != ".obj":
        return []
    materials = _words_after(path, ("mtllib",))
    named = [path.parent / each for each in materials if "://" not in each]
    return materials + [each for file in named if file.is_file() for each in _words_after(file, ("map_Kd",))]


def _words_after(path: Path, keys: tuple[str, ...]) -> list[str]:
    lines = (line.split(maxsplit=1) for line in path.read_text(errors="replace").splitlines())
    return [words[1].split()[-1] for words in lines if len(words) == 2 and words[0] in keys]


def _urdf_parts(path: Path) -> list[trimesh.Trimesh]:
    """Return the visual shapes of a model with all its joints at 0."""
    model = ElementTree.fromstring(path.read_bytes())
    materials = {each.get("name", ""): each for each in model.findall("material")}
    parent = {
        joint.find("child").get("link"): (joint.find("parent").get("link"), _origin(joint))  # type: ignore[union-attr]
        for joint in model.findall("joint")
    }
    parts = []
    for link in model.findall("link"):
        T_root_link, name = np.eye(4), link.get("name")
        for _ in parent:
            if name not in parent:
                break
            name, T_parent_child = parent[name]
            T_root_link = T_parent_child @ T_root_link
        for visual in link.findall("visual"):
            shapes = _urdf_shapes(visual.find("geometry"), path)
            colour = _urdf_colour(visual.find("material"), materials)
            for shape in shapes:
                if colour is not None:
                    shape.visual = trimesh.visual.ColorVisuals(
                        shape, face_colors=np.tile(colour, (len(shape.faces), 1))
                    )
                parts.append(shape.apply_transform(T_root_link @ _origin(visual)))
    return parts


def _origin(element: ElementTree.Element) -> NDArray[np.float64]:
    origin = element.find("origin")
    told: Mapping[str, str] = {} if origin is None else origin.attrib
    roll, pitch, yaw = map(float, told.get("rpy", "0 0 0").split())
    T = trimesh.transformations.euler_matrix(roll, pitch, yaw, "sxyz")
    T[:3, 3] = list(map(float, told.get("xyz", "0 0 0").split()))
    return np.asarray(T)


def _urdf_shapes(geometry: ElementTree.Element | None, path: Path) -> list[trimesh.Trimesh]:
    shape = next(iter(geometry)) if geometry is not None and len(geometry) else None
    if shape is None:
        return []
    told = shape.attrib
    if shape.tag == "mesh":
        file = _urdf_file(told["filename"], path)
        parts = _parts(file)
        for each in parts:
            each.apply_scale(list(map(float, told.get("scale", "1 1 1").split())))
        return parts
    if shape.tag == "box":
        return [trimesh.creation.box(list(map(float, told["size"].split())))]
    if shape.tag == "cylinder":
        return [trimesh.creation.cylinder(float(told["radius"]), float(told["length"]), sections=24)]
    check("mesh", shape.tag == "sphere", "a mesh, box, cylinder or sphere", f"{shape.tag} in {path.name}")
    return [trimesh.creation.icosphere(2, float(told["radius"]))]


def _urdf_file(name: str, path: Path) -> Path:
    """Return the file that a URDF names; that of a package is sought in the folders above."""
    _check_local(name, path)
    inner = name.removeprefix("package://")
    folders = [path.parent, *path.parents] if inner != name else [path.parent]
    found = [folder / tail for folder in folders for tail in (inner, inner.partition("/")[2]) if tail]
    files = [each for each in found if each.is_file()]
    check("mesh", bool(files), f"the file that {path.name} names", repr(name))
    check("mesh", files[0].suffix.lower() in _UP, f"one of {', '.join(_UP)} in {path.name}", repr(name))
    return files[0]


def _urdf_colour(
    material: ElementTree.Element | None, materials: Mapping[str, ElementTree.Element]
) -> NDArray[np.uint8] | None:
    if material is None:
        return None
    colour = material.find("color")
    named = materials.get(material.get("name", ""))
    colour = named.find("color") if colour is None and named is not None else colour
    if colour is None:
        return None
    return np.array([round(255 * float(each)) for each in colour.get("rgba", "0.5 0.5 0.5 1").split()], np.uint8)


@dataclass(frozen=True, eq=False)
class _Part:
    """Faces of one file's part: corners and normals (F, 3, 3), and a picture with uv (F, 3, 2), or colours (F, 3)."""

    corners: NDArray[np.float64]
    normals: NDArray[np.float64]
    picture: _Rgb | None
    uv: NDArray[np.float64]
    colours: _Rgb


def _joined(shapes: list[trimesh.Trimesh]) -> TexturedMesh:
    """Return shapes as one mesh with one texture."""
    parts = [part for part in map(_part, shapes) if len(part.corners)]
    texture, uv = _atlas(parts)
    corners = np.concatenate([part.corners for part in parts]) if parts else np.zeros((0, 3, 3))
    normals = np.concatenate([part.normals for part in parts]) if parts else np.zeros((0, 3, 3))
    rows = np.concatenate([corners, normals, uv], axis=2).reshape(-1, 8).astype(np.float32)
    check("mesh", len(rows) > 0, "triangles with an area", "none")
    rows, faces = np.unique(rows, axis=0, return_inverse=True)
    return TexturedMesh(rows[:, :3], rows[:, 3:6], rows[:, 6:], faces.reshape(-1, 3).astype(np.int32), texture)


def _part(shape: trimesh.Trimesh) -> _Part:
    corners = np.asarray(shape.triangles, dtype=float)
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(area, axis=1)
    kept = doubled > 1e-12
    flat = area[kept] / doubled[kept, None]
    smooth = np.asarray(shape.vertex_normals, dtype=float)[shape.faces[kept]]
    is_round = np.einsum("fkc,fc->fk", smooth, flat) > _SMOOTH_COSINE
    normals = np.where(is_round[..., None], smooth, flat[:, None])
    visual: Any = shape.visual
    picture, factor = _picture_of(visual)
    if picture is not None:
        uv = np.asarray(visual.uv, dtype=float)[shape.faces[kept]] * (1.0, -1.0) + (0.0, 1.0)
        tinted = np.clip(np.round(picture * factor), 0, 255).astype(np.uint8)
        return _Part(corners[kept], normals, tinted, uv, np.empty((0, 3), np.uint8))
    colours = _face_colours(shape)[kept]
    return _Part(corners[kept], normals, None, np.empty((0, 3, 2)), colours)


def _picture_of(visual: Any) -> tuple[_Rgb | None, NDArray[np.float64]]:
    """Return a material's picture (h, w, 3), None if it has none, and the factor of its colours."""
    material = getattr(visual, "material", None)
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if image is None or getattr(visual, "uv", None) is None:
        return None, np.ones(3)
    factor = getattr(material, "baseColorFactor", None)
    tint = np.ones(3) if factor is None else np.asarray(factor, dtype=float)[:3] / 255.0
    return np.asarray(image.convert("RGB")), tint


def _face_colours(shape: trimesh.Trimesh) -> _Rgb:
    visual: Any = shape.visual
    if hasattr(visual, "material"):
        return np.tile(np.asarray(visual.material.main_color, np.uint8)[:3], (len(shape.faces), 1))
    return np.asarray(visual.face_colors, np.uint8)[:, :3]


def _atlas(parts: list[_Part]) -> tuple[Texture, NDArray[np.float64]]:
    """Return one texture of all pictures and colours, and the places (F, 3, 2) of all corners in it."""
    plain = [part.colours for part in parts if part.picture is None]
    colours = np.concatenate(plain) if plain else np.empty((0, 3), np.uint8)
    shades = np.unique(colours, axis=0)
    while len(shades) > _COLOURS:
        # Colours that differ by a little are one.
        colours = colours // 2 * 2 if (colours % 2).any() else (colours // 8 * 8)
        shades = np.unique(colours, axis=0)
    pictures = [_tile(part) for part in parts if part.picture is not None]
    swatch, border = (_SWATCH_PX, _BORDER_PX) if pictures else (4, 0)
    across = math.ceil(math.sqrt(max(len(shades), 1)))
    width = max([picture.shape[1] + 2 * border for picture, _ in pictures] + [across * swatch])
    across = width // swatch
    rows = math.ceil(len(shades) / across)
    height = sum(picture.shape[0] + 2 * border for picture, _ in pictures) + rows * swatch
    canvas = np.zeros((height, width, 3), np.uint8)
    for k, shade in enumerate(shades):
        y, x = (swatch * place for place in divmod(k, across))
        canvas[y : y + swatch, x : x + swatch] = shade
    top, placed, first = rows * swatch, [], 0
    tiles = iter(pictures)
    for part in parts:
        if part.picture is None:
            own = colours[first : first + len(part.colours)]
            first += len(own)
            code = np.array([65536, 256, 1])
            index = np.searchsorted(shades @ code, own @ code)
            middle = (np.stack([index % across, index // across], axis=1) + 0.5) * swatch
            placed.append(np.repeat(middle[:, None], 3, axis=1) / (width, height))
            continue
        picture, uv = next(tiles)
        tall, wide = picture.shape[:2]
        bordered = cv2.copyMakeBorder(picture, border, border, border, border, cv2.BORDER_REPLICATE)
        canvas[top : top + tall + 2 * border, : wide + 2 * border] = bordered
        placed.append((uv * (wide, tall) + (border, top + border)) / (width, height))
        top += tall + 2 * border
    uv = np.concatenate(placed) if placed else np.empty((0, 3, 2))
    return Texture(canvas, smooth=bool(pictures)), np.clip(uv, 0.0, 1.0)


def _tile(part: _Part) -> tuple[_Rgb, NDArray[np.float64]]:
    """Return a part's picture, repeated as often as its faces need it side by side, and uv within it."""
    assert part.picture is not None
    picture = part.picture
    shrink = _LARGEST_PX / max(picture.shape[:2])
    if shrink < 1.0:
        size = tuple(max(round(side * shrink), 1) for side in picture.shape[1::-1])
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    uv = part.uv - np.floor(part.uv.min(axis=1, keepdims=True) + 1e-6)
    repeats = np.clip(np.ceil(uv.max(axis=(0, 1)) - 1e-6), 1, _MOST_REPEATS).astype(int)
    return np.tile(picture, (repeats[1], repeats[0], 1)), np.clip(uv / repeats, 0.0, 1.0)
