"""A program of the folder protocol: where the picture is reddest; ``python vots_program.py [FAULT]``."""

import os
import sys
from pathlib import Path

import cv2
import numpy as np

FAULT = sys.argv[1:]
files = Path("frames_color.txt").read_text().split()
offset, region = Path("query_obj0.txt").read_text().split()
assert offset == "0"
x, y, width, height = map(float, region.split(","))
print("so many pictures:", len(files))
regions, sure = [], []
for file in files:
    blue, green, red = np.moveaxis(cv2.imread(file).astype(float), -1, 0)
    row, column = np.unravel_index((red - green).argmax(), red.shape)
    seen = (red - green).max() > 50
    regions.append(f"{column + 0.5 - width / 2},{row + 0.5 - height / 2},{width},{height}" if seen else "0")
    sure.append("0.75" if seen else "")
if FAULT == ["fails"]:
    sys.exit("no memory left")
if FAULT == ["short"]:
    regions.pop()
if FAULT == ["nonsense"]:
    regions[2] = "here"
if FAULT == ["pipe"]:
    os.mkfifo("output_obj0.txt")
elif FAULT == ["huge"]:
    with open("output_obj0.txt", "wb") as file:
        file.truncate(1 << 40)
elif FAULT != ["silent"]:
    Path("output_obj0.txt").write_text("\n".join(regions) + "\n")
    Path("output_obj0_confidence.txt").write_text("\n".join(sure) + "\n")
