#!/usr/bin/env python3
"""Compares pictures of kinetree with those of Mitsuba 3 (https://www.mitsuba-renderer.org).

Ten small scenes are written twice, as glTF and as a Mitsuba scene, from the same numbers. Each is rendered several times by
both, with different seeds, and the means are compared: of the picture, and of 8 x 8 blocks of it. What is left
must be noise. Prints the table of docs/reference-pictures.md.

Needs Python 3.9 with `pip install mitsuba numpy`, and a Rust toolchain. Mitsuba's fast variants need an LLVM library;
without one its scalar variant is used, which takes longer. No test of the repository depends on this script.

    python3 scripts/reference_pictures.py [--runs 8] [--spp 256] [--size 96] [--only NAME] [--keep FOLDER]
"""

import argparse
import base64
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent


# Shapes: positions, triangles, texture coordinates.

def quad(a, b, c, d):
    """Corners counter-clockwise as seen from the front."""
    return [a, b, c, d], [[0, 1, 2], [0, 2, 3]], [[0, 1], [1, 1], [1, 0], [0, 0]]


def box(low, high, inward=False):
    """Faces outwards, or inwards."""
    positions, triangles, uvs = [], [], []
    for axis in range(3):
        for side in (0, 1):
            corners = []
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = [0, 0, 0]
                corner[axis] = side
                corner[(axis + 1) % 3] = u if side else 1 - u
                corner[(axis + 2) % 3] = v
                corners.append([low[i] + corner[i] * (high[i] - low[i]) for i in range(3)])
            base = len(positions)
            positions += corners
            uvs += [[0, 1], [1, 1], [1, 0], [0, 0]]
            triangles += [[base, base + 1, base + 2], [base, base + 2, base + 3]]
    if inward:
        triangles = [[a, c, b] for a, b, c in triangles]
    return positions, triangles, uvs


def ball(rows, center=(0, 0, 0), radius=1.0):
    """Faceted in both renderers, so that neither interpolates normals."""
    positions, triangles, uvs = [], [], []
    for row in range(rows + 1):
        for column in range(2 * rows + 1):
            theta, phi = math.pi * row / rows, math.pi * column / rows
            point = (math.sin(theta) * math.cos(phi), math.cos(theta), -math.sin(theta) * math.sin(phi))
            positions.append([center[i] + radius * point[i] for i in range(3)])
            uvs.append([column / (2 * rows), row / rows])
    for row in range(rows):
        for column in range(2 * rows):
            a = row * (2 * rows + 1) + column
            b = a + 2 * rows + 1
            if row + 1 < rows:
                triangles.append([a, b, b + 1])
            if row > 0:
                triangles.append([a, b + 1, a + 1])
    return positions, triangles, uvs


def moved(shape, matrix):
    positions, triangles, uvs = shape
    matrix = np.asarray(matrix, dtype=np.float64)
    points = np.asarray(positions) @ matrix[:3, :3].T + matrix[:3, 3]
    if np.linalg.det(matrix[:3, :3]) < 0:
        triangles = [[a, c, b] for a, b, c in triangles]
    return points.tolist(), triangles, uvs


def placement(position, angle=0.0, scale=(1, 1, 1)):
    """Scale, then a turn about +y, then a move."""
    c, s = math.cos(angle), math.sin(angle)
    return [[c * scale[0], 0, s * scale[2], position[0]], [0, scale[1], 0, position[1]],
            [-s * scale[0], 0, c * scale[2], position[2]], [0, 0, 0, 1]]


# Materials: dictionaries with `color`, `emission`, `glass` ("solid", "thin"), `texture` (an image), `mask`.

def diffuse(*color):
    return {"color": color if len(color) == 3 else color * 3}


def lamp(*radiance):
    return {"color": (0, 0, 0), "emission": radiance if len(radiance) == 3 else radiance * 3}


class Scene:
    def __init__(self, name, what, eye, target, degrees=45.0, sky=None):
        self.name, self.what, self.eye, self.target, self.degrees, self.sky = name, what, eye, target, degrees, sky
        self.things, self.points, self.suns = [], [], []

    def add(self, shape, material, matrix=None):
        """With a matrix, an instance in glTF; shapes that are the same object share a mesh."""
        self.things.append((shape, material, matrix))
        return self


# The scenes.

def room(scene, low=(-1, 0, -1), high=(1, 2, 1), white=0.73):
    """Closed, red on the left and green on the right."""
    (x, y, z), (X, Y, Z) = low, high
    scene.add(quad((x, y, Z), (X, y, Z), (X, y, z), (x, y, z)), diffuse(white))
    scene.add(quad((x, Y, z), (X, Y, z), (X, Y, Z), (x, Y, Z)), diffuse(white))
    scene.add(quad((x, y, z), (X, y, z), (X, Y, z), (x, Y, z)), diffuse(white))
    scene.add(quad((x, y, Z), (x, Y, Z), (X, Y, Z), (X, y, Z)), diffuse(white))
    scene.add(quad((x, y, Z), (x, y, z), (x, Y, z), (x, Y, Z)), diffuse(0.6, 0.1, 0.1))
    return scene.add(quad((X, y, z), (X, y, Z), (X, Y, Z), (X, Y, z)), diffuse(0.1, 0.5, 0.1))


def ceiling_lamp(size, height, radiance, center=(0, 0)):
    x, z = center
    s = size / 2
    return quad((x - s, height, z - s), (x + s, height, z - s), (x + s, height, z + s), (x - s, height, z + s)), lamp(radiance)


def blocks(scene):
    scene.add(box((-0.3, 0, -0.3), (0.3, 1.2, 0.3)), diffuse(0.73), placement((-0.4, 0, -0.3), 0.3))
    return scene.add(box((-0.3, 0, -0.3), (0.3, 0.6, 0.3)), diffuse(0.73), placement((0.35, 0, 0.3), -0.3))


def ground(scene, size=20, material=None):
    return scene.add(quad((-size, 0, size), (size, 0, size), (size, 0, -size), (-size, 0, -size)), material or diffuse(0.4, 0.35, 0.3))


def board():
    """8 x 8 texels, sRGB, with holes."""
    image = np.zeros((8, 8, 4), dtype=np.uint8)
    for y in range(8):
        for x in range(8):
            image[y, x] = (230, 200, 60, 255) if (x + y) % 2 else (40, 60, 200, 0 if (x * 3 + y) % 4 == 0 else 255)
    return image


def scenes():
    inside = dict(eye=(0, 1, 0.95), target=(0, 0.9, -1), degrees=70.0)
    outside = dict(eye=(3, 2.2, 5), target=(0, 0.7, 0))
    gradient = ((0.3, 0.5, 1.0), (0.9, 0.9, 0.8), (0.2, 0.15, 0.1))
    even = ((1.0, 1.0, 1.0),) * 3
    all_scenes = []

    def new(*arguments, **keywords):
        all_scenes.append(Scene(*arguments, **keywords))
        return all_scenes[-1]

    blocks(room(new("closed box", "two blocks under a lamp in the ceiling", **inside))).add(*ceiling_lamp(0.6, 1.98, 15))

    bright = new("bright box", "walls that reflect 0.9, a lamp as wide as the ceiling", **inside)
    blocks(room(bright, white=0.9)).add(*ceiling_lamp(1.9, 1.98, 1))

    many = blocks(room(new("many lamps", "64 lamps of many strengths", **inside)))
    for i in range(64):
        many.add(*ceiling_lamp(0.06, 1.5 + 0.4 * ((i * 7) % 10) / 10, 4 + 30 * ((i * 5) % 8), (-0.9 + 0.25 * (i % 8), -0.9 + 0.25 * (i // 8))))

    points = blocks(room(new("points", "24 points of light", **inside)))
    for i in range(24):
        points.points.append(((-0.8 + 0.32 * (i % 6), 1.7, -0.8 + 0.5 * (i // 6)), (0.02 * (1 + i % 5), 0.05, 0.03)))

    panes = new("panes", "a room lit through a window of two panes by a lamp outside", **inside)
    (x, y, z), (X, Y, Z) = (-1, 0, -1), (1, 2, 1)
    blocks(room(panes))
    del panes.things[5]
    for low, high in (((X, 0, z), (X, 0.5, Z)), ((X, 1.8, z), (X, 2, Z)), ((X, 0.5, z), (X, 1.8, -0.7)), ((X, 0.5, 0.7), (X, 1.8, Z))):
        panes.add(quad((X, low[1], low[2]), (X, low[1], high[2]), (X, high[1], high[2]), (X, high[1], low[2])), diffuse(0.1, 0.5, 0.1))
    for offset in (0.0, 0.02):
        panes.add(quad((X + offset, 0.5, -0.7), (X + offset, 0.5, 0.7), (X + offset, 1.8, 0.7), (X + offset, 1.8, -0.7)), {"color": (1, 1, 1), "glass": "thin"})
    panes.add(quad((2.5, 0, 1.5), (2.5, 3, 1.5), (2.5, 3, -1.5), (2.5, 0, -1.5)), lamp(8))

    glass = ground(new("glass", "a ball and a block of glass on the ground under an even sky", sky=even, **outside))
    glass.add(ball(24, (-0.9, 0.9, 0), 0.85), {"color": (1, 1, 1), "glass": "solid"})
    glass.add(box((-0.5, 0, -0.5), (0.5, 1, 0.5)), {"color": (1, 1, 1), "glass": "solid"}, placement((1.1, 0.01, 0.2), 0.5))
    glass.add(box((-0.3, 0, -0.3), (0.3, 1.5, 0.3)), diffuse(0.7, 0.2, 0.1), placement((0.1, 0, -1.4), 0.2))

    sky = ground(new("sky", "balls on the ground under a sky from horizon to zenith", sky=gradient, **outside))
    for i in range(9):
        sky.add(ball(16), diffuse(0.2 + 0.08 * i, 0.5, 0.9 - 0.08 * i), placement((-1.6 + 1.6 * (i % 3), 0.5, -1.6 + 1.6 * (i // 3)), i, (0.6, 0.5, 0.6)))

    sun = ground(new("sun", "a lattice in the light of a sun and a sky", sky=tuple(tuple(0.3 * c for c in ends) for ends in gradient), **outside))
    for i in range(6):
        for j in range(6):
            sun.add(box((-0.1, 0, -0.1), (0.1, 1.8, 0.1)), diffuse(0.7), placement((-1.5 + 0.6 * i, 0, -1.5 + 0.6 * j), 0.3 * i, (1, 0.4 + 0.1 * j, 1)))
    sun.suns.append(((0.5, -0.75, -0.45), (3.6, 3.2, 2.7)))

    image = board()
    textures = ground(new("textures", "textures, and leaves cut out by alpha, under a sky and a lamp", sky=gradient, **outside), 20, {"color": (1, 1, 1), "texture": image})
    for i in range(5):
        leaf = quad((-0.7, 0, 0), (0.7, 0, 0), (0.7, 1.4, 0), (-0.7, 1.4, 0))
        textures.add(leaf, {"color": (0.9, 0.9, 0.9), "texture": image, "mask": True}, placement((-1 + 0.5 * i, 0.1, 0.4 - 0.5 * i), 0.5 * i))
    textures.add(*ceiling_lamp(1.0, 3.0, 10))

    instances = ground(new("instances", "400 instances of one mesh, turned, stretched and mirrored, under a lamp", eye=(5, 4, 7), target=(0, 0.5, 0)))
    one = ball(6)
    material = diffuse(0.6, 0.5, 0.3)
    for i in range(400):
        scale = (0.1 + 0.02 * (i % 5), 0.25 + 0.03 * (i % 7), -0.15 if i % 3 == 0 else 0.15)
        instances.add(one, material, placement((-3 + 0.3 * (i % 20), 0.3, -3 + 0.3 * (i // 20)), 0.7 * i, scale))
    instances.add(*ceiling_lamp(3.0, 4.0, 6))
    return all_scenes


# glTF.

def png(image):
    height, width, channels = image.shape
    rows = b"".join(b"\0" + image[y].tobytes() for y in range(height))
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, 6 if channels == 4 else 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def data_uri(kind, data):
    return f"data:{kind};base64," + base64.b64encode(data).decode()


def gltf(scene):
    binary = bytearray()
    views, accessors, meshes, materials, nodes, images = [], [], [], [], [], []
    seen = {}

    def accessor(array, kind, component, **more):
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": array.nbytes})
        binary.extend(array.tobytes())
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind, **more})
        return len(accessors) - 1

    for shape, material, matrix in scene.things:
        key = (id(shape), id(material))
        if key not in seen:
            pbr = {"baseColorFactor": [*material["color"], 1.0]}
            entry = {"pbrMetallicRoughness": pbr}
            if "emission" in material:
                entry["emissiveFactor"] = [1, 1, 1] if max(material["emission"]) > 1 else list(material["emission"])
                strength = max(1.0, max(material["emission"]))
                entry["emissiveFactor"] = [channel / strength for channel in material["emission"]]
                entry["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
            if "glass" in material:
                entry["extensions"] = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.5}}
                if material["glass"] == "solid":
                    entry["extensions"]["KHR_materials_volume"] = {"thicknessFactor": 1}
            if "texture" in material:
                images.append(data_uri("image/png", png(material["texture"])))
                pbr["baseColorTexture"] = {"index": len(images) - 1}
                if material.get("mask"):
                    entry.update(alphaMode="MASK", alphaCutoff=0.5)
            materials.append(entry)
            points = np.asarray(shape[0], dtype=np.float32)
            attributes = {"POSITION": accessor(points, "VEC3", 5126, min=points.min(0).tolist(), max=points.max(0).tolist())}
            attributes["TEXCOORD_0"] = accessor(np.asarray(shape[2], dtype=np.float32), "VEC2", 5126)
            indices = accessor(np.asarray(shape[1], dtype=np.uint32).reshape(-1), "SCALAR", 5125)
            meshes.append({"primitives": [{"attributes": attributes, "indices": indices, "material": len(materials) - 1}]})
            seen[key] = len(meshes) - 1
        node = {"mesh": seen[key]}
        if matrix is not None:
            node["matrix"] = np.asarray(matrix, dtype=float).T.reshape(-1).tolist()
        nodes.append(node)
    lights = []
    for position, intensity in scene.points:
        strength = max(intensity)
        nodes.append({"translation": list(position), "extensions": {"KHR_lights_punctual": {"light": len(lights)}}})
        lights.append({"type": "point", "color": [channel / strength for channel in intensity], "intensity": strength})
    for direction, irradiance in scene.suns:
        # Lights look along -z: a turn that takes -z to the direction, as a matrix.
        back = -np.asarray(direction) / np.linalg.norm(direction)
        right = np.cross((0, 1, 0), back)
        right /= np.linalg.norm(right)
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = right, np.cross(back, right), back
        strength = max(irradiance)
        nodes.append({"matrix": matrix.T.reshape(-1).tolist(), "extensions": {"KHR_lights_punctual": {"light": len(lights)}}})
        lights.append({"type": "directional", "color": [channel / strength for channel in irradiance], "intensity": strength})
    root = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "meshes": meshes, "materials": materials, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(binary), "uri": data_uri("application/octet-stream", bytes(binary))}],
    }
    if images:
        root["images"] = [{"uri": uri} for uri in images]
        root["samplers"] = [{"magFilter": 9728, "minFilter": 9728}]
        root["textures"] = [{"source": i, "sampler": 0} for i in range(len(images))]
    if lights:
        root["extensionsUsed"] = ["KHR_lights_punctual"]
        root["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    return json.dumps(root)


# Mitsuba.

def ply(path, shape):
    positions, triangles, uvs = shape
    vertices = np.hstack([np.asarray(positions), np.asarray(uvs)]).astype("<f4")
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("indices", "<i4", 3)])
    faces["count"], faces["indices"] = 3, np.asarray(triangles)
    header = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(vertices)
    header += "".join(f"property float {name}\n" for name in ("x", "y", "z", "u", "v"))
    header += "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(faces)
    path.write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())


def mitsuba_material(mi, material):
    if "glass" in material:
        return {"type": "dielectric" if material["glass"] == "solid" else "thindielectric", "int_ior": 1.5, "ext_ior": 1.0}
    color = {"type": "rgb", "value": list(material["color"])}
    opacity = None
    if "texture" in material:
        texels = material["texture"].astype(np.float32) / 255
        linear = np.where(texels <= 0.04045, texels / 12.92, ((texels + 0.055) / 1.055) ** 2.4)[..., :3]
        picture = lambda data: {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(data, dtype=np.float32)), "raw": True, "filter_type": "nearest"}
        color = picture(linear * np.asarray(material["color"], dtype=np.float32))
        opacity = picture(texels[..., 3:4]) if material.get("mask") else None
    both = {"type": "twosided", "inner": {"type": "diffuse", "reflectance": color}}
    return {"type": "mask", "opacity": opacity, "inner": both} if opacity else both


def mitsuba_scene(mi, scene, folder, size):
    camera = mi.ScalarTransform4f().look_at(origin=list(scene.eye), target=list(scene.target), up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"}
    out = {
        "type": "scene", "integrator": {"type": "path", "max_depth": 65, "rr_depth": 6},
        "sensor": {"type": "perspective", "fov": scene.degrees, "fov_axis": "y", "to_world": camera, "film": film, "sampler": {"type": "independent"}},
    }
    for number, (shape, material, matrix) in enumerate(scene.things):
        path = folder / f"{number}.ply"
        ply(path, moved(shape, matrix) if matrix is not None else shape)
        thing = {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": mitsuba_material(mi, material)}
        if "emission" in material:
            thing["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": list(material["emission"])}}
        out[f"thing{number}"] = thing
    for number, (position, intensity) in enumerate(scene.points):
        out[f"point{number}"] = {"type": "point", "position": list(position), "intensity": {"type": "rgb", "value": list(intensity)}}
    for number, (direction, irradiance) in enumerate(scene.suns):
        out[f"sun{number}"] = {"type": "directional", "direction": list(direction), "irradiance": {"type": "rgb", "value": list(irradiance)}}
    if scene.sky:
        zenith, horizon, ground = (np.asarray(end) for end in scene.sky)
        height = np.cos((np.arange(1024) + 0.5) / 1024 * math.pi)[:, None]
        rows = horizon + np.abs(height) * (np.where(height >= 0, zenith, ground) - horizon)
        bitmap = mi.Bitmap(np.repeat(rows[:, None, :], 16, axis=1).astype(np.float32))
        out["sky"] = {"type": "envmap", "bitmap": bitmap}
    return mi.load_dict(out)


# Comparing.

def read_pfm(path):
    with open(path, "rb") as file:
        file.readline()
        width, height = map(int, file.readline().split())
        file.readline()
        return np.frombuffer(file.read(), dtype="<f4").reshape(height, width, 3)[::-1].astype(np.float64)


def blocks_of(picture, count=8):
    side = picture.shape[0] // count
    return picture[: side * count, : side * count].reshape(count, side, count, side, 3).mean((1, 3, 4))


def compare(name, ours, theirs):
    """Ratio of the means with its standard error, the worst block in standard errors, and noise per pixel of both."""
    means = [np.array([run.mean() for run in runs]) for runs in (ours, theirs)]
    errors = [values.std(ddof=1) / math.sqrt(len(values)) / values.mean() for values in means]
    ratio, error = means[0].mean() / means[1].mean(), math.hypot(*errors)
    block = [np.array([blocks_of(run) for run in runs]) for runs in (ours, theirs)]
    spread = np.sqrt(sum(values.var(0, ddof=1) / len(values) for values in block))
    apart = np.abs(block[0].mean(0) - block[1].mean(0))
    # Of two sets of runs, the spread itself is an estimate: a floor keeps blocks without noise from counting.
    worst = (apart / (spread + 1e-4 * means[1].mean())).max()
    noise = [np.sqrt(np.array(runs).var(0, ddof=1).mean()) / values.mean() for runs, values in zip((ours, theirs), means)]
    return ratio, error, worst, noise


def built():
    """The program that renders glTF files to float maps."""
    subprocess.run(["cargo", "build", "--release", "-p", "kinetree-gltf", "--example", "film"], cwd=ROOT, check=True)
    metadata = subprocess.run(["cargo", "metadata", "--format-version", "1", "--no-deps"], cwd=ROOT, check=True, capture_output=True)
    return pathlib.Path(json.loads(metadata.stdout)["target_directory"]) / "release" / "examples" / "film"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=8)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--only")
    parser.add_argument("--keep", help="a folder for the scenes and pictures")
    parser.add_argument("--program", help="the example `film`, built before")
    arguments = parser.parse_args()
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb", "scalar_rgb")
    program = arguments.program or built()
    temporary = tempfile.TemporaryDirectory()
    top = pathlib.Path(arguments.keep or temporary.name)
    print(f"Mitsuba {mi.__version__} ({mi.variant()}), {arguments.size} x {arguments.size} pixels, {arguments.runs} runs of {arguments.spp} samples each.\n")
    print("| scene | what | mean over Mitsuba's | worst of 64 blocks | noise per pixel, ours and Mitsuba's |")
    print("|---|---|---|---|---|")
    for scene in scenes():
        if arguments.only and arguments.only != scene.name:
            continue
        folder = top / scene.name.replace(" ", "_")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scene.gltf").write_text(gltf(scene))
        theirs_scene = mitsuba_scene(mi, scene, folder, arguments.size)
        ours, theirs = [], []
        for run in range(arguments.runs):
            out = folder / f"{run}.pfm"
            text = lambda values: ",".join(map(str, values))
            sky = [text(end) for end in scene.sky] if scene.sky else []
            command = [program, folder / "scene.gltf", out, arguments.size, arguments.size, arguments.spp, run, text(scene.eye), text(scene.target), scene.degrees, *sky]
            subprocess.run([str(part) for part in command], check=True)
            ours.append(read_pfm(out))
            theirs.append(np.array(mi.render(theirs_scene, spp=arguments.spp, seed=run), dtype=np.float64))
        if arguments.keep:
            np.save(folder / "ours.npy", np.mean(ours, 0))
            np.save(folder / "theirs.npy", np.mean(theirs, 0))
        ratio, error, worst, noise = compare(scene.name, ours, theirs)
        print(f"| {scene.name} | {scene.what} | {ratio:.4f} ± {error:.4f} | {worst:.1f} σ | {noise[0]:.3f}, {noise[1]:.3f} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
