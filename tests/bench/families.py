# SPDX-License-Identifier: MIT
"""A random scene of a family whose light is small and bright, as JSON.
usage: families.py FAMILY SEED

lamps       spheres of some pixels that shine 2 to 1000 times as bright as white
bokeh       1 to 36 lights out of focus
dots        10 to 160 spheres smaller than a pixel, which shine or are lit strongly
wires       cylinders of 1/100 to 1/10 pixel
sparks      small lamps over a mirror, or a glossy plane, or beside a mirror ball: seen in it, and directly
highlights  black spheres, cylinders or a floor with highlights of shininess 1e3 to 2e6
"""
import json
import random
import sys

family, seed = sys.argv[1], int(sys.argv[2])
rng = random.Random(f"{family} {seed}")
HALF = 3.64  # of what the camera sees at z = 0
PIXEL = 2 * HALF / 64


def near(*sides):
    return [round(rng.uniform(-s, s) if isinstance(s, (int, float)) else rng.uniform(*s), 6) for s in sides]


def glow(light):
    return {"emission": [light] * 3, "ka": 0}


def sphere(center, radius, material):
    return {"type": "sphere", "center": center, "radius": radius, "material": material}


def power(low, high):
    return 10 ** rng.uniform(low, high)


scene = {
    "format": "penumbra-scene/1",
    "background": [0, 0, 0],
    "ambient": [1, 1, 1],
    "lights": [],
    "camera": {"position": [0, 0, 10], "look_at": [0, 0, 0], "fov_degrees": 40},
    "objects": [],
    "render": {"width": 64, "height": 64, "max_samples": 65536},
}
objects = scene["objects"]
if family == "lamps":
    for _ in range(rng.randint(1, 3)):
        objects.append(sphere(near(3, 3, 1), rng.uniform(0.1, 1.2), glow(power(0.3, 3))))
    scene["background"] = [rng.choice([0, rng.uniform(0, 0.5)])] * 3
elif family == "bokeh":
    scene["camera"].update(aperture_radius=rng.uniform(0.1, 0.5), focus_distance=10)
    for _ in range(rng.choice([1, 4, 16, 36])):
        objects.append(sphere(near(6, 6, (-12, -4)), power(-2, -0.7), glow(power(0.7, 2.5))))
elif family == "dots":
    scene["background"] = [rng.choice([0, 0, 0.2, 0.8])] * 3
    for _ in range(rng.choice([10, 40, 160])):
        objects.append(sphere(near(HALF, HALF, 0), PIXEL * rng.uniform(0.05, 0.5), glow(rng.choice([0, 0.3, 1, 1, 3]))))
    if rng.random() < 0.4:
        for dot in objects:
            dot["material"] = {"ka": 0, "kd": 1}
        scene["lights"] = [{"type": "directional", "direction": near(1, 1, (-1, -1)), "intensity": [power(0, 1.5)] * 3}]
elif family == "wires":
    scene["background"] = [rng.choice([0, 0, 0.2, 0.8])] * 3
    for _ in range(rng.choice([1, 4, 12])):
        base, end = near(HALF, HALF, 0.5), near(HALF, HALF, 0.5)
        axis = [q - p for p, q in zip(base, end)]
        objects.append({"type": "cylinder", "base": base, "axis": axis, "height": sum(a * a for a in axis) ** 0.5,
                        "radius": PIXEL * power(-2, -1) / 2, "material": glow(rng.choice([0, 1, 1, 3]))})
elif family == "sparks":
    mirror = {"ka": 0, "kr": 0.8, "reflection_blur": rng.choice([0, 0, 2, 5, 10])}
    if rng.random() < 0.4:
        objects.append(sphere(near(1, 1, (-1, 1)), rng.uniform(0.5, 2), {"ka": 0, "kr": 0.8}))
    else:
        objects.append({"type": "plane", "point": [0, -2, 0], "normal": [0, 1, 0], "material": mirror})
    for _ in range(rng.randint(1, 4)):
        objects.append(sphere(near(3, (-1, 2), (-6, 2)), power(-2, -0.7), glow(power(0.7, 2.5))))
elif family == "highlights":
    for _ in range(rng.randint(1, 3)):
        metal = {"ka": 0, "ks": 1, "shininess": power(3, 6.3)}
        shape = rng.choice(["sphere", "sphere", "cylinder", "plane"])
        if shape == "sphere":
            objects.append(sphere(near(2, 2, 0), rng.uniform(0.5, 1.2), metal))
        elif shape == "cylinder":
            objects.append({"type": "cylinder", "base": near(2, 2, 0), "axis": near(1, 1, 1), "height": rng.uniform(1, 4),
                            "radius": rng.uniform(0.1, 1), "material": metal})
        else:
            objects.append({"type": "plane", "point": [0, rng.uniform(-3, -1), 0], "normal": [0, 1, 0], "material": metal})
    scene["lights"] = [{"type": "point", "position": near(8, (0, 8), (10, 10)), "intensity": [power(0, 2)] * 3}]
else:
    sys.exit(__doc__)
json.dump(scene, sys.stdout)
