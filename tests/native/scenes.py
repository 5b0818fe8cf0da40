"""Small scenes for the render tests: materials, cameras, and a call that renders every channel."""

import numpy as np
from bentlight_native import CHANNELS, ProgramBuilder, RenderSettings, Scene

IDENTITY = np.eye(4)


def material(*closures, **named):
    """A program that adds closures, each (operation, operand values ..., [immediates]); weight 1 is put in front."""
    builder = ProgramBuilder()
    for name, *values in closures:
        immediates = values.pop() if values and isinstance(values[-1], list) else []
        builder.emit(name, builder.constant(1), *map(builder.constant, values), immediates=immediates)
    return builder.build()


def diffuse(color):
    return ("diffuse", color, 0, (0, 0, 0))


def emission(color, strength=1.0):
    return ("emission", color, strength)


def glossy(color, roughness):
    return ("glossy", color, roughness, (0, 0, 0), 0, 0, (0, 0, 0), ["GGX"])


def glass(color, roughness, ior):
    return ("glass", color, roughness, ior, (0, 0, 0), ["GGX"])


def transparent(color):
    return ("transparent", color)


def sky(color):
    """A sky of one color."""
    return material(emission(color))


def quad(half_x=1.0, half_y=1.0):
    """A rectangle in the plane z = 0 whose normal is +z."""
    corners = [(-half_x, -half_y, 0), (half_x, -half_y, 0), (half_x, half_y, 0), (-half_x, half_y, 0)]
    return np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def look_at(origin, target, up=(0, 0, 1)):
    """world_from_camera of a camera at `origin` that looks at `target`."""
    z = np.subtract(origin, target).astype(float)
    z /= np.linalg.norm(z)
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, np.cross(z, x), z, origin
    return matrix


def add(scene, mesh, *closures, at=IDENTITY, **instance):
    """Adds a mesh (vertices, triangles) with one material; returns the instance."""
    materials = np.array([scene.add_material(material(*closures))], np.int32) if closures else None
    return scene.add_instance(scene.add_mesh(*mesh), np.asarray(at, float), materials=materials, **instance)


def perspective(scene, at=IDENTITY, half=0.5, aspect=1.0, **clip):
    """A perspective camera whose image covers +-half upwards at distance 1."""
    scene.set_camera("PERSPECTIVE", at, (-half * aspect, half * aspect, -half, half), **clip)


def render(scene, width=16, height=16, samples=16, tile=None, names=tuple(CHANNELS), progress=None, **settings):
    """Renders a tile (default: the whole image); returns {channel: array} and the statistics."""
    x, y, w, h = tile or (0, 0, width, height)
    channels = {name: np.full((h, w, CHANNELS[name].components), np.nan, np.float32) for name in names}
    settings = RenderSettings(width, height, sample_count=samples, **settings)
    statistics = scene.render_tile(x, y, w, h, settings, channels, progress)
    return channels, statistics


def new_scene(sky_color=None):
    scene = Scene()
    if sky_color is not None:
        scene.set_world(sky(sky_color))
    return scene
