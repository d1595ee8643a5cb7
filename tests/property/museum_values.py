# SPDX-License-Identifier: MIT
"""The right values of the museum's exhibits, one function each, and what our pictures have there.

Each is computed here from the scene's numbers, in double precision or exactly, without a line of the
renderer. A function adds rows to the table of its exhibit (Exhibit.value)."""

import json
from fractions import Fraction
from math import acos, copysign, cos, floor, hypot, sqrt

U = 2.0**-24  # the largest relative error of rounding to binary32
FILM = "rounding of the film"


def add(a, b, t=1.0):
    return (a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return add((0, 0, 0), a, 1 / sqrt(dot(a, a)))


def rays(e):
    """(x, y, colour, eye, direction) of each pixel; the direction ends in the view plane."""
    camera = e.scene["camera"]
    eye = camera["position"]
    forward = unit(camera["direction"] if "direction" in camera else add(camera["look_at"], eye, -1))
    right = unit(cross(forward, camera.get("up", (0, 1, 0) if forward != (0, -1, 0) else (0, 0, -1))))
    up = cross(right, forward)
    plane = camera.get("view_plane")
    if not plane:
        height = 2 * sqrt(1 / cos(camera["fov_degrees"] * acos(-1) / 360) ** 2 - 1)
        plane = {"distance": 1, "width": height * e.film.width / e.film.height, "height": height}
    middle = add((0, 0, 0), forward, plane["distance"])
    for x, y, colour in e.film.pixels():
        to = add(middle, right, ((x + 0.5) / e.film.width - 0.5) * plane["width"])
        yield x, y, colour, eye, add(to, up, (0.5 - (y + 0.5) / e.film.height) * plane["height"])


def off(colour, right):
    """The largest relative difference of the channels, in u."""
    (a, b, c), (x, y, z) = colour, right
    return max(abs(a - x) / x, abs(b - y) / y, abs(c - z) / z) / U


def formula(e, what, differences):
    """A row for pixels compared with a formula. One in a million is for this file's own rounding."""
    differences = list(differences)
    what = f"{what}: largest relative difference in u, {len(differences)} pixels"
    e.value(what, 0, max(differences), 1 + 1e-6, FILM)


def material(e, i):
    return e.scene["objects"][i]["material"]


def edges(corners):
    return list(zip(corners, corners[1:] + corners[:1]))


def inside(outline, x, y):
    """Whether a point is in a polygon of these edges, by the number of edges to its right."""
    found = False
    for (x0, y0), (x1, y1) in outline:
        if (y0 <= y) != (y1 <= y) and (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0)):
            found = not found
    return found


def outline_of(thing, first=0, second=1):
    """The edges of a flat thing, in two of its coordinates."""
    return edges([(p[first], p[second]) for p in thing["vertices"]])


def checker(pattern, *point):
    odd = sum(floor(c / pattern["size"]) for c in point) % 2
    return tuple(pattern["b" if odd else "a"])


def near(colour, right):
    (a, b, c), (x, y, z) = colour, right
    return abs(a - x) <= U * x and abs(b - y) <= U * y and abs(c - z) <= U * z


def fresnel(cosine, index):
    sine = sqrt(1 - cosine * cosine) / index
    other = sqrt(1 - sine * sine)
    s = (cosine - index * other) / (cosine + index * other)
    p = (index * cosine - other) / (index * cosine + other)
    return (s * s + p * p) / 2


def thin_shell(e):
    core, outer = e.scene["objects"]
    differences = []
    for _, _, colour, eye, d in rays(e):
        d = unit(d)
        nearest = add(eye, d, -dot(eye, d))
        sine = sqrt(dot(nearest, nearest)) / outer["radius"]
        if sine < 0.999:
            share = fresnel(sqrt(1 - sine * sine), outer["material"]["ior"])
            both = zip(core["material"]["emission"], e.scene["background"])
            differences.append(off(colour, [(1 - share) * c + share * b for c, b in both]))
    formula(e, "inner sphere through the shell", differences)


def far_camera(e):
    outline, pattern = outline_of(e.scene["objects"][0]), material(e, 0)["emission"]
    wrong = 0
    for x, y, colour in e.film.pixels():
        at = (x - 99.5) / 100, (99.5 - y) / 100
        right = checker(pattern, *at) if inside(outline, *at) else e.scene["background"]
        wrong += not near(colour, right)
    e.value("pixels of another colour than the letter has there", 0, wrong)
    for distance in (7e2, 7e5):
        camera = {**e.scene["camera"], "position": [0, 0, distance]}
        camera["view_plane"] = {"distance": distance, "width": 2, "height": 2}
        near_by = e.render(camera=camera)
        e.value(f"pixels that differ from {distance:g} units away", 0, e.film.unlike(near_by))


def shared_edge(e):
    inner = [colour[1] for x, y, colour in e.film.pixels() if max(abs(x - 99), abs(y - 99)) < 80]
    e.value("green of the sheet, smallest", 0.75, min(inner))
    e.value("green of the sheet, largest", 0.75, max(inner))


def vertices(e):
    green = e.film.values()[1::3]
    e.value("green, smallest", 64 * 0.5**6, min(green))
    e.value("green, largest", 64 * 0.5**6, max(green))


def skinny(e):
    outline = outline_of(e.scene["objects"][0], 0, 2)
    wrong = lit = 0
    for _, _, colour, eye, d in rays(e):
        t = -eye[1] / d[1]
        hit = inside(outline, eye[0] + t * d[0], eye[2] + t * d[2])
        lit += hit
        wrong += hit != near(colour, material(e, 0)["emission"])
    e.value(f"pixels that are lit and should not be, or not lit; {lit} should be", 0, wrong)


def checker_origin(e):
    pattern, wrong, count = material(e, 0)["emission"], 0, 0
    for _, _, colour, eye, d in rays(e):
        if d[1] >= 0:
            continue
        x, z = (eye[i] - eye[1] / d[1] * d[i] for i in (0, 2))
        doubt = min(abs(c / pattern["size"] - round(c / pattern["size"])) for c in (x, z))
        if doubt > 1e-9:
            count += 1
            wrong += not near(colour, checker(pattern, x, z))
    e.value(f"pixels of the wrong colour, of {count}", 0, wrong)


def look_down(e):
    light, kd = e.scene["lights"][0], material(e, 0)["kd"]
    differences = []
    for _, _, colour, eye, d in rays(e):
        at = add(eye, d, -eye[1] / d[1])
        if max(abs(at[0]), abs(at[2])) > 1.5:
            to = add(light["position"], at, -1)
            right = [kd * i * to[1] / dot(to, to) ** 1.5 for i in light["intensity"]]
            differences.append(off(colour, right))
    formula(e, "ground beside the arrow", differences)
    up = {**e.scene["camera"], "up": [0, 0, -1]}
    e.value("pixels that differ from those with `up` given", 0, e.film.unlike(e.render(camera=up)))


def ior_one(e):
    without = e.render(objects=e.scene["objects"][:-1])
    e.value("pixels that differ without the ball of index 1", 0, e.film.unlike(without))


def glass_box(e):
    values = e.render(background=[0.5, 0.5, 0.5]).values()
    lost = 2 * 200 * 1e-9 * 0.5  # two rays at each of 200 surfaces, each below min_contribution
    e.value("in uniform light 0.5: smallest pixel", 0.5, min(values), lost, "what 400 cut paths can hold")
    e.value("in uniform light 0.5: largest pixel", 0.5, max(values), 0.5 * U, FILM)


def nested_glass(e):
    without = e.render(objects=e.scene["objects"][:1])
    e.value("pixels that differ without the ball of the same glass", 0, e.film.unlike(without))


def box_face(e):
    row = [e.film.at(x, 99) for x in range(e.film.width)]
    tiles = [tuple(e.scene["materials"][name]["emission"]) for name in "ab"]
    hit = [any(near(colour, tile) for tile in tiles) for colour in row]
    edge = [x for x in range(200) if abs((x + 0.5) / 200 - 0.5) * 4.8 < 2]
    e.value(f"pixels of the middle row that miss the cubes, of {len(edge)}", 0, sum(not hit[x] for x in edge))
    e.value("pixels of the middle row that hit cubes beside them", 0, sum(hit) - len(edge))


def concave(e):
    outline, colour_in = outline_of(e.scene["objects"][0]), material(e, 0)["emission"]
    wrong = lit = 0
    for x, y, colour in e.film.pixels():
        hit = inside(outline, x - 99.5, 99.5 - y)
        lit += hit
        wrong += hit != near(colour, colour_in)
    e.value(f"pixels on the wrong side of the outline; {lit} are inside", 0, wrong)


def mirrored(e):
    width = e.film.width
    wrong = sum(e.film.at(width - 1 - x, y) != colour for x, y, colour in e.film.pixels())
    e.value("pixels that differ from their mirror image", 0, wrong)


def many_samples(e):
    pattern, n = material(e, 0)["emission"], 2**18
    film = e.render(render={"width": 1, "height": 1, "samples_per_pixel": n})
    for ours, a, b, name in zip(film.at(0, 0), pattern["a"], pattern["b"], ("red", "green", "blue")):
        right = (a + b) / 2
        # each of n equal parts of the pixel's width has one sample
        allowed = (b - a) / n + U * right
        e.value(name, right, ours, allowed, "a sample in each of 2¹⁸ strips, and u")


def clipped(corners, axis, limit, sign):
    """The part of a polygon on one side of an axis-parallel line (Sutherland and Hodgman)."""
    part = []
    for p, q in edges(corners):
        a, b = sign * (p[axis] - limit), sign * (q[axis] - limit)
        if a >= 0:
            part.append(p)
        if a * b < 0:
            part.append(tuple(u + a / (a - b) * (v - u) for u, v in zip(p, q)))
    return part


def coverage(corners, x, y):
    for axis, low in ((0, x), (1, y)):
        corners = clipped(clipped(corners, axis, low, 1), axis, low + 1, -1) if corners else []
    return abs(sum(p[0] * q[1] - p[1] * q[0] for p, q in edges(corners))) / 2


def adaptive(e):
    right = [[0.0] * 600 for _ in range(200)]
    for thing in e.scene["objects"]:
        corners = [(100 + x, 100 - y) for x, y, _ in thing["vertices"]]
        columns, rows = (range(floor(min(c)), floor(max(c)) + 1) for c in zip(*corners))
        for y in rows:
            for x in columns:
                share = coverage(corners, x, y)
                for channel in range(3):
                    right[y][3 * x + channel] += share * thing["material"]["emission"][channel]
    square = sum((a - b) ** 2 for ours, row in zip(e.film.rows, right) for a, b in zip(ours, row))
    error, target = sqrt(square / 120000), e.scene["render"]["target_error"]
    e.value("root mean square error against exact coverage", 0, error, target, "the scene's `target_error`")


def threads(e):
    for settings in ({"threads": 1}, {"threads": 3, "tile": 7}):
        what = " and ".join(f"`{key}` {value}" for key, value in settings.items())
        e.value(f"pixels that differ with {what}", 0, e.film.unlike(e.render(render=settings)))


def cone_tip(e):
    cone = e.scene["objects"][0]
    right = [k * cone["radius"] / hypot(cone["radius"], cone["height"]) for k in material(e, 0)["kd"]]
    plane = e.scene["camera"]["view_plane"]
    differences, wrong = [], 0
    for _, _, colour, eye, d in rays(e):
        hit = hypot(d[0], d[1]) * eye[2] / plane["distance"] < cone["radius"]
        if hit:
            differences.append(off(colour, right))
        wrong += hit == near(colour, e.scene["background"])
    formula(e, "all of the cone", differences)
    e.value("pixels on the wrong side of the circle", 0, wrong)


def cylinder_axis(e):
    cylinder = e.scene["objects"][0]
    axis = unit(cylinder["axis"])
    differences, wrong = [], 0
    for _, _, colour, eye, d in rays(e):
        at = add(eye, d, -dot(eye, axis) / dot(d, axis))
        hit = sqrt(dot(at, at)) < cylinder["radius"]
        if hit:
            differences.append(off(colour, material(e, 0)["kd"]))
        wrong += hit == near(colour, e.scene["background"])
    formula(e, "all of the cap", differences)
    e.value("pixels on the wrong side of the circle", 0, wrong)


def diagonal_walls(e):
    right = [0.25 * c for c in e.scene["ambient"]]
    dark = [colour for x, y, colour in e.film.pixels() if x < 100 <= y and x >= 21 and y <= 178]
    formula(e, "floor behind the walls, against ambient light alone", (off(colour, right) for colour in dark))


def flat_walls(e):
    light = e.scene["lights"][0]
    walls = {(2, -1): 0, (0, -1): 1, (0, 1): 2, (1, -1): 3, (1, 1): 4}
    size = (1, 1, 2)
    differences = []
    for _, _, colour, eye, d in rays(e):
        t, axis = min([((copysign(size[i], d[i]) - eye[i]) / d[i], i) for i in range(3) if d[i]])
        at, kd = add(eye, d, t), material(e, walls[axis, copysign(1, d[axis])])["kd"]
        to = add(light["position"], at, -1)
        geometry = abs(to[axis]) / dot(to, to) ** 1.5
        differences.append(off(colour, [k * i * geometry for k, i in zip(kd, light["intensity"])]))
    formula(e, "kd · intensity · cos / d²", differences)


def inverse_square(e):
    intensity, pattern = e.scene["lights"][0]["intensity"][0], material(e, 0)["kd"]
    for radius in (0.01, 1, 5, 100):
        sphere = json.loads(json.dumps(e.scene["objects"]))
        sphere[0]["radius"], sphere[0]["material"]["kd"]["size"] = radius, radius / 5
        camera = {**e.scene["camera"], "position": [0, 0, 0.8 * radius]}
        values = e.render(objects=sphere, camera=camera).values()
        for name, best, k in (("brightest", max, pattern["a"]), ("darkest", min, pattern["b"])):
            right = k * intensity / radius**2
            e.value(f"radius {radius:g}: {name} pixel", right, best(values), right * U * (1 + 1e-6), FILM)


def rounding(e):
    from museum import png

    pattern, picture, worst = material(e, 0)["emission"], png(e.image), 0
    for x, _, levels in picture.pixels():
        share = (x + 0.5) / 200
        for level, a, b in zip(levels, pattern["a"], pattern["b"]):
            worst = max(worst, abs(level - 255 * (a + (b - a) * share)))
    allowed = 0.5 + 255 * U
    e.value("largest distance of a byte from 255 times its value", 0, worst, allowed, "half a step, and 255 u")


def row_order(e):
    from museum import png

    def encoded(v):
        return floor(255 * (12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055) + 0.5)

    picture = png(e.image)
    wrong = sum(tuple(map(encoded, colour)) != picture.at(x, y) for x, y, colour in e.film.pixels())
    e.value("pixels of the PFM that differ from the PNG's, once encoded", 0, wrong)
    top = sum(near(e.film.at(x, 30), e.scene["background"]) for x in range(200))
    bottom = sum(near(e.film.at(x, 169), e.scene["background"]) for x in range(200))
    e.value("pixels of the letter in row 30 from the top", 100, 200 - top)
    e.value("pixels of the letter in row 30 from the bottom", 25, 200 - bottom)


def bright(e):
    from museum import png

    picture = png(e.image)
    for x, thing in zip((40, 100, 160), e.scene["objects"]):
        right = thing["material"]["emission"][0]
        e.value(f"film, centre of the sphere of {right:g}", right, e.film.at(x, 50)[0], right * U, FILM)
        e.value(f"PNG, centre of the sphere of {right:g}", 255, min(picture.at(x, 50)))


def scaled(thing, factor):
    """All lengths of a scene's part times a factor."""
    lengths = ("position", "look_at", "center", "radius", "point", "base", "height", "vertices", "size")
    if isinstance(thing, dict):
        return {k: times(v, factor) if k in lengths else scaled(v, factor) for k, v in thing.items()}
    return [scaled(part, factor) for part in thing] if isinstance(thing, list) else thing


def times(value, factor):
    return [times(v, factor) for v in value] if isinstance(value, list) else value * factor


def scale(e):
    for power in (-100, 20):
        parts = {key: scaled(e.scene[key], 2.0**power) for key in ("camera", "lights", "objects")}
        e.value(f"pixels that differ at 2^{power} times the size", 0, e.film.unlike(e.render(**parts)))


def far_decal(e):
    def moved(thing, by):
        return [add(p, by) for p in thing] if isinstance(thing[0], list) else add(thing, by)

    by = (-(2.0**20), 0, 0)
    camera = {k: moved(v, by) if isinstance(v, list) else v for k, v in e.scene["camera"].items()}
    lights = [{**light, "position": moved(light["position"], by)} for light in e.scene["lights"]]
    objects = [{**o, "vertices": moved(o["vertices"], by)} for o in e.scene["objects"]]
    same = e.render(camera=camera, lights=lights, objects=objects)
    e.value("pixels that differ from those at the origin", 0, e.film.unlike(same))
    cube, decal = material(e, 0), material(e, 6)
    size, edge = decal["kt"]["size"], max(p[0] for p in e.scene["objects"][6]["vertices"]) + by[0]
    differences = []
    for _, _, colour, eye, d in rays(e):
        t = (e.scene["objects"][6]["vertices"][0][2] - eye[2]) / d[2]
        x, y = eye[0] + by[0] + t * d[0], eye[1] + t * d[1]
        doubt = min(abs(c / size - round(c / size)) for c in (x, y))
        if max(abs(x), abs(y)) < edge and doubt > 0.02:
            clear = (floor(x / size) + floor(y / size) + 4) % 2
            kd = cube["kd"] if clear else decal["kd"]["a"]
            differences.append(off(colour, [k * abs(d[2]) / sqrt(dot(d, d)) for k in kd]))
    formula(e, "decal, and cube where it is clear", differences)


def planet(e):
    radius = e.scene["objects"][0]["radius"]
    height = e.scene["camera"]["position"][1] - radius  # exact
    wrong = lit = 0
    for _, _, colour, _, d in rays(e):
        # below the horizon: (c·d)² > |d|² (c² − R²), c the vector to the centre
        hit = d[1] < 0 and ((radius + height) * d[1]) ** 2 > dot(d, d) * height * (2 * radius + height)
        lit += hit
        wrong += hit == near(colour, e.scene["background"])
    e.value(f"pixels on the wrong side of the horizon; {lit} see the planet", 0, wrong)


def zero_area(e):
    kept = [o for o in e.scene["objects"] if cross_area(o["vertices"])]
    less = len(e.scene["objects"]) - len(kept)
    what = f"pixels that differ without the {less} triangles that have no area"
    e.value(what, 0, e.film.unlike(e.render(objects=kept)))


def cross_area(corners):
    a, b, c = ([Fraction(x) for x in p] for p in corners)
    return any(cross(add(b, a, -1), add(c, a, -1)))


VALUES = {
    function.__name__.replace("_", "-"): function
    for function in (
        thin_shell, flat_walls, far_camera, far_decal, scale, planet, cone_tip, cylinder_axis,
        shared_edge, vertices, skinny, diagonal_walls, box_face, concave, zero_area, checker_origin,
        look_down, ior_one, glass_box, nested_glass, mirrored, inverse_square, adaptive, many_samples,
        threads, bright, rounding, row_order,
    )
}
