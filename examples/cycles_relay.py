"""Cycles shades along curved camera rays: a lacquered monkey in orbit around a black hole, at four times its mass.

The lacquer is made of nodes that only Cycles has to know. Bentlight traces the camera's rays around the hole to the
surfaces that they meet (the relay camera), and Cycles renders from there on; what surfaces scatter is bent by the lens
around the hole. So the monkey is seen twice: before the hole, and drawn out along its other side. The ring of light is
the glow behind the camera, whose rays have turned around.
"""

import math

import bpy
import common
import materials
import numpy as np
import objects

MASS = 0.5
ORBIT = 4 * MASS
_GOLD, _TEAL = (0.95, 0.55, 0.14, 1.0), (0.02, 0.30, 0.30, 1.0)
# direction, color, sharpness, radiance in the middle
_GLOWS = (
    ((-0.55, -0.75, 0.45), (1.0, 0.80, 0.58), 24, 34.0),
    ((0.75, 0.25, 0.45), (0.25, 0.60, 1.0), 50, 20.0),
    ((-0.9, 0.2, -0.5), (1.0, 0.25, 0.45), 30, 5.0),
)


def lacquer() -> bpy.types.Material:
    """Cells of gold in teal under clear coat, all by Cycles' own nodes."""
    material = materials.principled("Lacquer", roughness=0.28, metallic=0.5, coat_weight=1.0, coat_roughness=0.04)
    new, links = material.node_tree.nodes.new, material.node_tree.links
    shader = material.node_tree.nodes["Principled BSDF"]
    cells, ramp, bump = (new(f"ShaderNode{kind}") for kind in ("TexVoronoi", "ValToRGB", "Bump"))
    place = new("ShaderNodeTexCoord")
    cells.feature = "DISTANCE_TO_EDGE"
    cells.inputs["Scale"].default_value = 3.2
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.02, _GOLD
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.055, _TEAL
    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.4, 0.1
    links.new(place.outputs["Object"], cells.inputs["Vector"])
    links.new(cells.outputs["Distance"], ramp.inputs["Fac"])
    links.new(cells.outputs["Distance"], bump.inputs["Height"])
    links.new(ramp.outputs["Color"], shader.inputs["Base Color"])
    links.new(bump.outputs["Normal"], shader.inputs["Normal"])
    return material


def build_sky(height: int = 512) -> None:
    """A band of nebula as in long exposures, and three soft glows that light the scene as a photographer would."""
    elevation = (np.arange(height) + 0.5)[:, None] / height * math.pi - math.pi / 2
    azimuth = (0.5 - (np.arange(2 * height) + 0.5)[None, :] / (2 * height)) * 2 * math.pi
    cosines = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
    direction = np.stack(np.broadcast_arrays(*cosines), axis=-1)
    cloud, haze = _clouds(direction, 5, 7), _clouds(direction, 3, 2)
    across = direction @ np.array((0.30, -0.12, 0.95)) - 0.15 * haze
    band = np.exp(-((across / 0.28) ** 2)) * (0.35 + 0.9 * cloud).clip(0) ** 1.5
    amber, blue = np.array((1.30, 0.48, 0.22)), np.array((0.16, 0.32, 0.95))
    sky = 0.05 * blue + band[..., None] * (
        amber * (0.5 + haze).clip(0, 1)[..., None] + blue * (0.6 - haze).clip(0)[..., None]
    )
    for toward, color, sharpness, radiance in _GLOWS:
        near = (direction @ (np.array(toward) / np.linalg.norm(toward))).clip(0)
        sky += radiance * np.array(color) * (near**sharpness)[..., None]
    pixels = np.concatenate([0.8 * sky, np.ones((height, 2 * height, 1))], axis=-1)
    objects.set_world_image(materials.float_image("Nebula", pixels))
    bpy.context.scene.world.cycles.sampling_method = "NONE"  # lenses block what lights would be aimed at


def _clouds(direction: np.ndarray, octaves: int, seed: int) -> np.ndarray:
    """Smooth noise of directions, about -1 to 1: plane waves of growing frequency, bent by one another."""
    random, total = np.random.default_rng(seed), np.zeros(direction.shape[:2])
    for octave in range(octaves):
        for _ in range(6):
            wave = random.normal(size=3) * 2.0 * 1.9**octave
            total += 0.62**octave * np.cos(direction @ wave + 1.5 * total + random.uniform(0, 2 * math.pi)) / 3
    return total


def build(angle_deg: float = 226.0) -> bpy.types.Scene:
    """Makes the scene in the current file, the monkey at this angle of its orbit, and returns it ready for Cycles."""
    scene = common.new_scene("CYCLES", samples=128)
    scene.view_settings.exposure = 0.4
    build_sky()
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=(0, 0, 0))
    angle = math.radians(angle_deg)
    center = (ORBIT * math.sin(angle), ORBIT * math.cos(angle), 0.1)
    objects.suzanne(center, 2.9, 8.0, lacquer())
    objects.camera((-0.3, -11.0, 1.2), (-0.3, 0.0, 0.0), 36)
    bpy.ops.bentlight.cycles_setup()
    bpy.ops.bentlight.relay_setup(bake=False)
    return scene


if __name__ == "__main__":
    common.main(build, "cycles_relay.png", "CYCLES")
