"""Scenes of sampling_scenes.h and race_cycles.c in Blender's Cycles: the other side of race_cycles.c. race_cycles.sh runs both.

    blender -b --factory-startup -t 2 -P tests/bench/race_cycles.py -- OUT SIZE SPP REFERENCE SEED SCENE

Renders SCENE (see SCENES below) with SPP samples to OUT/SCENE_cycles_SEED.pfm, and adds a row to
OUT/seconds.csv: SCENE,cycles,SEED, seconds of the processor and of the clock. Those are of rendering alone: half of what
3 SPP samples take longer than SPP, so that all a render does but once (synchronising, trees, tables, files) cancels.
Before the first race, SEED 0 makes a reference of REFERENCE samples: out/reference/SCENE_cycles_SIZExSIZE_REFERENCE.pfm.
Settings favour it where there is a choice: the sun's map is sampled at its full resolution, the lamp is one of Cycles'
own rectangles, and the better one of its samplers draws.
"""
import os
import resource
import sys
import time

import bpy
import numpy
from mathutils import Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.dont_write_bytecode = True
from cycles_scene import add_map, depth, here, look, settings, take_pixels  # noqa: E402

MAP, BUNNY = "../shared/data/env/sunset.hdr", "../shared/data/meshes/stanford-bunny.obj"


def material(name, kind, inputs, attributes=None):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    tree = m.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNode" + kind)
    for key, value in (attributes or {}).items():
        setattr(node, key, value)
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    return m


def matte(r, g, b):
    return material("matte", "BsdfDiffuse", {"Color": (r, g, b, 1), "Roughness": 0})


def metal(r, g, b, roughness):
    """Specular .25 and ior 1.33 make Principled's Fresnel curve Schlick's: see compare_materials.py."""
    return material("metal", "BsdfPrincipled", {"Base Color": (r, g, b, 1), "Metallic": 1, "Roughness": roughness,
                    "Specular": .25, "Specular Tint": 0}, {"distribution": "MULTI_GGX"})


def add_mesh(scene, points, faces, m, smooth=False):
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata([here(p) for p in points], [], faces)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    mesh.materials.append(m)
    thing = bpy.data.objects.new("mesh", mesh)
    thing.cycles.shadow_terminator_geometry_offset = 0   # rays start where they are
    scene.collection.objects.link(thing)


def add_quad(scene, corner, u, v, m):
    c, u, v = Vector(corner), Vector(u), Vector(v)
    add_mesh(scene, [c, c + u, c + u + v, c + v], [(0, 1, 2, 3)], m)


def add_box(scene, lo, hi, m):
    points = [[(lo, hi)[i >> k & 1][k] for k in range(3)] for i in range(8)]
    add_mesh(scene, points, [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)], m)


def add_ball(scene, middle, radius, m):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=256, ring_count=128, radius=radius, location=here(middle))
    ball = bpy.context.object
    ball.data.polygons.foreach_set("use_smooth", [True] * len(ball.data.polygons))
    ball.data.materials.append(m)
    ball.cycles.shadow_terminator_geometry_offset = 0


def add_bunny(scene, m):
    """Of height 1, on the ground at the origin."""
    with open(BUNNY) as f:
        rows = [line.split() for line in f]
    p = numpy.array([row[1:4] for row in rows if row and row[0] == "v"], dtype=numpy.float32)
    faces = [[int(corner.split("/")[0]) - 1 for corner in row[1:]] for row in rows if row and row[0] == "f"]
    used = p[numpy.unique(faces)]
    lo, hi = used.min(axis=0), used.max(axis=0)
    p -= numpy.array([(lo[0] + hi[0]) / 2, lo[1], (lo[2] + hi[2]) / 2])
    add_mesh(scene, (p / (hi[1] - lo[1])).tolist(), faces, m, True)


def add_lamp(scene, middle, size, radiance):
    """A square one that shines down."""
    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.shape, lamp.size, lamp.energy = "SQUARE", size, radiance * 4 * size * size     # radiance: energy / (4 area)
    thing = bpy.data.objects.new("lamp", lamp)
    thing.location = here(middle)
    thing.visible_camera = True
    scene.collection.objects.link(thing)
    x, y, z = middle
    add_quad(scene, (x - size / 2, y + .0005, z - size / 2), (size, 0, 0), (0, 0, size), matte(0, 0, 0))    # it lets light through: not ours


def add_fog(scene, lo, hi, sigma_a, sigma_s, g):
    m = bpy.data.materials.new("fog")
    m.use_nodes = True
    m.cycles.homogeneous_volume = True
    tree = m.node_tree
    tree.nodes.clear()
    scatter, absorb = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeVolumeAbsorption")
    both, output = tree.nodes.new("ShaderNodeAddShader"), tree.nodes.new("ShaderNodeOutputMaterial")
    scatter.inputs["Color"].default_value = (1, 1, 1, 1)
    scatter.inputs["Density"].default_value, scatter.inputs["Anisotropy"].default_value = sigma_s, g
    absorb.inputs["Color"].default_value, absorb.inputs["Density"].default_value = (0, 0, 0, 1), sigma_a
    tree.links.new(scatter.outputs[0], both.inputs[0])
    tree.links.new(absorb.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Volume"])
    points = [[(lo, hi)[i >> k & 1][k] for k in range(3)] for i in range(8)]
    add_mesh(scene, points, [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)], m)


def fog(scene, size, y):
    white = matte(.6, .6, .6)
    add_quad(scene, (-3, 0, 3), (6, 0, 0), (0, 0, -6), white)
    add_ball(scene, (.1, .5, 0), .35, white)
    add_lamp(scene, (-.3, y, 0), size, 8 / (size * size))
    add_fog(scene, (-1, .001, -1), (1, 2, 1), .1, .9, .3)
    look(scene, (0, 1.4, 6), (0, .9, 0), 26)
    depth(scene, 64)
    scene.cycles.volume_bounces, scene.cycles.transparent_max_bounces = 63, 1024


def cornell(scene):
    white = matte(.73, .73, .73)
    add_quad(scene, (0, 0, 0), (0, 0, 1), (1, 0, 0), white)
    add_quad(scene, (0, 1, 0), (1, 0, 0), (0, 0, 1), white)
    add_quad(scene, (0, 0, 1), (0, 1, 0), (1, 0, 0), white)
    add_quad(scene, (1, 0, 0), (0, 0, 1), (0, 1, 0), matte(.65, .05, .05))
    add_quad(scene, (0, 0, 0), (0, 1, 0), (0, 0, 1), matte(.12, .45, .15))
    add_box(scene, (.15, 0, .15), (.45, .30, .45), white)
    add_box(scene, (.55, 0, .50), (.85, .60, .80), white)
    add_lamp(scene, (.5, .999, .5), .3, 15)
    look(scene, (.5, .5, -1.4), (.5, .5, 0), 40)
    depth(scene, 8)


def bunny(scene, m):
    add_quad(scene, (-6, 0, 6), (12, 0, 0), (0, 0, -12), matte(.6, .6, .6))
    add_bunny(scene, m)
    add_map(scene, MAP)
    look(scene, (0, 1, 2.6), (0, .45, 0), 40)
    depth(scene, 64)


SCENES = {
    "cornell":      cornell,
    "bunny_sunset": lambda scene: bunny(scene, matte(.6, .6, .6)),
    "metal_bunny":  lambda scene: bunny(scene, metal(.9, .7, .4, .3)),
    "fog":          lambda scene: fog(scene, .6, 2.6),
    "fog_lamp":     lambda scene: fog(scene, .06, 1.4),
}


def make(name, size):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    SCENES[name](scene)
    settings(scene, size)
    scene.cycles.sampling_pattern = "SOBOL"
    scene.cycles.debug_bvh_type = "STATIC_BVH"
    return scene


def render(scene, path, spp, seed):
    """Seconds of the processor and of the clock; the picture goes to the EXR file that path says."""
    scene.cycles.samples, scene.cycles.seed, scene.render.filepath = spp, seed, path
    usage, clock = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    bpy.ops.render.render(write_still=True)
    clock, now = time.perf_counter() - clock, resource.getrusage(resource.RUSAGE_SELF)
    return numpy.array([now.ru_utime + now.ru_stime - usage.ru_utime - usage.ru_stime, clock])


def move_to_pfm(exr, pfm, size):
    pixels = take_pixels(exr, size)                      # bottom row first, as in a PFM file
    with open(pfm, "wb") as f:
        f.write(b"PF\n%d %d\n-1\n" % (size, size))
        f.write(pixels.astype("<f4").tobytes())


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    if len(arguments) != 6 or arguments[5] not in SCENES:
        sys.exit("usage: blender -b --factory-startup -t 2 -P race_cycles.py -- OUT SIZE SPP REFERENCE SEED SCENE")
    out, name = os.path.abspath(arguments[0]), arguments[5]
    size, spp, reference, seed = map(int, arguments[1:5])
    exr = os.path.join(out, "cycles.exr")
    if seed == 0:
        pfm = os.path.abspath("out/reference/%s_cycles_%dx%d_%d.pfm" % (name, size, size, reference))
        if not os.path.exists(pfm):
            render(make(name, size), exr, reference, 0x5eed)
            move_to_pfm(exr, pfm, size)
        return
    scene = make(name, size)
    render(scene, exr, 1, seed)                          # the scene stays made
    seconds = -render(scene, exr, spp, seed)
    move_to_pfm(exr, os.path.join(out, "%s_cycles_%d.pfm" % (name, seed)), size)
    seconds = (seconds + render(scene, exr, 3 * spp, seed)) / 2
    os.remove(exr)
    with open(os.path.join(out, "seconds.csv"), "a") as f:
        f.write("%s,cycles,%d,%.6f,%.6f\n" % (name, seed, *seconds))


main()
