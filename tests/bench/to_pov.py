#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Translates a penumbra-scene/1 file into a POV-Ray 3.7 scene with the same primitives, camera, lights
and image size, so that both renderers do the same work. The pictures are close, but not equal.

Translated exactly: spheres, planes, triangles, polygons, cylinders and tubes (with their group
transforms applied), the view plane, point, spot and directional lights with or without shadows,
attenuation with kl = 0, the diffuse and Phong terms, mirrors, transparency without refraction, and
the limits of depth and contribution.

Approximated: kl > 0 (matched at the light's distance from the centre of the scene); coloured kt
(POV-Ray's filter also colours the diffuse term); coloured ks (its brightness is used); ambient light,
which POV-Ray shows in mirrors too; lights with a radius (a circular area light that faces the point,
with the same number of samples, none left out).

Usage: to_pov.py SCENE.json > SCENE.pov     the first line states width and height
"""

import json
import math
import sys

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FULLY_CLEAR = 0.98  # POV-Ray scales a layer's own light by its opacity, so none may be fully clear


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def mul(a, s):
    return tuple(x * s for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return mul(a, 1.0 / math.sqrt(dot(a, a)))


def rgb(value):
    return tuple(float(c) for c in value) if isinstance(value, list) else (float(value),) * 3


def rotation(axis, degrees):
    """The right-handed rotation matrix about an axis (Rodrigues)."""
    x, y, z = unit(axis)
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    k = 1.0 - c
    return ((c + x * x * k, x * y * k - z * s, x * z * k + y * s),
            (y * x * k + z * s, c + y * y * k, y * z * k - x * s),
            (z * x * k - y * s, z * y * k + x * s, c + z * z * k))


class Transform:
    """An affine map: rows of the linear part, and a shift."""

    def __init__(self, rows=IDENTITY, shift=(0.0, 0.0, 0.0)):
        self.rows, self.shift = rows, shift

    @staticmethod
    def from_json(t):
        if "matrix" in t:
            m = t["matrix"]
            return Transform((tuple(m[0:3]), tuple(m[4:7]), tuple(m[8:11])), (m[3], m[7], m[11]))
        turn = t.get("rotate")
        rows = rotation(turn["axis"], turn["degrees"]) if turn else IDENTITY
        rows = tuple(mul(r, t.get("scale", 1.0)) for r in rows)
        return Transform(rows, tuple(t.get("translate", (0.0, 0.0, 0.0))))

    def linear(self, v):
        return tuple(dot(r, v) for r in self.rows)

    def point(self, p):
        return add(self.linear(p), self.shift)

    def normal(self, n):
        """Transforms a normal by the cofactor matrix, the inverse transpose up to a factor."""
        a, b, c = self.rows
        return tuple(dot(col, n) for col in (cross(b, c), cross(c, a), cross(a, b)))

    def size(self):
        return abs(dot(self.rows[0], cross(self.rows[1], self.rows[2]))) ** (1.0 / 3.0)

    def then_inner(self, inner):
        columns = tuple(zip(*inner.rows))
        rows = tuple(tuple(dot(r, col) for col in columns) for r in self.rows)
        return Transform(rows, self.point(inner.shift))


def vec(v):
    return "<%s>" % ", ".join("%.17g" % c for c in v)


def normal_map(transform, n):
    m = transform.normal(n)
    return m if dot(m, m) > 0 else n


class Materials:
    """Declares one texture per different material; objects refer to it."""

    def __init__(self, scene):
        self.named = scene.get("materials", {})
        self.ambient = rgb(scene.get("ambient", 0))
        self.names, self.text = {}, []

    def texture(self, ref):
        m = self.named[ref] if isinstance(ref, str) else (ref or {})
        key = json.dumps(m, sort_keys=True)
        if key not in self.names:
            self.names[key] = "Texture%d" % len(self.names)
            self.text.append("#declare %s = %s" % (self.names[key], self.declare(m)))
        return self.names[key]

    def declare(self, m):
        kd, ks, kt, kr = (rgb(m.get(k, 0)) for k in ("kd", "ks", "kt", "kr"))
        glow = tuple(e + a * k for e, a, k in
                     zip(rgb(m.get("emission", 0)), self.ambient, rgb(m.get("ka", 1))))
        clear = min(max(kt), FULLY_CLEAR)
        opacity = 1.0 - clear
        if max(kt) > min(kt):  # coloured glass: the pigment must carry kt's colour
            pigment = mul(kt, 1.0 / max(kt))
            diffuse, passes = sum(kd) / max(sum(pigment) * opacity, 1e-9), "filter %.9g" % clear
        else:
            pigment = tuple(max(c / opacity, 1e-4) for c in kd)
            diffuse, passes = 1.0, "transmit %.9g" % clear
        pigment = tuple(max(c, 1e-4) for c in pigment)
        own = tuple(g / (p * opacity) for g, p in zip(glow, pigment))
        parts = ["ambient 0 diffuse %.9g emission rgb %s" % (diffuse, vec(own))]
        if max(ks) > 0:
            parts.append("phong %.9g phong_size %.9g"
                         % (sum(ks) / 3.0, max(m.get("shininess", 1.0), 1e-3)))
        if max(kr) > 0:
            parts.append("reflection { rgb %s }" % vec(kr))
        return ("texture { pigment { color rgb %s %s } finish { %s } }"
                % (vec(pigment), passes, " ".join(parts)))


def quadric_tube(origin, axis, radius):
    """|x - o|^2 - (a.(x - o))^2 = r^2 as POV-Ray's ten coefficients."""
    a = unit(axis)
    o = sub(origin, mul(a, dot(origin, a)))
    square = tuple(1.0 - c * c for c in a)
    mixed = (-2.0 * a[0] * a[1], -2.0 * a[0] * a[2], -2.0 * a[1] * a[2])
    return "quadric { %s, %s, %s, %.17g " % (vec(square), vec(mixed), vec(mul(o, -2.0)),
                                            dot(o, o) - radius * radius)


def primitive(o, t):
    """One primitive, without its closing brace."""
    kind = o["type"]
    if kind == "sphere":
        return "sphere { %s, %.17g " % (vec(t.point(o["center"])), o["radius"] * t.size())
    if kind == "plane":
        n = unit(normal_map(t, o["normal"]))
        return "plane { %s, %.17g " % (vec(n), dot(n, t.point(o["point"])))
    if kind == "triangle":
        return "triangle { %s " % ", ".join(vec(t.point(v)) for v in o["vertices"])
    if kind == "polygon":
        ring = [vec(t.point(v)) for v in o["vertices"] + o["vertices"][:1]]
        return "polygon { %d, %s " % (len(ring), ", ".join(ring))
    if kind == "tube":
        return quadric_tube(t.point(o["origin"]), t.linear(o["axis"]), o["radius"] * t.size())
    if kind == "cylinder":
        top = add(o["base"], mul(unit(o["axis"]), o["height"]))
        opened = "" if o.get("caps", True) else "open "
        return "cylinder { %s, %s, %.17g %s" % (vec(t.point(o["base"])), vec(t.point(top)),
                                                o["radius"] * t.size(), opened)
    raise SystemExit("to_pov.py: no translation for object type '%s'" % kind)


def primitives(objects, t, materials, out):
    for o in objects:
        if o["type"] == "group":
            inner = Transform.from_json(o["transform"]) if "transform" in o else Transform()
            primitives(o["objects"], t.then_inner(inner), materials, out)
        else:
            out.append("%stexture { %s } }" % (primitive(o, t), materials.texture(o.get("material"))))


class Camera:
    """The frame of api/scene-format.md, with its transforms applied in order."""

    def __init__(self, c, aspect):
        self.eye = tuple(map(float, c["position"]))
        forward = sub(c["look_at"], self.eye) if "look_at" in c else c["direction"]
        self.forward = unit(forward)
        self.right = unit(cross(self.forward, c.get("up", (0.0, 1.0, 0.0))))
        self.up = cross(self.right, self.forward)
        plane = c.get("view_plane")
        if plane:
            self.distance, self.width, self.height = (plane[k] for k in
                                                      ("distance", "width", "height"))
        else:
            self.distance = 1.0
            self.height = 2.0 * math.tan(math.radians(c.get("fov_degrees", 50.0)) / 2.0)
            self.width = self.height * aspect
        for step in c.get("transforms", []):
            self.apply(step)

    def turn(self, axis, degrees):
        m = Transform(rotation(axis, degrees))
        self.forward, self.right, self.up = (m.linear(v) for v in
                                             (self.forward, self.right, self.up))
        return m

    def apply(self, step):
        if "translate" in step:
            self.eye = add(self.eye, step["translate"])
        elif "rotate" in step:
            axis = step["rotate"]["axis"]
            self.turn(getattr(self, axis) if isinstance(axis, str) else axis,
                      step["rotate"]["degrees"])
        else:
            orbit = step["orbit"]
            m = self.turn(orbit["axis"], orbit["degrees"])
            self.eye = add(orbit["target"], m.linear(sub(self.eye, orbit["target"])))

    def text(self):
        return ("camera { perspective location %s\n  direction %s right %s up %s }"
                % (vec(self.eye), vec(mul(self.forward, self.distance)),
                   vec(mul(self.right, self.width)), vec(mul(self.up, self.height))))


def faded(light, middle):
    """Intensity and fade clause: POV-Ray's light is I * 2 / (1 + (d / fade_distance)^2)."""
    kc, kl, kq = light.get("attenuation", (1.0, 0.0, 0.0))
    intensity = rgb(light["intensity"])
    if kl > 0:  # the same light at the scene's middle, the fall-off all in kq
        kq += kl / max(math.dist(light["position"], middle), 1e-6)
    if kq == 0:
        return mul(intensity, 1.0 / kc), ""
    kc = max(kc, 1e-6 * kq)
    return (mul(intensity, 0.5 / kc),
            " fade_power 2 fade_distance %.9g" % math.sqrt(kc / kq))


def area(light, samples):
    """A disk light that faces the point, with as many samples to the square, all of them traced."""
    radius = light.get("radius", 0)
    if radius == 0 or not light.get("shadows", True):
        return ""
    edge = math.ceil(math.sqrt(samples))
    return (" area_light <%.9g, 0, 0>, <0, %.9g, 0>, %d, %d circular orient jitter"
            % (2 * radius, 2 * radius, edge, edge))


def light_text(light, middle, reach, samples):
    tail = "" if light.get("shadows", True) else " shadowless"
    if light.get("angular_radius", 0) > 0:
        raise SystemExit("to_pov.py: no translation for directional lights with an angular_radius")
    tail += area(light, samples)
    if light["type"] == "directional":
        direction = unit(light["direction"])
        return ("light_source { %s color rgb %s parallel point_at %s%s }"
                % (vec(sub(middle, mul(direction, reach))), vec(rgb(light["intensity"])), vec(middle),
                   tail))
    intensity, fade = faded(light, middle)
    spot = ""
    if light["type"] == "spot":  # no sharp cone: the intensity is cos^tightness everywhere
        spot = (" spotlight point_at %s radius 89.9 falloff 90 tightness %.9g"
                % (vec(add(light["position"], light["direction"])),
                   light.get("beam_exponent", 1.0)))
    return ("light_source { %s color rgb %s%s%s%s }"
            % (vec(light["position"]), vec(intensity), spot, fade, tail))


def main():
    if len(sys.argv) != 2:
        raise SystemExit(__doc__)
    with open(sys.argv[1], encoding="utf-8") as f:
        scene = json.load(f)
    render = scene.get("render", {})
    width, height = int(render.get("width", 800)), int(render.get("height", 600))
    camera = Camera(scene["camera"], width / height)
    middle = add(camera.eye, mul(camera.forward, camera.distance))
    look_at = scene["camera"].get("look_at")
    if look_at:
        middle = tuple(map(float, look_at))
    materials, out = Materials(scene), []
    primitives(scene.get("objects", []), Transform(), materials, out)
    lights = [light_text(l, middle, 1e5, render.get("light_samples", 16)) for l in scene.get("lights", [])]
    print("// width=%d height=%d" % (width, height))
    print("// %s, translated for a comparison of speed" % scene.get("name", "scene"))
    print("#version 3.7;")
    print("global_settings { assumed_gamma 1.0 max_trace_level %d adc_bailout %.9g }"
          % (render.get("max_depth", 10), render.get("min_contribution", 0.001)))
    print("background { color rgb %s }" % vec(rgb(scene.get("background", 0))))
    for part in ([camera.text()], lights, materials.text, out):
        print("\n".join(part))


main()
