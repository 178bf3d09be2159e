"""What accuracy costs: meshes of a scene, patches of an image, and the price list made of them."""

import csv
import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import tracer_scenes
from patch_bodies import ball_patches

import glassworkbench as gw
from glassworkbench.cli import main
from glassworkbench.images import read_image
from glassworkbench.pricing.meshing import DENSITIES, meshed, triangle_count
from glassworkbench.pricing.survey import Survey, _power_law, error
from glassworkbench.scene import Body, Ellipsoid, Environment, Medium, Mesh, Pinhole, Scene
from glassworkbench.tracer import native, plan
from glassworkbench.tracer.pilot import PATCH, Pilot, patches
from glassworkbench.tracer.plan import EFFECTS

pytestmark = pytest.mark.skipif(not native.available(), reason="the native tracer is not built")

BODIES = {
    "turned ball": (lambda: tracer_scenes.revolved_ball(20.0), 4.0 / 3.0 * np.pi * 20.0**3),
    "lying cylinder": (
        lambda: tracer_scenes.cylinder(10.0, -5.0, 25.0, axis=(1.0, 0.0, 0.0), base_mm=(3.0, 4.0, 5.0)),
        np.pi * 100.0 * 30.0,
    ),
    "ellipsoid": (lambda: Ellipsoid((1.0, 2.0, 3.0), (5.0, 10.0, 20.0)), 4.0 / 3.0 * np.pi * 1000.0),
    "ball of patches": (lambda: ball_patches(20.0), 4.0 / 3.0 * np.pi * 20.0**3),
}


def scene_of(surface, size=(32, 32)):
    """A glass body under a sky that is bright on one side."""
    sky = np.linspace(0.1, 1.0, 16)[None, :, None] * np.ones((8, 1, 3))
    camera = Pinhole((0.0, -300.0, 10.0), (0.0, 0.0, 0.0), 0.2)
    return Scene(
        (Body("glass", surface),), (Medium("glass", 1.5, (0.01, 0.0, 0.02)),), (Environment(sky),), camera, size
    )


def volume_mm3(mesh):
    a, b, c = (mesh.vertices_mm[mesh.triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


@pytest.mark.parametrize("name", BODIES)
def test_each_denser_mesh_is_nearer_to_the_body(name):
    make, volume = BODIES[name]
    scenes = [meshed(scene_of(make()), density) for density in range(DENSITIES)]
    off = [abs(volume_mm3(scene.bodies[0].surface) / volume - 1.0) for scene in scenes]
    assert off[0] < 0.06
    assert all(finer < 0.4 * coarser for coarser, finer in pairwise(off))
    assert triangle_count(scenes[-1]) > 3 * triangle_count(scenes[0])


@pytest.mark.parametrize("name", BODIES)
def test_normals_of_a_mesh_point_outwards_along_the_surface(name):
    mesh = meshed(scene_of(BODIES[name][0]()), 2).bodies[0].surface
    corners = mesh.vertices_mm[mesh.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    assert np.einsum("mkj,mj->mk", mesh.normals[mesh.triangles], facets).min() > 0.95
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0)


def test_a_mesh_stays_the_mesh_it_is():
    box = tracer_scenes.box_mesh((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert meshed(scene_of(box), 0).bodies[0].surface is box


@pytest.mark.parametrize("size", [(30, 44), (64, 16), (5, 3)])
def test_patches_cover_the_image_once_and_any_beginning_covers_it_evenly(size):
    box = tracer_scenes.box_mesh((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    scene = scene_of(box, size)
    parts = patches(scene)
    assert np.all(np.sum([part.mask(size) for part in parts], axis=0) == 1)
    half = [part.left + 0.5 * part.width for part in parts[: len(parts) // 2]]
    assert not half or abs(np.mean(half) / size[0] - 0.5) < 0.15 or size[0] <= PATCH


def test_of_an_image_that_mirrors_itself_half_is_tried():
    scene = replace(scene_of(tracer_scenes.revolved_ball(20.0)), lights=(Environment(1.0),))
    assert sum(part.width * part.height for part in patches(scene)) == 16 * 32
    assert Pilot(scene, plan(scene, 0.1), 1, gw.Cancel()).pixels == 16 * 32


def test_a_patch_shows_what_the_image_shows_there():
    scene = scene_of(tracer_scenes.revolved_ball(20.0))
    image = gw.render(scene, tolerance=0.05)
    parts = patches(scene)[3:7]
    pilot = Pilot(scene, plan(scene, 0.1), 1, gw.Cancel())
    pilot.trace(parts[1:3], plan(scene, 0.1))
    cost, radiance = pilot.trace(parts, plan(scene, 0.05))
    assert np.all(cost > 0.0)
    expected = np.concatenate([part.cut(image.pixels).reshape(-1, 3) for part in parts])
    assert np.array_equal(radiance, expected.astype(np.float64))


def test_a_power_law_is_met_between_what_is_known_and_beyond():
    tolerances = np.array([0.1, 0.01, 0.001])
    for at in (0.03, 0.01, 1e-5):
        assert _power_law(at, tolerances, 2.0 * tolerances**-0.5, (-1.5, 0.0)) == pytest.approx(2.0 * at**-0.5)
    # Falling seconds are noise: nothing gets cheaper by being finer.
    assert _power_law(1e-5, tolerances, tolerances, (-1.5, 0.0)) == pytest.approx(0.001)


def test_where_the_pilot_sees_the_whole_image_it_tells_the_very_error():
    scene = scene_of(tracer_scenes.revolved_ball(20.0))
    survey = Survey(scene, (0.1, 0.01), 1000.0, 1, gw.Cancel())
    coarse, fine = (gw.render(scene, tolerance=t, effects=dict.fromkeys(EFFECTS, True)) for t in (0.1, 0.01))
    assert survey.exact(0.1)[1] == pytest.approx(error(coarse.pixels.astype(float), fine.pixels.astype(float)))


@pytest.fixture(scope="module")
def measured():
    scene = scene_of(tracer_scenes.revolved_ball(20.0))
    return gw.accuracy(scene, tolerances=(0.1, 0.01), seconds=100.0, measure=True)


def test_a_price_list_names_every_way_to_render(measured):
    kinds = [price.kind for price in measured.prices]
    assert kinds.count("exact") == 2
    assert kinds.count("mesh") == DENSITIES
    assert kinds.count("unbent") == 1
    assert {price.name.split()[0] for price in measured.prices if price.kind == "effect"} == set(EFFECTS)
    assert all(price.seconds > 0.0 for price in measured.prices)


def test_what_leaves_more_out_is_more_wrong_and_predicted_so(measured):
    by_name = {price.name: price for price in measured.prices}
    unbent, without = by_name["unbent"], by_name["absorption off"]
    meshes = [price for price in measured.prices if price.kind == "mesh"]
    assert min(unbent.error, without.error) > meshes[-1].error
    assert meshes[0].error > meshes[1].error
    for price in (unbent, without, *meshes):
        assert price.predicted_error == pytest.approx(price.error, rel=0.3)


def test_a_price_list_is_saved_as_table_data_plot_and_crops(measured, tmp_path):
    measured.save(tmp_path / "new")
    names = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert names == ["crops.png", "prices.csv", "prices.json", "prices.png", "prices.svg"]
    told = json.loads((tmp_path / "new" / "prices.json").read_text())
    with open(tmp_path / "new" / "prices.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == [price["name"] for price in told["prices"]]
    assert float(rows[0]["error"]) == told["prices"][0]["error"]
    assert read_image(tmp_path / "new" / "prices.png").pixels.std() > 0.01
    assert len({image.pixels.shape for _, image in measured.crops}) == 1


def test_meshes_are_not_compared_where_all_is_mesh_already():
    box = tracer_scenes.box_mesh((-9.0, -9.0, -9.0), (9.0, 9.0, 9.0))
    assert isinstance(box, Mesh)
    prices = gw.accuracy(scene_of(box, (16, 16)), tolerances=(0.1,)).prices
    assert "mesh" not in {price.kind for price in prices}
    assert all(price.seconds is None for price in prices)


def test_too_few_seconds_are_told_with_what_it_takes():
    with pytest.raises(gw.InputError, match=r"^seconds: 1e-06 is too few, the image at a tolerance of 0.1 takes about"):
        gw.accuracy(scene_of(tracer_scenes.revolved_ball(20.0)), tolerances=(0.1,), seconds=1e-6)


@pytest.mark.parametrize(
    "arguments", [{"seconds": 0.0}, {"threads": 0}, {"tolerances": ()}, {"tolerances": (0.1, -1.0)}]
)
def test_bad_arguments_are_refused(arguments):
    with pytest.raises(gw.InputError, match=rf"^{next(iter(arguments))[:-1]}"):
        gw.accuracy(scene_of(tracer_scenes.revolved_ball(20.0)), **arguments)


def test_a_price_list_is_cancelled():
    cancel = gw.Cancel()
    cancel.set()
    with pytest.raises(gw.Cancelled):
        gw.accuracy(scene_of(tracer_scenes.revolved_ball(20.0)), cancel=cancel)


SCENE_FILE = "examples/scenes/ball_lens.toml"


def test_the_verb_prints_a_table_and_fills_a_folder(tmp_path, capsys):
    assert main(["accuracy", SCENE_FILE, "--size", "12x16", "--seconds", "20", "-o", str(tmp_path / "prices")]) == 0
    out, err = capsys.readouterr()
    assert "exact at 0.01" in out
    assert err == ""
    assert (tmp_path / "prices" / "prices.svg").is_file()


def test_a_folder_that_cannot_be_written_is_told_before_the_work(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "missing" / "prices", tmp_path / "file" / "prices"):
        assert main(["accuracy", SCENE_FILE, "-o", str(folder)]) == 2
        assert capsys.readouterr().err.startswith(f"glassworkbench: {folder}: ")


def test_bad_input_leaves_no_folder(tmp_path, capsys):
    assert main(["accuracy", "nothing.toml", "-o", str(tmp_path / "prices")]) == 2
    assert not (tmp_path / "prices").exists()
