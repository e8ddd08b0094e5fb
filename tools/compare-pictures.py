#!/usr/bin/env python3
"""Puts pictures beside a reference, with their differences from it below, four times as bright.

    pip install numpy pillow OpenEXR
    tools/compare-pictures.py OUT.png EXPOSURE REFERENCE.exr PICTURE.exr...

EXPOSURE is a power of two. Pictures are linear, as `probelight reference` and `probelight render` write them.
"""

import sys

import numpy as np
import OpenEXR
from PIL import Image

DIFFERENCE_GAIN = 4.0


def read(path):
    channels = OpenEXR.File(path).channels()
    pixels = channels["RGB"].pixels if "RGB" in channels else np.stack([channels[c].pixels for c in "RGB"], axis=-1)
    return pixels.astype(np.float32)


def encode(linear, exposure):
    exposed = np.clip(linear * 2.0**exposure, 0.0, 1.0)
    srgb = np.where(exposed <= 0.0031308, 12.92 * exposed, 1.055 * exposed ** (1 / 2.4) - 0.055)
    return (255.0 * srgb + 0.5).astype(np.uint8)


def main(out, exposure, reference, *pictures):
    truth, pictures = read(reference), [read(picture) for picture in pictures]
    differences = [DIFFERENCE_GAIN * np.abs(picture - truth) for picture in pictures]
    rows = [[truth, *pictures], [np.zeros_like(truth), *differences]]
    sheet = np.concatenate([np.concatenate(row, axis=1) for row in rows], axis=0)
    Image.fromarray(encode(sheet, float(exposure))).save(out, optimize=True)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
