"""Train a small network that finds roads on the ground, and let ours use it in place of its rule for colours.

Needs `pip install 'frameout[data,train]'`::

    G="frameout generate road-town --preset quick --set rate_hz=3 --set frame_count=84 --pictures jpeg"
    $G --channels image_rgb semantic_map --seeds 0:80 --out sets/roads
    $G --channels image_rgb semantic_map --seeds 600:608 --out sets/unseen
    python examples/learn_roads.py --data sets/roads --unseen sets/unseen
    frameout bench frame-out --modules examples/learn_roads.py --trackers mosaic_graph_pf learnt_roads \\
        --preset standard --seeds 300:400

The sets take 5 minutes of one core and 0.3 GB, training 14. Roads in the pictures of the eight unseen towns have an IoU
of 0.97 with the true ones. What that is worth to the tracker is in `docs/results/frame-out.md`; the weights (0.8 MB)
are not shipped, as nothing is seen to be won with other drivers.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import torch
import tyro
from numpy.typing import NDArray
from safetensors.torch import load_file, save_file
from torch import Tensor, nn
from torch.nn.functional import binary_cross_entropy_with_logits, interpolate, pad
from torch.utils.data import DataLoader, RandomSampler

from benchmarks.data.sets.data_set import DataSet, Samples
from scenarios.road_town.semantics import CLASSES
from scenarios.scenario import Frame
from trackers import registry
from trackers.kernels.ground_camera import GroundCamera
from trackers.mosaic_graph.map_tracker import MapTracker
from trackers.mosaic_graph.road_network import GRID_M, RoadFinder, SeenGround
from trackers.registry import NoParameters, register
from trackers.types import Estimate, Observation

WEIGHTS = Path(__file__).with_name("learnt_roads.safetensors")
STRIDE = 8
"""The sides of the ground are multiples of it."""

SIDE = 128
"""Cells along each side of a piece of ground to learn from: 64 m."""
NOT_SEEN = CLASSES.index("sky")
ROAD, SURE = CLASSES.index("road"), [CLASSES.index(each) for each in ("road", "ground", "building")]
"""What the ground is below trees and vehicles is learnt from its surroundings."""


def ground_and_road(frame: Frame) -> tuple[Tensor, Tensor]:
    """Return a piece of ground, turned at random, as a mosaic shows it (3, SIDE, SIDE), 0 to 1, and 0 where nothing is
    seen; and of each cell (SIDE, SIDE) whether it is road, 1 or 0, or -1 where that is not said."""
    rng = np.random.default_rng(torch.randint(2**31, (1,)).item())
    camera = GroundCamera(frame.camera, frame.truth.T_world_camera, np.zeros(2))
    corners_px = np.array([frame.camera.width_px, frame.camera.height_px])
    T_map_cells = np.eye(3)
    turn_rad, mirror = rng.uniform(-np.pi, np.pi), rng.choice([-1, 1])
    c, s = GRID_M * np.cos(turn_rad), GRID_M * np.sin(turn_rad)
    T_map_cells[:2, :2] = [[c, -mirror * s], [s, mirror * c]]
    T_map_cells[:2, 2] = camera.to_map(rng.uniform(0.2, 0.8, (1, 2)) * corners_px)[0]
    T_map_cells[:2, 2] -= T_map_cells[:2, :2] @ np.full(2, 0.5 * SIDE)
    # OpenCV's whole numbers are the centres of cells and pixels.
    to_centres = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])
    H = np.linalg.inv(to_centres) @ camera.H_picture_map() @ T_map_cells @ to_centres
    picture = cv2.GaussianBlur(frame.observation.image_rgb, (0, 0), GRID_M / (2.5 * camera.metres_per_pixel()))
    rgb = cv2.warpPerspective(picture, H, (SIDE, SIDE), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    nearest = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
    kinds = cv2.warpPerspective(frame.truth.semantic_map, H, (SIDE, SIDE), flags=nearest, borderValue=NOT_SEEN)
    light = rng.uniform(0.7, 1.3) * rng.uniform(0.93, 1.07, 3)
    goal = np.where(np.isin(kinds, SURE), kinds == ROAD, -1.0)
    return torch.from_numpy(np.clip(rgb * (light / 255), 0, 1)).float().permute(2, 0, 1), torch.from_numpy(goal).float()


class RoadNetwork(nn.Module):
    """Ground (B, 3, H, W) to log-odds of road (B, H, W): a U-Net (Ronneberger et al. 2015) of three scales."""

    def __init__(self) -> None:
        super().__init__()
        plan = (4, 24, 2, 1), (24, 40, 2, 1), (40, 64, 2, 1), (64, 64, 1, 2), (64, 64, 1, 4), (64, 64, 1, 8)
        self.down = nn.ModuleList(_layer(*each) for each in plan)
        self.up = nn.ModuleList((_layer(64 + 40, 40, 1, 1), _layer(40 + 24, 24, 1, 1)))
        self.last = nn.Conv2d(24, 1, 3, 1, 1)

    def forward(self, ground: Tensor) -> Tensor:
        """The fourth channel tells which cells are seen."""
        out, levels = torch.cat([ground - 0.5, (ground.sum(1, keepdim=True) > 0).float()], 1), []
        for layer in self.down:
            levels.append(out := layer(out))
        for layer, beside in zip(self.up, (levels[1], levels[0]), strict=True):
            out = layer(torch.cat([interpolate(out, scale_factor=2, mode="bilinear"), beside], 1))
        return interpolate(self.last(out), scale_factor=2, mode="bilinear")[:, 0]


def _layer(come: int, leave: int, stride: int, gap: int) -> nn.Sequential:
    return nn.Sequential(nn.Conv2d(come, leave, 3, stride, gap, gap), nn.GroupNorm(8, leave), nn.ReLU())


def train(data: Samples, steps: int, seed: int) -> tuple[RoadNetwork, list[float]]:
    """Return a network trained on batches of 8 pieces of ground, and the loss of each."""
    torch.manual_seed(seed)
    model, losses = RoadNetwork(), []
    adam = torch.optim.AdamW(model.parameters())
    rate = torch.optim.lr_scheduler.OneCycleLR(adam, 3e-3, steps)
    for ground, goal in DataLoader(data, 8, sampler=RandomSampler(data, num_samples=8 * steps)):  # type: ignore
        adam.zero_grad()
        loss = binary_cross_entropy_with_logits(model(ground), goal, weight=(goal >= 0).float())
        loss.backward()
        adam.step()
        rate.step()
        losses.append(loss.item())
    return model, losses


@torch.no_grad()
def overlap(model: RoadNetwork, data: Samples) -> float:
    """Return the intersection over union of the roads that it finds in pieces of ground with the true ones."""
    both = either = 0
    for ground, goal in DataLoader(data, 8):  # type: ignore
        found, road = (model(ground) > 0) & (goal >= 0), goal == 1
        both, either = both + int((found & road).sum()), either + int((found | road).sum())
    return both / either


class LearntRoads(RoadFinder):
    """Finds roads by the network."""

    def __init__(self, weights: Path) -> None:
        self._network = RoadNetwork().eval()
        self._network.load_state_dict(load_file(weights))

    @torch.no_grad()
    def probability(self, ground: SeenGround) -> NDArray[np.float32]:
        """See ``RoadFinder``."""
        height, width = ground.seen.shape
        rgb = torch.from_numpy(ground.rgb * ground.seen[..., None]).permute(2, 0, 1)[None].float() / 255
        odds = self._network(pad(rgb, (0, -width % STRIDE, 0, -height % STRIDE)))[0, :height, :width]
        return odds.sigmoid().numpy()


@register("learnt_roads", role="variant", summary="ours, with roads found by the network")
class LearntRoadsTracker:
    """``mosaic_graph_pf`` on a map whose roads the network finds."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._rng = rng
        torch.set_num_threads(1)

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the target in a box (4,)."""
        ours = registry.entry("mosaic_graph_pf").parameters()
        self._tracker = MapTracker(ours, self._rng, observation, box_xyxy, LearntRoads(WEIGHTS))

    def update(self, observation: Observation) -> Estimate:
        """Take in the next picture."""
        return self._tracker.update(observation)


def main(data: str, weights: Path = WEIGHTS, unseen: str = "", steps: int = 1000, seed: int = 0) -> None:
    """Train on the data set ``data``, write the ``weights``, and print the overlap on ``unseen``."""
    model, losses = train(DataSet(data).samples(ground_and_road), steps, seed)
    save_file(model.state_dict(), weights)
    print(f"loss {np.mean(losses[-100:]):.3f}, {weights.stat().st_size / 1e6:.2f} MB")
    if unseen:
        print(f"IoU {overlap(model, DataSet(unseen).samples(ground_and_road)):.3f}")


if __name__ == "__main__":
    tyro.cli(main)
