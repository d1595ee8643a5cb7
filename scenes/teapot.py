#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes teapot.json to standard output: a faceted teapot of triangles among marbles.

The pot is not Newell's patches but surfaces of its own: body, lid and knob are turned about the y
axis from curves through a few points, spout and handle are rings swept along Bezier curves. The
marbles lie on a sunflower's spiral (Vogel, "A better way to construct the sunflower head",
Mathematical Biosciences 44, 1979), so that every 21st is a neighbour on one arm, and an arm has one
colour. Numbers are rounded to three decimals, far coarser than any difference of math libraries.
Every part is a group: the accelerator `manual` has the pot's parts and the arms as its boxes."""

import json
import math

SIDES = 24  # of what is turned
MARBLES, ARMS, FIRST = 441, 21, 84


def number(x):
    text = f"{x:.3f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def vector(v):
    return "[" + ", ".join(number(x) for x in v) + "]"


def catmull_rom(points, steps):
    """A curve through all points, with `steps` straight pieces between two of them."""
    ends = [points[0]] + points + [points[-1]]
    curve = []
    for a, b, c, d in zip(ends, ends[1:], ends[2:], ends[3:]):
        for i in range(steps):
            t = i / steps
            curve.append(tuple(
                0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t * t
                       + (3 * q - p - 3 * r + s) * t ** 3)
                for p, q, r, s in zip(a, b, c, d)))
    return curve + [points[-1]]


def bezier(p, t):
    s = 1 - t
    return tuple(s ** 3 * a + 3 * s * s * t * b + 3 * s * t * t * c + t ** 3 * d
                 for a, b, c, d in zip(*p))


def ring(center, across, up, sides):
    """Points around a centre; `across` and `up` are the half axes of an ellipse."""
    points = []
    for i in range(sides):
        a = 2 * math.pi * i / sides
        points.append(tuple(c + math.cos(a) * u + math.sin(a) * v
                            for c, u, v in zip(center, across, up)))
    return points


def rounded(point):
    return tuple(float(number(x)) for x in point)


def skin(rings):
    """Triangles between neighbouring rings, outward where each ring runs clockwise seen from the
    next. A ring may be one point."""
    triangles = []
    for low, high in zip(rings, rings[1:]):
        n = max(len(low), len(high))
        for i in range(n):
            j = (i + 1) % n
            a, b = low[i % len(low)], low[j % len(low)]
            c, d = high[i % len(high)], high[j % len(high)]
            for corner in ((a, c, d), (a, d, b)):
                if len({rounded(p) for p in corner}) == 3:
                    triangles.append(corner)
    return triangles


def turned(profile):
    """A curve of (radius, height) turned about the y axis."""
    rings = []
    for r, y in profile:
        rings.append([(0, y, 0)] if r == 0 else ring((0, y, 0), (r, 0, 0), (0, 0, r), SIDES))
    return skin(rings)


def swept(curve, across, up, steps, sides):
    """Rings along a Bezier curve in the plane z = 0; across(t) and up(t) are the half axes, in the
    plane and out of it."""
    rings = []
    for i in range(steps + 1):
        t = i / steps
        x, y = bezier(curve, t)
        ax, ay = bezier(curve, max(t - 1e-3, 0))
        bx, by = bezier(curve, min(t + 1e-3, 1))
        length = math.hypot(bx - ax, by - ay)
        normal = (-(by - ay) / length, (bx - ax) / length, 0)
        rings.append(ring((x, y, 0), tuple(across(t) * n for n in normal), (0, 0, -up(t)), sides))
    return skin(rings)


def pot():
    body = catmull_rom([(1.2, 0), (1.55, 0.15), (2.06, 0.95), (1.78, 1.85)], 3)
    body += [(1.5, 2.3), (1.46, 2.44), (1.34, 2.44)]
    lid = [(1.4, 2.37), (1.3, 2.5), (0.95, 2.71), (0.5, 2.83), (0.2, 2.9)]
    knob = [(0.2, 2.9), (0.18, 2.98), (0.36, 3.12), (0.38, 3.24), (0.24, 3.38), (0, 3.43)]
    spout = [(1.55, 0.85), (2.75, 0.75), (2.35, 1.95), (3.3, 2.42)]
    handle = [(-1.6, 2.12), (-3.35, 2.7), (-3.35, 0.75), (-1.85, 0.62)]
    return [
        ("body", "glaze", turned(body)),
        ("lid", "glaze", turned(lid)),
        ("knob", "gold", turned(knob)),
        ("spout", "glaze", swept(spout, lambda t: 0.58 - 0.4 * t, lambda t: 0.5 - 0.28 * t, 9, 12)),
        ("handle", "glaze", swept(handle, lambda t: 0.15, lambda t: 0.2, 14, 8)),
    ]


def arms():
    """The marbles, arm by arm; those nearest the pot are the smallest."""
    golden = math.pi * (3 - math.sqrt(5))
    marbles = [[] for _ in range(ARMS)]
    for i in range(FIRST, FIRST + MARBLES):
        r = 0.29 * math.sqrt(i)
        size = 0.13 + 0.03 * (r - 2.6)
        marbles[i % ARMS].append(((r * math.cos(i * golden), size, r * math.sin(i * golden)), size))
    return marbles


COLOURS = [(0.6, 0.05, 0.045), (0.74, 0.24, 0.03), (0.8, 0.52, 0.05), (0.22, 0.42, 0.08),
           (0.03, 0.38, 0.34), (0.05, 0.2, 0.56), (0.27, 0.08, 0.42)]


def materials():
    named = {
        "wood": {"ka": [0.12, 0.08, 0.06], "kd": [0.12, 0.08, 0.06], "kr": 0.1},
        "glaze": {"ka": [0.3, 0.55, 0.52], "kd": [0.3, 0.55, 0.52], "ks": 0.4, "shininess": 60, "kr": 0.1},
        "gold": {"ka": [0.5, 0.33, 0.07], "kd": [0.5, 0.33, 0.07], "ks": [0.8, 0.62, 0.3], "shininess": 60, "kr": [0.3, 0.22, 0.08]},
    }
    for i, colour in enumerate(COLOURS):
        named[f"marble {i + 1}"] = {"ka": list(colour), "kd": list(colour), "ks": 0.6, "shininess": 150, "kr": 0.08}
    return named


def group(name, lines):
    return ('    {"type": "group", "name": "%s", "objects": [\n      ' % name
            + ",\n      ".join(lines) + "\n    ]}")


def main():
    objects = ['    {"type": "plane", "name": "table", "point": [0, 0, 0], "normal": [0, 1, 0], '
               '"material": "wood"}']
    parts = [group(name, ['{"type": "triangle", "vertices": [%s], "material": "%s"}'
                          % (", ".join(vector(p) for p in triangle), material)
                          for triangle in triangles])
             for name, material, triangles in pot()]
    objects.append('    {"type": "group", "name": "pot", "objects": [\n' + ",\n".join(parts)
                   + "\n    ]}")
    rows = [group(f"arm {n + 1}", ['{"type": "sphere", "center": %s, "radius": %s, "material": '
                                   '"marble %d"}' % (vector(c), number(r), n % len(COLOURS) + 1)
                                   for c, r in row])
            for n, row in enumerate(arms())]
    objects.append('    {"type": "group", "name": "marbles", "objects": [\n' + ",\n".join(rows)
                   + "\n    ]}")
    named = ",\n".join('    "%s": %s' % (name, json.dumps(m)) for name, m in materials().items())
    print("""{
  "format": "penumbra-scene/1",
  "name": "teapot",
  "background": [0.05, 0.06, 0.1],
  "ambient": [0.16, 0.17, 0.22],
  "camera": {"position": [4.2, 6.4, 10.2], "look_at": [0.15, 0.75, 0.35], "fov_degrees": 36},
  "materials": {
%s
  },
  "lights": [
    {"type": "point", "intensity": [1.5, 1.35, 1.1], "position": [-7, 9, 6], "attenuation": [1, 0, 0.004]},
    {"type": "directional", "intensity": [0.22, 0.27, 0.38], "direction": [-1, -1.3, -0.4]}
  ],
  "objects": [
%s
  ],
  "render": {"width": 1200, "height": 800}
}""" % (named, ",\n".join(objects)))


main()
