"""The settings of compare_materials.c in Blender's Cycles: what does another path tracer make of the same spheres?

    blender -b --factory-startup -P tests/bench/compare_materials.py -- MAP.hdr OUT [SETTING...]

Renders each setting (all, if none is named) under the map, and writes to the folder OUT
    cycles.csv      setting,region,r,g,b,se_r,se_g,se_b: means over the regions of the picture, and their standard errors
    SETTING.pfm     the picture
Rows of cycles.csv for other settings stay. Both programs in one line, which skips without Blender:

    mkdir -p out/materials && cc -O2 tests/bench/compare_materials.c -o out/compare_materials -lm -lpthread &&
    { ! command -v blender || blender -b --factory-startup -t 1 -P tests/bench/compare_materials.py -- MAP.hdr out/materials; } &&
    out/compare_materials MAP.hdr out/materials
"""
import math
import os
import sys

import bpy
import numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.dont_write_bytecode = True
from cycles_scene import add_map, depth, look, settings, take_pixels  # noqa: E402

SIZE, SEEDS, SPP = 128, 8, 64
EYE, VFOV = (4, 2, 4), 20.5                              # the same numbers stand in compare_materials.c
METAL, PLASTIC = (.9, .6, .3, 1), (.2, .4, .8, 1)
WHITE = (1, 1, 1, 1)
# Cycles 3.4's multiple-scattering glass loses light that it draws from the map: under small lamps its mean depends on
# whether the map is sampled. These settings leave it to the BSDF.
BSDF_ALONE = ("glass_3", "transmission", "tinted")


class Nodes:
    """A material, made of nodes."""

    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()

    def node(self, kind, attributes=None, **inputs):
        n = self.tree.nodes.new("ShaderNode" + kind)
        for key, value in (attributes or {}).items():
            setattr(n, key, value)
        for key, value in inputs.items():
            self.set(n.inputs[key.replace("_", " ")], value)
        return n.outputs[0]

    def set(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def glossy(self, roughness, color=WHITE):
        kind = "MULTI_GGX" if roughness > 0 else "SHARP"
        return self.node("BsdfGlossy", {"distribution": kind}, Color=color, Roughness=roughness)

    def glass(self, roughness):
        kind = "MULTI_GGX" if roughness > 0 else "SHARP"
        return self.node("BsdfGlass", {"distribution": kind}, Color=WHITE, Roughness=roughness, IOR=1.5)

    def diffuse(self, albedo, roughness=0.0):
        return self.node("BsdfDiffuse", Color=(albedo, albedo, albedo, 1), Roughness=roughness)

    def principled(self, color, **inputs):
        numbers = dict(Metallic=0, Specular=.5, Specular_Tint=0, Sheen=0, Sheen_Tint=0, Clearcoat=0, IOR=1.5, Transmission=0,
                       Emission_Strength=0)
        numbers.update(inputs)
        return self.node("BsdfPrincipled", {"distribution": "MULTI_GGX"}, Base_Color=color, **numbers)

    def metal(self, roughness):
        """Schlick's Fresnel: over microfacets Cycles has F(ior) stretched to [r0, 1], and Specular .25, ior 1.33, is the one
        whose mean over the hemisphere is Schlick's (within 0.0003 (1 - r0))."""
        return self.principled(METAL, Metallic=1, Roughness=roughness, Specular=.25)

    def mix(self, factor, a, b):
        n = self.node("MixShader", Fac=factor).node
        self.set(n.inputs[1], a)
        self.set(n.inputs[2], b)
        return n.outputs[0]

    def coated(self, below):
        return self.mix(self.node("Fresnel", IOR=1.5), below, self.glossy(0))

    def schlick(self):
        facing = self.node("LayerWeight", Blend=.5).node.outputs["Facing"]     # 1 - cos
        power = self.node("Math", {"operation": "POWER"}).node
        self.set(power.inputs[0], facing)
        self.set(power.inputs[1], 5)
        return self.mix(power.outputs[0], self.glossy(0, METAL), self.glossy(0))

    def add(self, a, b):
        n = self.node("AddShader").node
        self.set(n.inputs[0], a)
        self.set(n.inputs[1], b)
        return n.outputs[0]


SETTINGS = {
    "mirror":             lambda n: n.glossy(0),
    "diffuse":            lambda n: n.diffuse(.8),
    "rough_diffuse":      lambda n: n.diffuse(.8, 1),
    "rough_diffuse_dark": lambda n: n.diffuse(.01, 1),
    "metal_0":            lambda n: n.schlick(),
    "metal_3":            lambda n: n.metal(.3),
    "metal_7":            lambda n: n.metal(.7),
    "white_metal_3":      lambda n: n.glossy(.3),
    "white_metal_7":      lambda n: n.glossy(.7),
    "glass_0":            lambda n: n.glass(0),
    "glass_3":            lambda n: n.glass(.3),
    "plastic":            lambda n: n.principled(PLASTIC, Roughness=.4),
    "half_metal":         lambda n: n.principled(PLASTIC, Roughness=.4, Metallic=.5),
    "coat":               lambda n: n.principled(PLASTIC, Roughness=.4, Clearcoat=1, Clearcoat_Roughness=.1),
    "coat_on_diffuse":    lambda n: n.coated(n.diffuse(.8)),
    "coat_on_metal":      lambda n: n.coated(n.metal(.4)),
    "sheen":              lambda n: n.principled(PLASTIC, Roughness=.4, Sheen=1),
    "transmission":       lambda n: n.principled(WHITE, Roughness=.2, Transmission=1),
    "tinted":             lambda n: n.principled(METAL, Roughness=.2, Transmission=1),
    "emission":           lambda n: n.add(n.diffuse(.5), n.node("Emission", Color=(1, .5, .25, 1), Strength=2)),
}


def make_scene(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    look(scene, EYE, (0, 0, 0), VFOV)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=512, ring_count=256, radius=1)
    sphere = bpy.context.object
    bpy.ops.object.shade_smooth()
    add_map(scene, path)
    settings(scene, SIZE)
    depth(scene, 65)
    scene.cycles.samples = SPP
    if hasattr(scene.cycles, "use_light_tree"):
        scene.cycles.use_light_tree = False
    return scene, sphere


def render(scene, path, seed):
    """Linear RGB, top row first."""
    scene.cycles.seed = seed
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return take_pixels(path, SIZE)[::-1].astype(numpy.float64)


def regions():
    """What is more than a pixel inside the sphere's outline, its quarters, and what is more than one outside."""
    y, x = numpy.mgrid[:SIZE, :SIZE] + .5 - SIZE / 2
    distance = sum(e * e for e in EYE)
    outline = SIZE / 2 / math.sqrt(distance - 1) / math.tan(math.radians(VFOV / 2))
    r = numpy.hypot(x, y)
    sphere = r < outline - 1
    return {"sphere": sphere, "top_left": sphere & (x < 0) & (y < 0), "top_right": sphere & (x > 0) & (y < 0),
            "bottom_left": sphere & (x < 0) & (y > 0), "bottom_right": sphere & (x > 0) & (y > 0), "background": r > outline + 1}


def main():
    if "--" not in sys.argv or len(sys.argv) < sys.argv.index("--") + 3:
        sys.exit("usage: blender -b --factory-startup -P compare_materials.py -- MAP.hdr OUT [SETTING...]")
    path, out, *names = sys.argv[sys.argv.index("--") + 1:]
    out = os.path.abspath(out)
    os.makedirs(out, exist_ok=True)
    scene, sphere = make_scene(path)
    table, rows = os.path.join(out, "cycles.csv"), {}
    if os.path.exists(table):
        with open(table) as f:
            for line in f.read().split("\n")[1:]:
                rows.setdefault(line.split(",")[0], []).append(line)
        rows.pop("", None)
    for name in names or SETTINGS:
        n = Nodes(name)
        scene.world.cycles.sampling_method = "NONE" if name in BSDF_ALONE else "MANUAL"
        surface = SETTINGS[name](n)
        n.set(n.tree.nodes.new("ShaderNodeOutputMaterial").inputs[0], surface)
        sphere.data.materials.clear()
        sphere.data.materials.append(n.material)
        pictures = [render(scene, os.path.join(out, name + ".exr"), 1 + i) for i in range(SEEDS)]
        mean = sum(pictures) / SEEDS
        with open(os.path.join(out, name + ".pfm"), "wb") as f:
            f.write(b"PF\n%d %d\n-1\n" % (SIZE, SIZE) + mean[::-1].astype("<f4").tobytes())
        rows[name] = []
        for region, mask in regions().items():
            means = numpy.array([p[mask].mean(axis=0) for p in pictures])
            error = means.std(axis=0, ddof=1) / math.sqrt(SEEDS)
            numbers = ["%.7g" % v for v in list(means.mean(axis=0)) + list(error)]
            rows[name].append(",".join([name, region] + numbers))
        with open(table, "w") as f:
            f.write("setting,region,r,g,b,se_r,se_g,se_b\n")
            for lines in rows.values():
                f.write("\n".join(lines) + "\n")


main()
