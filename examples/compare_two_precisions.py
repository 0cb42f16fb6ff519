"""How far is float32 from float64? Renders a scene in both and counts the pixels that differ."""

import numpy as np

import clrt
from clrt import metrics

size = (960, 540)
for name in clrt.builtin_scenes():
    single = clrt.render(name, *size)
    double = clrt.render(name, *size, precision="double")
    found = metrics.difference(single, double)
    step = np.count_nonzero(metrics.pixel_error(single, double) > 1 / 255)
    print(f"{name}: half of the pixels are within {found.p50:.0e}, {step} are off by over 1/255")
