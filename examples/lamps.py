"""Every kind of lamp around a black hole: a stage at night.

A hole floats within a circle of white columns. Each lamp shows what it is by its light:

  point, no size         the lantern on the left: hard shadows of the columns, which the hole bends as they pass it
  point, a sphere        the amber bulb on the right, soft shadows
  spot, no size          the stripes that a projector throws onto the wall on the right
  spot, soft             the pool of light with the blended edge on the left
  sun                    faint moonlight from the right
  area, rectangle        the two neon tubes
  area, disk             the plate behind the hole, which is seen as a ring around it
  area, square, spread   the narrow shaft from above, onto the white ball
  area, ellipse          the dim sheet over the scene

All of them cast shadows along every curve on which light goes around the hole.
"""

import math

import bpy
import common
import materials
import objects

MASS = 0.08
CENTER = (0.0, 0.0, 1.25)
COLUMNS, CIRCLE = 14, 2.3
AMBER, TEAL, ROSE, MOON = (1.0, 0.55, 0.2), (0.02, 0.6, 0.75), (1.0, 0.06, 0.3), (0.45, 0.6, 1.0)


def lamp(
    kind: str,
    name: str,
    location: objects.Vector,
    target: objects.Vector,
    energy: float,
    color: materials.Color,
    **more: object,
) -> bpy.types.Object:
    """A lamp of any kind that shines at the target; it is seen itself if `visible` says so."""
    visible = more.pop("visible", False)
    light = bpy.data.lights.new(name, kind)
    light.energy, light.color = energy, color
    for key, value in more.items():
        setattr(light, key, value)
    thing = objects.place(bpy.data.objects.new(name, light), location=location)
    objects.look_at(thing, target)
    thing.visible_camera = visible
    return thing


def stripes(thing: bpy.types.Object, count: float) -> None:
    """Makes a spot a projector of stripes."""
    thing.data.use_nodes = True
    tree = thing.data.node_tree
    emission = next(node for node in tree.nodes if node.type == "EMISSION")
    place, wave = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexWave")
    wave.inputs["Scale"].default_value = count / 3.18  # of the node: a period is pi / 10
    tree.links.new(place.outputs["UV"], wave.inputs["Vector"])
    tree.links.new(wave.outputs["Color"], emission.inputs["Color"])


def build_stage() -> None:
    """Floor, wall, a circle of columns, and what lies about."""
    floor = materials.principled("Floor", (0.30, 0.29, 0.28), roughness=0.3)
    wall = materials.principled("Wall", (0.35, 0.35, 0.38), roughness=0.9)
    plaster = materials.principled("Plaster", (0.78, 0.76, 0.72), roughness=0.6)
    brass = materials.principled("Brass", (0.95, 0.68, 0.3), metallic=1.0, roughness=0.18)
    objects.quad("Floor", (-14, -10, 0), (28, 0, 0), (0, 26, 0), floor)
    objects.quad("Wall", (-14, 6.5, 0), (28, 0, 0), (0, 0, 9), wall)
    for i in range(COLUMNS):
        angle = 2 * math.pi * (i + 0.5) / COLUMNS - math.pi / 2
        x, y = CIRCLE * math.cos(angle), CIRCLE * math.sin(angle)
        height = 1.3 if y > -1 else 0.4  # those in front are cut, or they would hide the hole
        bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=0.08, depth=height, location=(x, y, height / 2))
        objects.place(bpy.context.object, plaster)
    objects.sphere("Pearl", (1.2, -1.35, 0.32), 0.32, plaster)
    objects.sphere("Brass ball", (-1.2, -1.4, 0.3), 0.3, brass)
    objects.sphere(
        "Glass ball", (0.0, -1.7, 0.22), 0.22, materials.shader("Glass", "BsdfGlass", Roughness=0.0, IOR=1.45)
    )


def build_lamps() -> None:
    """One of each kind, and two neon tubes."""
    lamp("POINT", "Lantern", (-3.0, 1.1, 1.9), CENTER, 330, AMBER, shadow_soft_size=0.0)
    bulb = {"shadow_soft_size": 0.16, "use_soft_falloff": False, "visible": True}
    lamp("POINT", "Bulb", (3.3, 1.2, 0.35), CENTER, 14, AMBER, **bulb)
    cone = {"shadow_soft_size": 0.0, "spot_size": 0.7, "spot_blend": 0.15}
    stripes(lamp("SPOT", "Projector", (2.3, 1.8, 5.2), (2.5, 6.5, 1.9), 1500, TEAL, **cone), 9)
    cone = {"shadow_soft_size": 0.25, "spot_size": 0.9, "spot_blend": 0.9}
    lamp("SPOT", "Pool", (-2.3, 1.8, 5.2), (-2.5, 6.5, 1.9), 1500, ROSE, **cone)
    lamp("SUN", "Moon", (5, -4, 5), (0, 0, 0), 0.1, MOON, angle=0.01)
    tube = {"shape": "RECTANGLE", "size": 0.1, "size_y": 2.4, "visible": True}
    for side, color in ((-1, ROSE), (1, TEAL)):
        lamp("AREA", "Neon", (3.9 * side, 4.4, 1.3), (0, -1.0, 1.3), 4, color, **tube)
    plate = {"shape": "DISK", "size": 0.75, "visible": True}
    lamp("AREA", "Plate", (0.06, 5.4, 0.78), (0, -7, 2.0), 6, (1.0, 0.5, 0.12), **plate)
    shaft = {"shape": "SQUARE", "size": 0.5, "spread": math.radians(16)}
    lamp("AREA", "Shaft", (1.2, -1.35, 4.5), (1.2, -1.35, 0), 11, (1.0, 0.95, 0.9), **shaft)
    lamp("AREA", "Sheet", (0, -2, 6), (0, 0, 0), 30, MOON, shape="ELLIPSE", size=6.0, size_y=3.0)


def build() -> bpy.types.Scene:
    """Makes the stage in the current file and returns its scene."""
    scene = common.new_scene(samples=128, resolution=(800, 450))
    objects.set_world((0.004, 0.005, 0.009))
    build_stage()
    build_lamps()
    bpy.ops.bentlight.black_hole_add(mass=MASS, location=CENTER)
    objects.camera((0.0, -7.4, 2.1), (0.0, 0.0, 1.12), lens_mm=36)
    scene.bentlight.max_bounces = 6
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    return scene


if __name__ == "__main__":
    common.main(build, "lamps.png")
