"""Labels fit: no panel of ours is cut off where the Properties editor is as wide as Blender makes it."""

from itertools import pairwise
from types import SimpleNamespace

import bpy
import pytest

from blender_addon import ui
from blender_addon.ui import panel, simplify
from tests.engine import stage
from tests.engine.paper import REGION, Paper

# Pixels at scale 1, measured on screenshots of Blender 5.2: a row, the labels to the left of values, to the right of
# checkboxes, and of buttons with an icon.
ROW, LEFT, RIGHT, BUTTON = 263, 97, 134, 230


class Ruler(Paper):
    """Paper that keeps what does not fit."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: set[str] = set()
        self.cut: set[str] = set()

    def measure(self, text: str, room: float) -> None:
        self.seen.add(text)
        if panel.text_width(text) > room:
            self.cut.add(text)

    def prop(self, owner, name: str, text: str | None = None, **_options) -> None:
        item = owner.bl_rna.properties[name]
        self.measure(item.name if text is None else text, RIGHT if item.type == "BOOLEAN" else LEFT)

    def operator(self, name: str, text: str | None = None, icon: str = "NONE", **_options) -> SimpleNamespace:
        own = getattr(bpy.ops.bentlight, name.removeprefix("bentlight.")).get_rna_type().name
        self.measure(own if text is None else text, BUTTON)
        return SimpleNamespace()

    def label(self, text: str = "", icon: str = "NONE", **_options) -> None:
        self.measure(text, ROW if icon == "NONE" else BUTTON)

    def split(self, factor: float = 0.5) -> Paper:
        return SimpleNamespace(column=lambda: None, label=lambda text, **_: self.measure(text, ROW * (1 - factor)))

    def row(self, heading: str = "", **_options) -> Paper:
        self.measure(heading, LEFT)
        return self

    column = row


def states(hole: bpy.types.Object, scene: bpy.types.Scene):
    """Whatever changes what panels show."""
    settings = hole.bentlight
    yield
    settings.spin, settings.disk.enable, settings.disk.inner_edge = 0.7, True, "CUSTOM"
    scene.bentlight.accuracy = "CUSTOM"
    for stars, emission in zip(("OFF", "PROCEDURAL", "CATALOG"), ("POWER_LAW", "RAMP", "IMAGE"), strict=True):
        scene.world.bentlight.stars, settings.disk.emission = stars, emission
        yield
    settings.disk.emission = "MATERIAL"
    yield
    bpy.ops.bentlight.wormhole_add(location=(9, 0, 0), exit_location=(20, 0, 0))  # now there are spheres of influence
    yield
    settings.kind = "WORMHOLE"  # without an exit: an error
    yield


def drawn_on(ruler: Ruler, engine: str) -> None:
    """All panels of an engine, in every state."""
    stage.add_camera(location=(0, -9, 0))
    stage.set_world((0.1, 0.1, 0.1))
    bpy.ops.bentlight.black_hole_add(mass=1.0, location=(0, 0, 0))
    hole, scene = bpy.context.object, bpy.context.scene
    scene.render.engine = engine
    theirs = {cls for cls in ui.CLASSES if cls.__module__ in {simplify.__name__, "blender_addon.ui.overlay"}}
    for _ in states(hole, scene):
        bpy.context.view_layer.update()
        for obj in (hole, scene.camera):
            context = SimpleNamespace(
                engine=engine, scene=scene, view_layer=bpy.context.view_layer, object=obj, region=REGION,
                camera=scene.camera.data if obj == scene.camera else None, world=scene.world, material=None,
                evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
            )  # fmt: skip
            for cls in set(ui.CLASSES) - theirs:
                if not hasattr(cls, "poll") or cls.poll(context):
                    ruler.draw(cls, context)


@pytest.mark.parametrize("engine", ["BENTLIGHT", "CYCLES"])
def test_no_label_is_cut_off(engine):
    ruler = Ruler()
    drawn_on(ruler, engine)
    if engine == "CYCLES":
        bpy.context.view_layer.objects.active = bpy.data.objects["Black Hole"]
        bpy.context.object.bentlight.kind = "BLACK_HOLE"
        bpy.context.scene.world.bentlight.stars = "OFF"
        bpy.ops.bentlight.cycles_setup()
        bpy.ops.bentlight.relay_setup(bake=False)
        context = SimpleNamespace(scene=bpy.context.scene, region=REGION)
        for cls in ui.cycles.CLASSES:
            ruler.draw(cls, context)
    expected = {
        "BENTLIGHT": {"Photon Ring", "Noise Threshold", "Throat Radius", "Horizon (km)", "Frequency Shift"},
        "CYCLES": {"Lens in Cycles", "Shutter Slices", "Update Lenses", "Curved rays of 'Camera'"},
    }  # fmt: skip
    assert expected[engine] <= ruler.seen
    assert not ruler.cut


def test_long_texts_wrap_between_words():
    text = "the quick brown fox jumps over the lazy dog " * 4
    lines = panel.wrap(text, 150)
    assert " ".join(lines) == text.strip()
    assert max(map(panel.text_width, lines)) <= 150
    for line, after in pairwise(lines):  # no line could hold more
        assert panel.text_width(f"{line} {after.split()[0]}") > 150
    assert panel.wrap("incomprehensibilities", 20) == ["incomprehensibilities"]
