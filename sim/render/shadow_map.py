"""Shadow maps: height towards the sun of the highest surface, drawn by the rasteriser's own kernels.

A map covers a square *region* of the plane perpendicular to the sun. Regions come from a fixed lattice (sides in powers
of sqrt 2, centres a sixth of a side apart). So the region of a view does not depend on earlier views, and neighbouring
views mostly share one: its fixed bodies are drawn once and kept. A view needs a part of its region only, so tiles are
drawn when they are first needed.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.render.scene import SceneArrays, pack_shapes
from sim.render.triangles import project_body, row_span, set_up_triangle
from sim.world import World

BLOCK = 16
"""Side of the blocks of texels whose greatest height is kept; a power of two, as the shader requires."""
TILE = 2 * BLOCK
"""Side of the tiles of texels, each drawn when it is first needed."""
NOTHING = np.float32(-1e30)
"""Height in a texel without a caster."""


class MapArrays(NamedTuple):
    """A map of N x N texels, drawn in part.

    Attributes:
        fixed_m: (N, N) float32 heights of what never moves.
        height_m: (N, N) float32 heights of all.
        highest_m: (N / BLOCK, N / BLOCK) float32, the greatest height in each block of texels and the first row and
            column of the next ones.
        drawn: (n, n) bool, the tiles in which ``fixed_m`` is valid; the last ones may be cut.
        complete: (n, n) bool, those in which the others are valid, too.
        changed: (M, 4) boxes that movers cover.
        poses_drawn: (M, 4, 4) of the movers.
    """

    fixed_m: NDArray[np.float32]
    height_m: NDArray[np.float32]
    highest_m: NDArray[np.float32]
    drawn: NDArray[np.bool_]
    complete: NDArray[np.bool_]
    changed: NDArray[np.int64]
    poses_drawn: NDArray[np.float64]


def new_map(size: int, mover_count: int) -> MapArrays:
    """Return a map of ``size`` x ``size`` texels in which nothing is drawn."""
    tiles, blocks = -(-size // TILE), size // BLOCK
    # Memory of zeros is allocated at the first write: most of a map never is written.
    return MapArrays(
        np.zeros((size, size), np.float32),
        np.zeros((size, size), np.float32),
        np.zeros((blocks, blocks), np.float32),
        np.zeros((tiles, tiles), np.bool_),
        np.zeros((tiles, tiles), np.bool_),
        np.zeros((mover_count, 4), np.int64),
        np.zeros((mover_count, 4, 4)),
    )


def forget(drawn_map: MapArrays) -> None:
    """Reset a map."""
    drawn_map.drawn[:], drawn_map.complete[:], drawn_map.changed[:] = False, False, 0


@njit(cache=True)
def new_tiles(wanted: NDArray[np.bool_], drawn: NDArray[np.bool_], new: NDArray[np.bool_]) -> bool:
    """Set the tiles to draw: if one is missing, also the neighbours of the wanted ones, which are needed soon."""
    tiles = wanted.shape[0]
    missing = False
    for i in range(tiles):
        for j in range(tiles):
            missing |= wanted[i, j] and not drawn[i, j]
    if not missing:
        return False
    for i in range(tiles):
        for j in range(tiles):
            if wanted[i, j]:
                for row in range(max(i - 1, 0), min(i + 2, tiles)):
                    for column in range(max(j - 1, 0), min(j + 2, tiles)):
                        new[row, column] = not drawn[row, column]
    return True


@njit(cache=True)
def span_tiles(tiles: NDArray[np.bool_], size: int, spans: NDArray[np.int64]) -> None:
    """Write the first and the last but one column of texels (n, 2) of what is set in each row of tiles."""
    for i in range(tiles.shape[0]):
        spans[i, 0], spans[i, 1] = size, 0
        for j in range(tiles.shape[1]):
            if tiles[i, j]:
                spans[i, 0] = min(spans[i, 0], j * TILE)
                spans[i, 1] = min(j * TILE + TILE, size)


@njit(cache=True)
def fill_tiles(tiles: NDArray[np.bool_], height_m: NDArray[np.float32]) -> None:
    for i in range(tiles.shape[0]):
        for j in range(tiles.shape[1]):
            if tiles[i, j]:
                height_m[i * TILE : (i + 1) * TILE, j * TILE : (j + 1) * TILE] = NOTHING


@njit(cache=True)
def copy_tiles(
    tiles: NDArray[np.bool_], fixed_m: NDArray[np.float32], height_m: NDArray[np.float32], stale: NDArray[np.bool_]
) -> None:
    size = height_m.shape[0]
    box = np.empty(4, np.int64)
    for i in range(tiles.shape[0]):
        for j in range(tiles.shape[1]):
            if tiles[i, j]:
                box[0], box[1] = i * TILE, min(i * TILE + TILE, size)
                box[2], box[3] = j * TILE, min(j * TILE + TILE, size)
                height_m[box[0] : box[1], box[2] : box[3]] = fixed_m[box[0] : box[1], box[2] : box[3]]
                mark_blocks(box, stale)


@njit(cache=True)
def mark_blocks(changed: NDArray[np.int64], stale: NDArray[np.bool_]) -> None:
    """Set the blocks with texels in a box of rows and columns.

    A block ends with the first row and column of the next, so that it holds all of the 2x2 texels that begin in it.
    """
    if changed[0] >= changed[1] or changed[2] >= changed[3]:
        return
    for block_row in range(max(changed[0] - 1, 0) // BLOCK, (changed[1] - 1) // BLOCK + 1):
        for block_column in range(max(changed[2] - 1, 0) // BLOCK, (changed[3] - 1) // BLOCK + 1):
            stale[block_row, block_column] = True


@njit(cache=True, fastmath={"nnan", "nsz", "reassoc"})
def find_highest(height_m: NDArray[np.float32], stale: NDArray[np.bool_], highest_m: NDArray[np.float32]) -> None:
    """Write the greatest height of each block that is stale."""
    size = height_m.shape[0]
    for block_row in range(stale.shape[0]):
        for block_column in range(stale.shape[1]):
            if not stale[block_row, block_column]:
                continue
            first_row, first_column = block_row * BLOCK, block_column * BLOCK
            highest = NOTHING
            for row in range(first_row, min(first_row + BLOCK + 1, size)):
                line = height_m[row, first_column : min(first_column + BLOCK + 1, size)]
                for k in range(line.shape[0]):
                    highest = max(highest, line[k])
            highest_m[block_row, block_column] = highest


_SQUARE_PX = 8
"""Side of the squares of pixels whose texels are found together."""
_MARGIN = 2.0
"""Texels; the shader also reads the next one, and computes with single precision."""


@njit(cache=True)
def bounds_across(
    depth_m: NDArray[np.float32],
    step_px: int,
    reach_m: float,
    from_pixel: NDArray[np.float64],
    low_m: NDArray[np.float64],
    high_m: NDArray[np.float64],
) -> None:
    """Write the bounds (2,), perpendicular to the light, of the surfaces nearer than ``reach_m``.

    Args:
        depth_m: (H, W) of every ``step_px``-th pixel of every ``step_px``-th row.
        from_pixel: (2, 4): ``depth * from_pixel[:, :3] @ (x, y, 1) + from_pixel[:, 3]`` is the place, perpendicular to
            the light, of the surface at pixel (x, y).
        low_m, high_m: written; not finite if nothing is near enough.
    """
    low_m[:], high_m[:] = np.inf, -np.inf
    for row in range(depth_m.shape[0]):
        for column in range(depth_m.shape[1]):
            depth = depth_m[row, column]
            if depth >= reach_m:
                continue
            for axis in range(2):
                line = from_pixel[axis]
                across_m = depth * (line[0] * (column * step_px) + line[1] * (row * step_px) + line[2]) + line[3]
                low_m[axis], high_m[axis] = min(low_m[axis], across_m), max(high_m[axis], across_m)


@njit(cache=True)
def find_tiles(depth_m: NDArray[np.float32], from_pixel: NDArray[np.float64], wanted: NDArray[np.bool_]) -> None:
    """Set the tiles (n, n) of a map that the shading of a picture looks up, and some around them.

    A square of pixels that lie between two depths looks up no texel beyond the four products of the least and greatest
    depth with the least and greatest ray.

    Args:
        depth_m: (H, W).
        from_pixel: (2, 4): ``depth * from_pixel[:, :3] @ (x, y, 1) + from_pixel[:, 3]`` is the map's column and row of
            the surface at pixel coordinates (x, y).
    """
    wanted[:] = False
    bounds = np.empty((2, 2), np.int64)
    for first_row in range(0, depth_m.shape[0], _SQUARE_PX):
        last_row = min(first_row + _SQUARE_PX, depth_m.shape[0]) - 1
        for first_column in range(0, depth_m.shape[1], _SQUARE_PX):
            last_column = min(first_column + _SQUARE_PX, depth_m.shape[1]) - 1
            nearest, farthest = np.inf, 0.0
            for row in range(first_row, last_row + 1):
                for column in range(first_column, last_column + 1):
                    depth = depth_m[row, column]
                    # Where nothing is there is no shadow.
                    if depth < np.inf:
                        nearest, farthest = min(nearest, depth), max(farthest, depth)
            if nearest > farthest:
                continue
            for axis in range(2):
                line = from_pixel[axis]
                ray = line[0] * (first_column + 0.5) + line[1] * (first_row + 0.5) + line[2]
                along, down = line[0] * (last_column - first_column), line[1] * (last_row - first_row)
                least, greatest = ray + min(along, 0.0) + min(down, 0.0), ray + max(along, 0.0) + max(down, 0.0)
                low = min(least * nearest, least * farthest) + line[3] - _MARGIN
                high = max(greatest * nearest, greatest * farthest) + line[3] + _MARGIN
                end = wanted.shape[0] * TILE - 1.0
                bounds[axis, 0] = int(min(max(low, 0.0), end)) // TILE
                bounds[axis, 1] = int(min(max(high, 0.0), end)) // TILE
            wanted[bounds[1, 0] : bounds[1, 1] + 1, bounds[0, 0] : bounds[0, 1] + 1] = True


@njit(cache=True)
def draw_tiles(
    scene: SceneArrays,
    poses: NDArray[np.float64],
    light_view: NDArray[np.float64],
    fixed: NDArray[np.int64],
    movers: NDArray[np.int64],
    projected: NDArray[np.float64],
    wanted: NDArray[np.bool_],
    map_so_far: MapArrays,
) -> None:
    """Draw the missing tiles of a map among the wanted ones, and update the movers' shadows.

    Args:
        poses: (B, 4, 4) of all bodies.
        fixed, movers: indices of the bodies that cast shadows.
        projected: scratch for the vertices of the largest body.
        wanted: (n, n) tiles.
    """
    drawn, fixed_m, height_m = map_so_far.drawn, map_so_far.fixed_m, map_so_far.height_m
    new, stale = np.zeros_like(drawn), np.zeros(map_so_far.highest_m.shape, np.bool_)
    has_new = new_tiles(wanted, drawn, new)
    have_moved = has_new or _any_beyond(wanted, map_so_far.complete)
    for n in range(movers.shape[0]):
        have_moved |= _differ(poses[movers[n]], map_so_far.poses_drawn[n])
    if not have_moved:
        return
    spans = np.empty((drawn.shape[0], 2), np.int64)
    box = np.empty(4, np.int64)
    if has_new:
        span_tiles(new, height_m.shape[0], spans)
        fill_tiles(new, fixed_m)
        for n in range(fixed.shape[0]):
            _draw_body(scene, poses[fixed[n]], light_view, fixed[n], projected, spans, fixed_m, box)
        copy_tiles(new, fixed_m, height_m, stale)
        drawn |= new
    changed = map_so_far.changed
    for n in range(movers.shape[0]):
        mark_blocks(changed[n], stale)
        for row in range(changed[n, 0], changed[n, 1]):
            for column in range(changed[n, 2], changed[n, 3]):
                height_m[row, column] = fixed_m[row, column]
    # Movers come into few of the tiles that were drawn so far.
    span_tiles(wanted, height_m.shape[0], spans)
    for n in range(movers.shape[0]):
        pose = poses[movers[n]]
        _draw_body(scene, pose, light_view, movers[n], projected, spans, height_m, changed[n])
        mark_blocks(changed[n], stale)
        map_so_far.poses_drawn[n] = pose
    find_highest(height_m, stale, map_so_far.highest_m)
    map_so_far.complete[:] = wanted


@njit(cache=True)
def _any_beyond(some: NDArray[np.bool_], others: NDArray[np.bool_]) -> bool:
    """Return whether any of some tiles is not among others."""
    for i in range(some.shape[0]):
        for j in range(some.shape[1]):
            if some[i, j] and not others[i, j]:
                return True
    return False


@njit(cache=True)
def _differ(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            if a[i, j] != b[i, j]:
                return True
    return False


@njit(cache=True)
def _may_reach(
    light_view: NDArray[np.float64],
    pose: NDArray[np.float64],
    centre_m: NDArray[np.float64],
    radius_m: float,
    spans: NDArray[np.int64],
) -> bool:
    """Return False if a body's bounding sphere surely lies outside the spans."""
    column, row, scale = light_view[0, 3], light_view[1, 3], 0.0
    for k in range(3):
        place_m = pose[k, 3]
        for j in range(3):
            place_m += pose[k, j] * centre_m[j]
        column += light_view[0, k] * place_m
        row += light_view[1, k] * place_m
        scale += light_view[0, k] * light_view[0, k]
    reach = radius_m * np.sqrt(scale) + 1.0
    end = spans.shape[0] * TILE - 1.0
    if row + reach < 0.0 or row - reach > end:
        return False
    for i in range(int(max(row - reach, 0.0)) // TILE, int(min(row + reach, end)) // TILE + 1):
        if spans[i, 0] < column + reach and column - reach < spans[i, 1]:
            return True
    return False


@njit(cache=True)
def _draw_body(
    scene: SceneArrays,
    pose: NDArray[np.float64],
    light_view: NDArray[np.float64],
    body: int,
    projected: NDArray[np.float64],
    spans: NDArray[np.int64],
    height_m: NDArray[np.float32],
    changed: NDArray[np.int64],
) -> None:
    """Raise ``height_m`` within the spans to the body's faces that look to the sun; ``changed`` is set to the rows and
    columns (first, after the last, first, after the last) that may have changed. The outermost texels are left out.
    """
    size = height_m.shape[0]
    changed[0], changed[1], changed[2], changed[3] = size, 0, size, 0
    if not _may_reach(light_view, pose, scene.centre_m[body], scene.radius_m[body], spans):
        return
    start = scene.first_vertex[body]
    project_body(light_view, pose, scene.vertices_m[start : scene.first_vertex[body + 1]], projected)
    edges, weights = np.empty((4, 3)), np.empty((3, 3))
    plane = np.empty(3)
    for face in range(scene.first_face[body], scene.first_face[body + 1]):
        a, b, c = scene.faces[face, 0] - start, scene.faces[face, 1] - start, scene.faces[face, 2] - start
        # Most faces lie between two rows of texels.
        rows = projected[a, 1], projected[b, 1], projected[c, 1]
        if np.ceil(min(rows)) > max(rows):
            continue
        first, last, edge_count = set_up_triangle(projected, a, b, c, 0.0, size, edges, weights)
        if first >= last:
            continue
        for k in range(3):
            plane[k] = (
                projected[a, 3] * weights[0, k] + projected[b, 3] * weights[1, k] + projected[c, 3] * weights[2, k]
            )
        for row in range(max(first, 1), min(last, size - 1)):
            span_left, span_right = spans[row // TILE, 0], spans[row // TILE, 1]
            if span_left >= span_right:
                continue
            left, right = row_span(edges, edge_count, row, size)
            left, right = max(left, span_left, 1), min(right, span_right, size - 1)
            if left >= right:
                continue
            changed[0], changed[1] = min(changed[0], row), max(changed[1], row + 1)
            changed[2], changed[3] = min(changed[2], left), max(changed[3], right)
            _raise_span(plane[1] * row + plane[2], plane[0], np.uint64(left), np.uint64(right), height_m[row])


@njit(cache=True, forceinline=True)
def _raise_span(
    base: float, per_column: float, first: np.uint64, last: np.uint64, height_m: NDArray[np.float32]
) -> None:
    """Raise heights to ``base + per_column * column``, in a form that becomes vector code."""
    for column in range(first, last):
        value, old = np.float32(base + per_column * np.int32(column)), height_m[column]
        height_m[column] = value if value > old else old


_CENTRES_PER_SIDE = 6
_REGIONS_KEPT = 3
"""Regions kept, of eight megabytes each. A flight over a town draws a tenth of its regions twice; with six, few."""


@dataclass(frozen=True, slots=True)
class ShadowMap:
    """Heights of shadow casters.

    Attributes:
        height_m: (N, N) float32 along the direction towards the sun; ``NOTHING`` where there is no caster, and in
            the outermost texels. Valid until the next map is made, as is the next array.
        highest_m: (N / BLOCK, N / BLOCK) float32, the greatest height in each block of texels and the first row and
            column of the next ones: surfaces at least as high are lit.
        light_view: (4, 4) from the world to ``(column, row, 1, height)``.
        texel_m: side of a texel.
    """

    height_m: NDArray[np.float32]
    highest_m: NDArray[np.float32]
    light_view: NDArray[np.float64]
    texel_m: float


def light_axes(sun_direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rows (3, 3): right, down and towards the sun; seen from the sun, x is right and y down."""
    towards = sun_direction / np.linalg.norm(sun_direction)
    aside = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(aside, towards)
    right /= np.linalg.norm(right)
    # Forward, away from the sun, is right x down.
    return np.stack([right, np.cross(-towards, right), towards])


@dataclass(frozen=True, eq=False)
class Region:
    """A region that is kept.

    Attributes:
        light_view, texel_m: see ``ShadowMap``.
        in_map: (3, 4), the rows of ``light_view`` for column, row and height.
        arrays: its map.
    """

    light_view: NDArray[np.float64]
    in_map: NDArray[np.float64]
    texel_m: float
    arrays: MapArrays


class ShadowCaster:
    """Draws shadow maps of a world. Bodies of category ``ground`` receive shadows and cast none.

    Attributes:
        axes: see ``light_axes``.
    """

    def __init__(
        self,
        world: World,
        sun_direction: NDArray[np.float64],
        size: int = 1024,
        *,
        casting: Literal["all", "movers", "fixed"] = "all",
    ) -> None:
        """Set the bodies to draw.

        Args:
            size: side of a map in texels, a multiple of ``BLOCK``.
            casting: the bodies that cast a shadow: those that may move, those that never do, or all.
        """
        if size < BLOCK or size % BLOCK:
            raise ValueError(f"size: expected a positive multiple of {BLOCK}, got {size}")
        self._world = world
        self.axes = light_axes(np.asarray(sun_direction, dtype=float))
        self._size = size
        self._casting = casting
        self._body_count = -1
        self._kept: OrderedDict[tuple[int, int, int], Region] = OrderedDict()

    def turn(self, sun_direction: NDArray[np.float64]) -> None:
        """Let the sun stand elsewhere; regions and maps so far are invalid."""
        self.axes = light_axes(np.asarray(sun_direction, dtype=float))
        self._kept.clear()

    def region(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> Region:
        """Return the region around two corners, with the tiles drawn so far.

        Args:
            low_m, high_m: (2,) along the first two of ``axes``.
        """
        self._pack()
        key = self._key(low_m, high_m)
        if key not in self._kept:
            self._kept[key] = self._new_region(key)
        self._kept.move_to_end(key)
        return self._kept[key]

    def draw(self, region: Region, wanted: NDArray[np.bool_]) -> ShadowMap:
        """Return the map of the latest region, with all bodies at their present poses.

        Args:
            wanted: (n, n) tiles to look up, see ``find_tiles``; the map is valid in these only.
        """
        arrays, view, movers = region.arrays, region.light_view, self._movers
        draw_tiles(self._scene, self._world.poses, view, self._fixed, movers, self._projected, wanted, arrays)
        return ShadowMap(arrays.height_m, arrays.highest_m, view, region.texel_m)

    def _key(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> tuple[int, int, int]:
        # The lattice may miss the middle by half a step on either side; the outermost texels are empty.
        usable = 1.0 - 1.0 / _CENTRES_PER_SIDE - 4.0 / self._size
        # In plain floats: arrays of so few numbers take five times as long, for every picture.
        (low_x, low_y), (high_x, high_y) = low_m.tolist(), high_m.tolist()
        needed_m = max(high_x - low_x, high_y - low_y, 1.0) / usable
        level = int(np.ceil(2.0 * np.log2(needed_m)))
        step_m = _side_m(level) / _CENTRES_PER_SIDE
        return level, round(0.5 * (low_x + high_x) / step_m), round(0.5 * (low_y + high_y) / step_m)

    def _light_view(self, key: tuple[int, int, int], texel_m: float) -> NDArray[np.float64]:
        step_m = _side_m(key[0]) / _CENTRES_PER_SIDE
        view = np.zeros((4, 4))
        view[:2, :3] = self.axes[:2] / texel_m
        view[:2, 3] = 0.5 * self._size - np.array(key[1:]) * step_m / texel_m
        view[2, 3] = 1.0
        view[3, :3] = self.axes[2]
        return view

    def _new_region(self, key: tuple[int, int, int]) -> Region:
        texel_m = _side_m(key[0]) / self._size
        if len(self._kept) >= _REGIONS_KEPT:
            arrays = self._kept.popitem(last=False)[1].arrays
            forget(arrays)
        else:
            arrays = new_map(self._size, len(self._movers))
        light_view = self._light_view(key, texel_m)
        return Region(light_view, light_view[[0, 1, 3]], texel_m, arrays)

    def _pack(self) -> None:
        if self._body_count == len(self._world.bodies):
            return
        bodies = self._world.bodies
        casts = [body for body in bodies if body.category != "ground"]
        self._scene: SceneArrays = pack_shapes(self._world)
        self._movers, self._fixed = (
            np.array([body.index for body in casts if body.movable is moves and self._casting in kinds], dtype=np.int64)
            for moves, kinds in ((True, ("all", "movers")), (False, ("all", "fixed")))
        )
        self._projected = np.empty((int(np.diff(self._scene.first_vertex).max(initial=0)), 4))
        self._kept.clear()
        self._body_count = len(bodies)


def _side_m(level: int) -> float:
    return float(2.0 ** (0.5 * level))
