"""Metrics of two images by scikit-image, flip-evaluator and NumPy: one `name value` per line.

usage: metrics.py WIDTH HEIGHT IMAGE REFERENCE, both raw little-endian f32, rows from the top, R G B.
"""

import sys

import flip_evaluator
import numpy as np
from scipy.ndimage import correlate1d
from skimage.metrics import mean_squared_error, peak_signal_noise_ratio, structural_similarity

WIDTH, HEIGHT = int(sys.argv[1]), int(sys.argv[2])


def read(path):
    return np.fromfile(path, "<f4").reshape(HEIGHT, WIDTH, 3)


x32, r32 = read(sys.argv[3]), read(sys.argv[4])
# Linear values beside display values: of a range that has highlights.
bright = [image * image * np.float32(8.0) for image in (x32, r32)]
(x, r), (hx, hr) = ([image.astype(np.float64) for image in pair] for pair in ((x32, r32), bright))


def ms_ssim(x, r):
    """Wang, Simoncelli, Bovik 2003, equation 7, of one channel."""
    d = np.arange(-5, 6)
    window = np.exp(-d * d / (2 * 1.5**2))
    window /= window.sum()

    def mean(v):
        v = correlate1d(correlate1d(v, window, axis=0), window, axis=1)
        return v[5:-5, 5:-5]

    product = 1.0
    exponents = [0.0448, 0.2856, 0.3001, 0.2363, 0.1333]
    for scale, exponent in enumerate(exponents):
        mx, mr = mean(x), mean(r)
        vx, vr, c = mean(x * x) - mx * mx, mean(r * r) - mr * mr, mean(x * r) - mx * mr
        factor = (2 * c + 0.03**2) / (vx + vr + 0.03**2)
        if scale == 4:
            factor = factor * (2 * mx * mr + 0.01**2) / (mx * mx + mr * mr + 0.01**2)
        product *= max(factor.mean(), 0.0) ** exponent

        def halved(v):
            v = np.pad(v, [(0, v.shape[0] % 2), (0, v.shape[1] % 2)], mode="edge")
            return (v[::2, ::2] + v[1::2, ::2] + v[::2, 1::2] + v[1::2, 1::2]) / 4

        x, r = halved(x), halved(r)
    return product


found = {
    "mse": mean_squared_error(hx, hr),
    "rmse": np.sqrt(mean_squared_error(hx, hr)),
    "relmse": np.mean((hx - hr) ** 2 / (hr**2 + 0.01)),
    "smape": np.mean(abs(hx - hr) / (abs(hx) + abs(hr) + 0.01)),
    "mape": np.mean(abs(hx - hr) / (abs(hr) + 0.01)),
    "energy": hx.mean() / hr.mean(),
    "psnr": peak_signal_noise_ratio(r, x, data_range=1.0),
    "flip": flip_evaluator.evaluate(r32, x32, "LDR", applyMagma=False)[1],
    "hdr_flip": flip_evaluator.evaluate(bright[1], bright[0], "HDR", applyMagma=False)[1],
}
if min(WIDTH, HEIGHT) >= 11:
    options = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False}
    found["ssim"] = structural_similarity(x, r, data_range=1.0, channel_axis=2, **options)
if min(WIDTH, HEIGHT) >= 161:
    found["ms_ssim"] = np.mean([ms_ssim(x[..., c], r[..., c]) for c in range(3)])
for name, value in found.items():
    print(name, repr(float(value)))
