#!/usr/bin/env python3
"""Renders a sequence with Mitsuba 3 for `scumble denoise`: its own Cornell box under a camera that moves.

usage: render.py OUT [--size 64x64] [--frames 8] [--spp 4] [--reference-spp 256]
OUT/noisy/box.0001.exr ...      --spp, with albedo, sh_normal, depth and position beside the image, as Mitsuba names them
OUT/noisy/cameras.json          where the camera was, as Mitsuba says it
OUT/reference/frame.0001.exr ...  --reference-spp, the image alone
needs: pip install mitsuba (numpy comes with it). With libLLVM (17 to 19; DRJIT_LIBLLVM_PATH names it) it is three times as fast.
"""
import argparse
import json
import math
import os
import sys


def variant(mi):
    """The fast one where LLVM is there."""
    for name in ("llvm_ad_rgb", "scalar_rgb"):
        if name not in mi.variants():
            continue
        if name.startswith("llvm") and not os.environ.get("DRJIT_LIBLLVM_PATH"):
            # A libLLVM that is too old crashes instead of saying so: only one that was named is trusted.
            continue
        try:
            mi.set_variant(name)
            return name
        except Exception as problem:  # Without LLVM.
            print(f"{name}: {problem}", file=sys.stderr)
    sys.exit("neither llvm_ad_rgb nor scalar_rgb can be used")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("--size", default="64x64")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--reference-spp", type=int, default=256)
    args = parser.parse_args()
    width, height = map(int, args.size.split("x"))

    import mitsuba as mi

    print(variant(mi), mi.__version__)
    transform = mi.ScalarTransform4f
    path = {"type": "path", "max_depth": 6}
    aovs = "albedo:albedo,nn:sh_normal,dd:depth,pos:position"
    box = mi.cornell_box()
    del box["sensor"]
    box["integrator"] = path
    scene = mi.load_dict(box)
    # What lamps that are seen emit, along the very rays of the image.
    seen = {"type": "path", "max_depth": 1}
    noisy = mi.load_dict({"type": "aov", "aovs": aovs, "img": path, "emission": seen})
    converged = mi.load_dict(path)

    def sensor(frame):
        """A step to the right and ahead each frame, always towards the middle of the box."""
        t = frame / 8
        to_world = transform().look_at(
            origin=[-0.25 + 0.5 * t, 0.1 * math.sin(3 * t), 3.9 - 0.3 * t],
            target=[0, 0, 0],
            up=[0, 1, 0],
        )
        film = {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        }
        made = {
            "type": "perspective",
            "fov": 39.3,
            "fov_axis": "y",
            "near_clip": 0.01,
            "far_clip": 100,
            "to_world": to_world,
            "film": film,
            "sampler": {"type": "independent"},
        }
        rows = [[float(to_world.matrix[i, j]) for j in range(4)] for i in range(4)]
        return mi.load_dict(made), rows

    folders = [os.path.join(args.out, name) for name in ("noisy", "reference")]
    for folder in folders:
        os.makedirs(folder, exist_ok=True)
    cameras = []
    for frame in range(args.frames):
        made, rows = sensor(frame)
        cameras.append({"frame": frame + 1, "fov": 39.3, "fov_axis": "y", "world_from_camera": rows})
        mi.render(scene, sensor=made, integrator=noisy, spp=args.spp, seed=2 * frame)
        made.film().bitmap().write(os.path.join(folders[0], f"box.{frame + 1:04}.exr"))
        mi.render(scene, sensor=made, integrator=converged, spp=args.reference_spp, seed=2 * frame + 1)
        made.film().bitmap().write(os.path.join(folders[1], f"frame.{frame + 1:04}.exr"))
    with open(os.path.join(folders[0], "cameras.json"), "w") as file:
        # Mitsuba's camera looks along its +Z.
        json.dump({"looks": "+z", "frames": cameras}, file, indent=1)


main()
