"""Train a small detector of cars on a data set, and print its AP at an IoU of 0.5 on towns that it has not seen.

Needs `pip install 'frameout[data,train]'`. After 12 towns in any weather AP is 0.69; on real cars see `real_stills`::

    frameout generate --config examples/towns.yaml --out sets
    python examples/train_detector.py --data sets/next --unseen sets/unseen --steps 400
"""

from __future__ import annotations

import numpy as np
import torch
import tyro
from detections import average_precision, cars_seen
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn.functional import logsigmoid, max_pool2d
from torch.utils.data import DataLoader, RandomSampler

from benchmarks.data.sets.data_set import DataSet, Samples
from scenarios.scenario import Frame

CELL_PX = 4


def picture_of(image_rgb: NDArray[np.uint8]) -> Tensor:
    """Return a picture (H, W, 3) as the network sees it: (3, H, W), -1 to 1."""
    return torch.tensor(image_rgb).permute(2, 0, 1) / 128 - 1


def picture_and_goals(frame: Frame) -> tuple[Tensor, Tensor]:
    """Return the picture, and for each cell (6, H / 4, W / 4): 1 where a car's centre is if it counts, how near the
    nearest car's centre is (1 to 0), and the logarithms of the distances in pixels to the edges of its box."""
    picture, boxes = picture_of(frame.observation.image_rgb), torch.from_numpy(cars_seen(frame)).float()
    rows, columns = (torch.arange(length // CELL_PX) for length in picture.shape[1:])
    if len(boxes) == 0:
        return picture, torch.zeros(6, len(rows), len(columns))
    cells = (torch.stack(torch.meshgrid(columns, rows, indexing="xy"), -1) + 0.5) * CELL_PX
    low, high = boxes[:, None, None, :2], boxes[:, None, None, 2:4]
    centre = (((low + high) / 2 / CELL_PX).floor() + 0.5) * CELL_PX
    near, car = (-18 * ((cells - centre) / (high - low)).square().sum(-1)).exp().max(0)
    edges = torch.cat([cells - boxes[car, :2], boxes[car, 2:4] - cells], -1).clamp(min=1).log().permute(2, 0, 1)
    return picture, torch.cat([((near == 1) * boxes[car, 4])[None], near[None], edges])


def network() -> nn.Sequential:
    """Return the network: pictures to a score of centres, and edges, for each cell (5, H / 4, W / 4)."""
    plan = ((3, 16, 2, 1), (16, 32, 2, 1), (32, 32, 1, 1), (32, 48, 1, 2), (48, 48, 1, 4))
    layers = [(nn.Conv2d(a, b, 3, stride, gap, gap), nn.GroupNorm(4, b), nn.ReLU()) for a, b, stride, gap in plan]
    last = nn.Conv2d(48, 5, 1)
    nn.init.constant_(last.bias[:1], -2.2)  # type: ignore[index]  # Few cells are centres, as CenterNet begins.
    return nn.Sequential(*(each for layer in layers for each in layer), last)


def loss_of(out: Tensor, goals: Tensor) -> Tensor:
    """Return the loss of outputs (B, 5, …): of centres that of CenterNet (Zhou et al. 2019), of edges the error."""
    (score, edges), (centre, near) = out.split([1, 4], 1), goals[:, :2].split(1, 1)
    p, inside = score.sigmoid(), near > 0.5
    right, wrong = centre * (1 - p) ** 2 * logsigmoid(score), (1 - near) ** 4 * p**2 * logsigmoid(-score)
    error = (inside * (edges - goals[:, 2:]).abs()).sum() / inside.sum().clamp(min=1)
    return -(right + wrong).sum() / centre.sum().clamp(min=1) + error


def train(data: Samples, steps: int, seed: int) -> tuple[nn.Module, list[float]]:
    """Return a network trained on batches of 8 pictures, and the loss of each; the same seed gives the same."""
    torch.manual_seed(seed)
    model, losses = network(), []
    adam = torch.optim.Adam(model.parameters())
    rate = torch.optim.lr_scheduler.OneCycleLR(adam, 3e-3, steps)
    for pictures, goals in DataLoader(data, 8, sampler=RandomSampler(data, num_samples=8 * steps)):  # type: ignore
        adam.zero_grad()
        (loss := loss_of(model(pictures), goals)).backward()
        nn.utils.clip_grad_norm_(model.parameters(), 5.0)
        adam.step()
        rate.step()
        losses.append(loss.item())
    return model, losses


@torch.no_grad()
def detect(model: nn.Module, picture: Tensor, most: int = 50) -> Tensor:
    """Return the ``most`` likely boxes (most, 5) in a picture: edges in pixels, and score."""
    score, edges = model(picture[None])[0].split([1, 4])
    scores, at = (score.sigmoid() * (score == max_pool2d(score, 3, 1, 1))).flatten().topk(most)
    middles = (torch.stack([at % score.shape[2], at // score.shape[2]], 1) + 0.5) * CELL_PX
    reach = edges.flatten(1).T[at].exp() * torch.tensor([-1, -1, 1, 1])
    return torch.cat([middles.repeat(1, 2) + reach, scores[:, None]], 1)


def main(data: str, unseen: str, steps: int = 800, seed: int = 0) -> None:
    """Train on the data set ``data``, and print the AP on ``unseen``."""
    model, _ = train(DataSet(data).samples(picture_and_goals), steps, seed)
    frames = ((cars_seen(frame), picture_of(frame.observation.image_rgb)) for frame in DataSet(unseen))
    pairs = ((truth, detect(model, picture).numpy()) for truth, picture in frames)
    print(f"AP {average_precision(pairs):.3f}")


if __name__ == "__main__":
    tyro.cli(main)
