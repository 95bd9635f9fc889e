"""What compare_materials.py and race_cycles.py share: our world in Blender's, and the settings under which Cycles means the
same as pt.h. Made for Blender 3.4.

pt.h looks at a map's middle along -z, with +x to its right and +y up; Cycles along +x, with -y to its right and +z up.
So (x, y, z) there is (-z, -x, y) here, and the map needs no turning.
"""
import math
import os

import bpy
import numpy
from mathutils import Vector


def here(v):
    return Vector((-v[2], -v[0], v[1]))


def look(scene, eye, target, vfov):
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.sensor_height, lens.sensor_width = "VERTICAL", 24, 24
    lens.lens = 12 / math.tan(math.radians(vfov / 2))
    lens.clip_start = 1e-4
    camera = bpy.data.objects.new("camera", lens)
    camera.location = here(eye)
    camera.rotation_euler = (here(target) - here(eye)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera


def add_map(scene, path):
    """Sampled at its full width."""
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    sky = tree.nodes.new("ShaderNodeTexEnvironment")
    sky.image = bpy.data.images.load(os.path.abspath(path))
    sky.image.colorspace_settings.name = "Non-Color"
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(sky.outputs[0], background.inputs[0])
    tree.links.new(background.outputs[0], output.inputs[0])
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = sky.image.size[0]
    scene.world = world


def depth(scene, events):
    """Blender counts bounces after the first surface that is seen."""
    c = scene.cycles
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = events - 1


def settings(scene, size):
    """No denoising, no clamping, no thresholds; roulette as it likes; a box filter one pixel wide; linear pictures."""
    scene.render.engine = "CYCLES"
    c, r = scene.cycles, scene.render
    c.device, c.use_adaptive_sampling, c.use_denoising = "CPU", False, False
    c.sample_clamp_direct = c.sample_clamp_indirect = c.blur_glossy = c.light_sampling_threshold = 0
    c.caustics_reflective = c.caustics_refractive = True
    c.min_light_bounces = 0
    c.pixel_filter_type = "BOX"
    r.resolution_x = r.resolution_y = size
    r.resolution_percentage = 100
    r.film_transparent = r.use_compositing = r.use_sequencer = False
    r.use_persistent_data = True
    r.dither_intensity = 0
    r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Raw"


def take_pixels(path, size):
    """Linear RGB, bottom row first, of the picture that was rendered to path, which is removed."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    pixels = numpy.empty(size * size * image.channels, dtype=numpy.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(size, size, image.channels)[:, :, :3]
    bpy.data.images.remove(image)
    os.remove(path)
    return pixels
