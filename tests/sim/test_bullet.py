"""PyBullet holds the poses that were given, draws what was added, and is let go."""

from __future__ import annotations

import gc
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sim import bullet
from sim.bullet import TinyRenderer, to_bullet
from sim.mesh import Texture, TexturedMesh
from sim.optics import look_down_pose
from sim.world import World
from tests.sim.squares import block, square
from trackers.types import CameraModel

CAMERA = CameraModel.from_field_of_view(160, 120, 1.0)
DOWN = look_down_pose(np.array([0, 0, 30.0]), 0, 0, 0)


def at(x_m: float, y_m: float, z_m: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = x_m, y_m, z_m
    return T


def connections() -> int:
    pybullet = pytest.importorskip("pybullet")
    return sum(pybullet.isConnected(number) for number in range(64))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**31))
def test_quaternion_is_scipys(seed):
    rotation = Rotation.random(rng=np.random.default_rng(seed))
    T = np.eye(4)
    T[:3, :3] = rotation.as_matrix()
    _, quaternion = to_bullet(T)
    assert abs(np.dot(quaternion, rotation.as_quat())) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1]])
def test_quaternion_of_half_turns(axis):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(np.pi * np.array(axis)).as_matrix()
    assert abs(np.dot(to_bullet(T)[1][:3], axis)) == pytest.approx(1.0)


@pytest.mark.heavy
def test_without_pybullet_the_error_says_how_to_install_it():
    blocked = "import sys; sys.modules['pybullet'] = None\nfrom sim.bullet import client\nfrom sim.world import World\n"
    done = subprocess.run([sys.executable, "-c", f"{blocked}client(World())"], capture_output=True, text=True)
    assert "pybullet: expected to be installed, for --renderer pybullet and sim.bullet alone" in done.stderr
    assert "pip install pybullet" in done.stderr


def test_moved_body_is_drawn_where_it_is():
    pytest.importorskip("pybullet")
    world = World()
    world.add(square(40, (10, 200, 30)), np.eye(4), name="lawn", category="ground")
    car = world.add(square(4, (250, 0, 0)), np.eye(4), name="car", category="vehicle", movable=True)
    reference = TinyRenderer(world)
    for x_m, y_m in ((0.0, 0.0), (6.0, -3.0)):
        world.move(car, at(x_m, y_m, 1.0))
        rgb, _, index = reference.camera_image(CAMERA, DOWN, near_m=1, far_m=100)
        rows, columns = np.nonzero(index == car.index)
        # Ahead is up; left is left, 29 m below. Corners of pixels are sampled.
        assert rows.mean() == pytest.approx(60 - x_m * CAMERA.focal_px / 29, abs=1.3)
        assert columns.mean() == pytest.approx(80 - y_m * CAMERA.focal_px / 29, abs=1.3)
        assert (rgb[rows, columns] == (250, 0, 0)).all()
        assert (rgb[index == 0] == (10, 200, 30)).all()


def test_shapes_of_several_sizes_keep_their_own_points():
    pytest.importorskip("pybullet")
    world = World()
    small = world.add(square(2, (9, 9, 9)), np.eye(4), name="small", category="kerb")
    big = world.add(square(40, (90, 9, 9)), at(0, 0, -1), name="big", category="ground")
    last = world.add(square(2, (9, 90, 9)), at(8, 0, 0), name="last", category="kerb")
    _, _, index = TinyRenderer(world).camera_image(CAMERA, DOWN, near_m=1, far_m=100)
    pixels_per_m = CAMERA.focal_px / 30
    for body in (small, last):
        assert (index == body.index).sum() == pytest.approx((2 * pixels_per_m) ** 2, rel=0.25)
    assert (index == big.index).sum() > 0.9 * index.size


def test_pictures_that_come_as_tuples_are_the_same():
    """PyBullet built without NumPy, as the fork ``pybullet-arm64``, returns tuples of numbers."""
    pytest.importorskip("pybullet")
    world = World()
    world.add(square(20, (10, 200, 30)), np.eye(4), name="lawn", category="ground")
    reference = TinyRenderer(world)
    arrays = reference.camera_image(CAMERA, DOWN, near_m=1, far_m=100)
    draw = reference._engine.getCameraImage
    reference._engine.getCameraImage = lambda *a, **k: [
        tuple(np.ravel(each).tolist()) if np.ndim(each) else each for each in draw(*a, **k)
    ]
    for one, other in zip(arrays, reference.camera_image(CAMERA, DOWN, near_m=1, far_m=100), strict=True):
        np.testing.assert_array_equal(one, other)
        assert one.dtype == other.dtype


@pytest.mark.heavy
def test_worlds_that_come_and_go_leave_no_lists_behind():
    pytest.importorskip("pybullet")
    count = 3000
    strip = TexturedMesh(
        np.random.default_rng(4).normal(size=(count, 3)).astype(np.float32),
        np.tile(np.array([0, 0, 1], dtype=np.float32), (count, 1)),
        np.zeros((count, 2), dtype=np.float32),
        np.arange(count, dtype=np.int32).reshape(-1, 3),
        Texture(np.zeros((4, 4, 3), dtype=np.uint8)),
    )

    def live() -> int:
        world = World()
        world.add(strip, np.eye(4), name="strip", category="kerb")
        TinyRenderer(world).hand_over()
        gc.collect()
        return sys.getallocatedblocks()

    live()
    before = live()
    for _ in range(4):
        after = live()
    assert after - before < 0.1 * count


def test_each_thread_lends_pybullet_lists_of_its_own():
    points = np.eye(3)
    lent = bullet._VERTICES.holding(points)
    with ThreadPoolExecutor(1) as other:
        other.submit(bullet._VERTICES.holding, 2.0 * points).result()
    np.testing.assert_array_equal(lent, points)


def test_clients_and_renderers_that_are_dropped_leave_no_connection():
    before = connections()
    world = World()
    world.add(block((1, 1, 1)), np.eye(4), name="x", category="kerb")
    for _ in range(40):
        TinyRenderer(world).hand_over()
        bullet.client(world)
    with bullet.client(world):
        assert connections() == before + 1
    assert connections() == before


def yard() -> World:
    """Return a floor with a wall across x = 5, and a crate that may move, behind it."""
    world = World()
    world.add(square(40, (90, 90, 90)), np.eye(4), name="floor", category="ground")
    world.add(block((0.2, 10, 3)), at(5, 0, 0), name="wall", category="building")
    world.add(block((1, 1, 1)), at(8, 0, 0), name="crate", category="vehicle", movable=True)
    return world


def test_rays_hit_the_bodies_where_the_world_has_them():
    pytest.importorskip("pybullet")
    world = yard()
    with bullet.client(world) as client:
        (hit,) = client.engine.rayTest([0, 0, 0.5], [20, 0, 0.5])
        assert client.handles.index(hit[0]) == 1
        assert hit[3][0] == pytest.approx(4.9)
        world.move(world.bodies[2], at(2, 0, 0))
        client.push()
        (hit,) = client.engine.rayTest([0, 0, 0.5], [20, 0, 0.5])
        assert client.handles.index(hit[0]) == 2
        assert hit[3][0] == pytest.approx(1.5, abs=0.01)


def test_held_bodies_stay_and_released_ones_fall_by_their_mass():
    pytest.importorskip("pybullet")
    world = yard()
    crate = world.bodies[2]
    world.move(crate, at(8, 0, 3))
    with bullet.client(world) as client:
        assert client.engine.getDynamicsInfo(client.handles[crate.index], -1)[0] == pytest.approx(bullet.DENSITY_KGPM3)
        assert client.engine.getDynamicsInfo(client.handles[1], -1)[0] == 0.0
        for _ in range(240):
            client.engine.stepSimulation()
        position, _ = client.engine.getBasePositionAndOrientation(client.handles[crate.index])
        assert position[2] == pytest.approx(3.5, abs=0.02)
        client.release(crate)
        for _ in range(480):
            client.engine.stepSimulation()
        client.pull()
    assert world.poses[crate.index][2, 3] == pytest.approx(0.0, abs=0.03)
    with pytest.raises(ValueError, match="body: expected one that a joint holds, got 'wall'"):
        client.release(world.bodies[1])


def test_a_users_body_is_stopped_by_a_wall_and_shown_where_it_is():
    pytest.importorskip("pybullet")
    world = yard()
    with bullet.client(world) as client:
        engine = client.engine
        shape = engine.createCollisionShape(engine.GEOM_SPHERE, radius=0.5)
        looks = engine.createVisualShape(engine.GEOM_SPHERE, radius=0.5, rgbaColor=(0, 1, 0, 1))
        ball = engine.createMultiBody(2.0, shape, looks, [0, 0, 0.5])
        (shown,) = client.show(ball, "ball")
        assert (shown.name, shown.movable) == ("ball 0", True)
        assert (shown.mesh.texture.rgb == (0, 255, 0)).all()
        np.testing.assert_allclose(shown.mesh.size_m, 1.0, atol=0.01)
        furthest_m = 0.0
        engine.resetBaseVelocity(ball, [6, 0, 0])
        for _ in range(720):
            engine.stepSimulation()
            client.pull()
            furthest_m = max(furthest_m, world.poses[shown.index][0, 3])
    assert 4.2 < furthest_m < 4.5
