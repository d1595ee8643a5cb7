#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints a scene: a room of 77 primitives under two disk lights, 400 x 600 pixels, with light samples
on a jittered grid of 15 x 15 in a circle. A classroom ray tracer was timed with as many primitives,
rays and pixels. One light hangs free; the other is in a bulb behind a lampshade, both of which transmit
light. The floor and a mirror reflect. Usage: soft_room.py > soft_room.json"""

import json

objects = []


def polygon(material, *vertices):
    objects.append({"type": "polygon", "material": material, "vertices": [list(v) for v in vertices]})


def box(material, lo, hi):
    (a, b, c), (x, y, z) = lo, hi
    polygon(material, (a, y, c), (a, y, z), (x, y, z), (x, y, c))
    polygon(material, (a, b, c), (x, b, c), (x, b, z), (a, b, z))
    polygon(material, (a, b, z), (x, b, z), (x, y, z), (a, y, z))
    polygon(material, (x, b, c), (a, b, c), (a, y, c), (x, y, c))
    polygon(material, (x, b, z), (x, b, c), (x, y, c), (x, y, z))
    polygon(material, (a, b, c), (a, b, z), (a, y, z), (a, y, c))


def cylinder(material, base, radius, height, caps=True):
    objects.append({"type": "cylinder", "material": material, "base": list(base), "axis": [0, 1, 0],
                    "radius": radius, "height": height, "caps": caps})


def sphere(material, center, radius):
    objects.append({"type": "sphere", "material": material, "center": list(center), "radius": radius})


def shell():
    polygon("floor", (-150, 0, -200), (-150, 0, 260), (150, 0, 260), (150, 0, -200))
    polygon("ceiling", (-150, 240, -200), (150, 240, -200), (150, 240, 260), (-150, 240, 260))
    polygon("wall", (-150, 0, -200), (150, 0, -200), (150, 240, -200), (-150, 240, -200))
    polygon("wall", (-150, 0, 260), (-150, 0, -200), (-150, 240, -200), (-150, 240, 260))
    polygon("wall", (150, 0, -200), (150, 0, 260), (150, 240, 260), (150, 240, -200))


def furniture():
    box("wood", (-50, 40, 10), (40, 44, 80))  # table
    for x, z in ((-45, 15), (35, 15), (-45, 75), (35, 75)):
        cylinder("iron", (x, 0, z), 2, 40)
    box("dark wood", (-60, 0, -195), (60, 70, -150))  # sideboard
    box("cloth", (70, 15, -60), (130, 40, 0))  # armchair
    box("cloth", (70, 40, -72), (130, 95, -60))
    box("cloth", (60, 15, -72), (70, 60, 0))
    box("cloth", (130, 15, -72), (140, 60, 0))
    box("red", (-40, 70, -185), (-15, 76, -165))  # books
    box("blue", (-38, 76, -184), (-17, 81, -166))


def lamps():
    cylinder("iron", (-110, 0, -120), 16, 3)
    cylinder("iron", (-110, 3, -120), 1.5, 132)
    cylinder("shade", (-110, 125, -120), 22, 40, caps=False)
    sphere("bulb", (-110, 145, -120), 6.5)


def small_things():
    for i, (x, y, z) in enumerate(((-20, 50, 40), (-8, 50, 44), (-14, 50, 52), (-26, 50, 50),
                                   (-17, 60, 46), (20, 50, 30))):
        sphere(("red", "green", "glass")[i % 3], (x, y, z), 6)
    polygon("mirror", (-40, 95, -199), (40, 95, -199), (40, 185, -199), (-40, 185, -199))
    for a, b in (((-44, 91), (44, 95)), ((-44, 185), (44, 189)), ((-44, 95), (-40, 185)),
                 ((40, 95), (44, 185))):
        polygon("gold", (a[0], a[1], -198), (b[0], a[1], -198), (b[0], b[1], -198),
                (a[0], b[1], -198))
    polygon("gold", (-149, 90, -60), (-149, 90, 40), (-149, 160, 40), (-149, 160, -60))
    polygon("blue", (-148, 95, -55), (-148, 95, 35), (-148, 155, 35), (-148, 155, -55))
    cylinder("glass", (20, 70, -172), 7, 26)
    sphere("green", (20, 106, -172), 11)
    sphere("gold", (-50, 76, -172), 6)


def matte(r, g, b, **more):
    return dict({"kd": [r, g, b], "ka": [r, g, b]}, **more)


shell()
furniture()
lamps()
small_things()
assert len(objects) == 77, len(objects)
print(json.dumps({
    "format": "penumbra-scene/1",
    "name": "soft-room",
    "background": [0, 0, 0],
    "ambient": [0.1, 0.1, 0.12],
    "camera": {"position": [40, 120, 420], "look_at": [-5, 92, 0],
               "view_plane": {"distance": 100, "width": 62, "height": 93}},
    "materials": {
        "floor": matte(0.45, 0.33, 0.22, kr=0.15), "ceiling": matte(0.6, 0.6, 0.58),
        "wall": matte(0.55, 0.57, 0.52), "wood": matte(0.5, 0.33, 0.16, ks=0.2, shininess=40),
        "dark wood": matte(0.3, 0.17, 0.09, ks=0.2, shininess=40),
        "iron": matte(0.1, 0.1, 0.11, ks=0.5, shininess=60), "cloth": matte(0.55, 0.3, 0.08),
        "red": matte(0.6, 0.1, 0.08, ks=0.3, shininess=60),
        "green": matte(0.15, 0.45, 0.2, ks=0.3, shininess=60), "blue": matte(0.1, 0.2, 0.5),
        "gold": matte(0.5, 0.38, 0.12, ks=0.5, shininess=50),
        "glass": {"kd": 0.05, "ks": 0.6, "shininess": 120, "kt": 0.75},
        "bulb": {"emission": [0.6, 0.5, 0.3], "kt": 0.9},
        "shade": {"emission": [0.2, 0.15, 0.08], "kd": 0.1, "kt": 0.7},
        "mirror": {"ks": 0.5, "shininess": 300, "kr": 0.85}},
    "lights": [
        {"type": "point", "intensity": [1.0, 0.8, 0.55], "position": [-110, 145, -120], "radius": 6,
         "attenuation": [1, 0, 0.00002]},
        {"type": "point", "intensity": [0.75, 0.75, 0.8], "position": [30, 215, 120], "radius": 12,
         "attenuation": [1, 0, 0.00001]}],
    "objects": objects,
    "render": {"width": 400, "height": 600, "light_pattern": "grid", "light_samples": 225},
}, indent=1))
