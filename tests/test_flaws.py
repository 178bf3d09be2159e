"""Defects in the wall of a container: place and geometry, what does not fit, files, populations."""

from dataclasses import replace

import numpy as np
import pytest

import glassworkbench as gw
from glassworkbench.cli import main
from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.flaws import (
    KINDS,
    BirdSwing,
    Blister,
    Check,
    Cord,
    Seed,
    Spike,
    Split,
    Stone,
    day,
    make_defect,
    parse_defects,
    populations,
    read_defects,
    sample,
    with_defects,
)
from glassworkbench.flaws.fitting import fit, fitted
from glassworkbench.flaws.glass_wall import GlassWall
from glassworkbench.flaws.kinds import IN_GLASS
from glassworkbench.scene import ContainerGeometry, Environment, Revolved
from glassworkbench.staging import sample_container, station
from glassworkbench.tracer import native, reference

FRONT = -90.0
TUMBLER = sample_container()


def polyline(*points):
    points = np.array(points, dtype=float)
    steps = np.linspace(0.0, 1.0, 4)[None, :, None]
    lines = points[:-1, None] * (1.0 - steps) + points[1:, None] * steps
    return Revolved(np.concatenate([lines, np.ones((*lines.shape[:2], 1))], axis=2))


def can(wall=3.0):
    """A straight cylinder of 30 mm radius and 100 mm height, with a floor as thick as its wall."""
    outer = polyline((0, 0), (30, 0), (30, 100), (0, 100))
    cavity = polyline((0, wall), (30 - wall, wall), (30 - wall, 110), (0, 110))
    return ContainerGeometry(outer, cavity, (-30, -30, 0), (30, 30, 100), 100.0)


def path(defects, height, angle_deg, geometry=None):
    """The bodies that a ray meets which comes from outside straight to the axis, with what holds after each."""
    geometry = geometry or can()
    scene = with_defects(station("sidewall", geometry, "flint"), geometry, defects)
    angle = np.radians(angle_deg)
    outward = np.array([np.cos(angle), np.sin(angle), 0.0])
    follow = native.follow if native.available() else reference.follow
    crossings = follow(scene, 50.0 * outward + (0.0, 0.0, height), -outward)
    indices = scene.refractive_indices()
    return [
        (
            crossing.body.rpartition("_")[0] or crossing.body,
            30.0 - outward @ crossing.point_mm,
            indices[crossing.medium_after],
        )
        for crossing in crossings
    ]


def test_a_site_is_where_the_wall_is_and_looks_outward():
    (site, floor, above) = GlassWall(can(2.5)).sites([50.0, 1.0, 100.5], [30.0, 0.0, 0.0])
    outward = np.array([np.cos(np.pi / 6), 0.5, 0.0])
    np.testing.assert_allclose(site.outside_mm, 30.0 * outward + (0.0, 0.0, 50.0), atol=1e-9)
    np.testing.assert_allclose(site.frame, np.column_stack([(-0.5, outward[0], 0.0), (0, 0, 1), outward]), atol=1e-6)
    assert site.wall_mm == pytest.approx(2.5, abs=1e-6)
    assert floor.wall_mm == pytest.approx(60.0, abs=1e-6)
    assert above is None


def test_a_seed_is_a_ball_of_air_at_its_depth():
    met = path([Seed(height_mm=50, angle_deg=40, diameter_mm=0.8, depth_mm=1.0)], 50, 40)
    assert [name for name, _, _ in met[:4]] == ["outer", "air", "air", "cavity"]
    np.testing.assert_allclose([depth for _, depth, _ in met[:4]], [0.0, 0.6, 1.4, 3.0], atol=1e-6)
    np.testing.assert_allclose([index for _, _, index in met[:4]], [1.52338, 1.0, 1.52338, 1.0], atol=1e-5)


def test_a_blister_is_flat_and_lies_in_the_middle_of_the_wall():
    ((_, grain),) = fitted(can(), [Blister(height_mm=50, angle_deg=90)]).grains
    np.testing.assert_allclose(grain.centre_mm, (0.0, 28.5, 50.0), atol=1e-6)
    reach = np.abs(grain.rotation) @ grain.semi_axes_mm
    np.testing.assert_allclose(reach, (1.5, 0.4, 2.5), atol=1e-5)


def test_a_stone_is_opaque_and_its_halo_has_an_index_of_its_own():
    stone = Stone(height_mm=50, angle_deg=10, diameter_mm=1.0, halo_mm=0.6, halo_index_offset=0.01)
    met = path([stone], 50, 10)
    assert [name for name, _, _ in met[:6]] == ["outer", "halo", "corundum", "corundum", "halo", "cavity"]
    np.testing.assert_allclose([depth for _, depth, _ in met[:6]], [0.0, 0.8, 1.0, 2.0, 2.2, 3.0], atol=1e-6)
    np.testing.assert_allclose(
        [index for _, _, index in met[:6]], [1.52338, 1.53338, 1.765, 1.53338, 1.52338, 1.0], atol=1e-5
    )
    scene = with_defects(station("sidewall", can(), "flint"), can(), [stone])
    assert scene.media[0].where.startswith("corundum")
    assert np.exp(-scene.media[0].absorption_per_mm * 1.0).max() < 1e-9


def test_a_check_is_a_film_of_air_and_may_be_open():
    flat = Check(height_mm=50, angle_deg=0, tilt_deg=90, opening_mm=0.01, across_mm=1.0, length_mm=2.0)
    met = path([flat], 50, 0)
    assert [name for name, _, _ in met[:4]] == ["outer", "air", "air", "cavity"]
    assert met[2][1] - met[1][1] == pytest.approx(0.01, rel=1e-4)
    ((_, grain),) = fitted(can(), [Check(height_mm=50, angle_deg=0, tilt_deg=0, direction_deg=0)]).grains
    np.testing.assert_allclose(np.abs(grain.rotation[:, 2]), (0, 0, 1), atol=1e-6)
    assert not fit(can(), [Check(height_mm=50, angle_deg=0, across_mm=5.0, tilt_deg=0)]).faults


def test_a_split_goes_through_the_wall():
    split = Split(height_mm=50, angle_deg=0, tilt_deg=0, direction_deg=90)
    ((_, grain),) = fitted(can(), [split]).grains
    middle = grain.centre_mm
    for radius in (29.99, 28.5, 27.01):
        across = (np.array([radius, 0.0, 50.0]) - middle) @ grain.rotation / grain.semi_axes_mm
        assert np.linalg.norm(across) < 1.0


def test_a_cord_bends_light_as_its_index_says():
    met = path([Cord(height_mm=50, angle_deg=0, index_offset=-0.004)], 50, 0)
    assert [name for name, _, _ in met[:4]] == ["outer", "cord", "cord", "cavity"]
    assert met[1][2] == pytest.approx(1.51938, abs=1e-5)
    assert met[2][1] - met[1][1] == pytest.approx(0.6, abs=1e-5)


def test_a_bird_swing_is_glass_from_wall_to_wall_that_joins_it():
    met = path([BirdSwing(height_mm=50, angle_deg=0)], 50, 0)
    # Along its axis no face is met but where the ray comes in and goes out of the container.
    assert [name for name, _, _ in met] == ["outer", "outer"]
    met = path([BirdSwing(height_mm=50, angle_deg=0, diameter_mm=0.8)], 50, 90)
    assert [name for name, _, _ in met[:4]] == ["outer", "cavity", "thread", "thread"]
    assert met[3][1] - met[2][1] == pytest.approx(0.8, abs=1e-6)


def test_a_spike_stands_as_far_into_the_cavity_as_it_is_long():
    met = path([Spike(height_mm=50, angle_deg=0, length_mm=8.0)], 50, 0)
    assert [name for name, _, _ in met[:2]] == ["outer", "thread"]
    assert met[1][1] == pytest.approx(11.0, abs=1e-5)


def test_a_filling_flows_around_a_thread():
    scene = station("sidewall", can(), "flint", "water:60")
    seen = with_defects(scene, can(), [BirdSwing(height_mm=50, angle_deg=0)])
    table, names = seen.medium_table(), [body.name for body in seen.bodies]
    bits = sum(1 << names.index(name) for name in ("outer", "cavity", "fill"))
    assert seen.media[table[bits] - 1].refractive_index == pytest.approx(1.333, abs=1e-3)
    assert seen.media[table[bits | 1 << names.index("thread_1")] - 1].refractive_index == pytest.approx(1.523, abs=1e-3)


@pytest.mark.skipif(not native.available(), reason="the native tracer is not built")
def test_a_container_with_every_kind_neither_leaks_nor_loses_light():
    names = [kind.kind for kind in IN_GLASS]
    kinds = [make_defect({"kind": name, "height_mm": 25 + 8 * k, "angle_deg": 43 * k}) for k, name in enumerate(names)]
    defects = [replace(defect, length_mm=8.0) if isinstance(defect, Cord) else defect for defect in kinds]
    scene = with_defects(station("sidewall", TUMBLER, "flint"), TUMBLER, defects)
    clear = tuple(replace(medium, absorption_per_mm=np.zeros(3)) for medium in scene.media)
    furnace = replace(scene, media=clear, lights=(Environment(1.0),))
    rng = np.random.default_rng(2)
    targets = rng.uniform((-40, -40, 0), (40, 40, 90), (20_000, 3))
    origins = rng.normal(size=targets.shape)
    origins *= 200.0 / np.linalg.norm(origins, axis=1, keepdims=True)
    answer = native.radiance(furnace, origins, targets - origins)
    assert answer.leaks.sum() == 0
    np.testing.assert_allclose(answer.radiance[:, 0] + answer.left_out[:, 0], 1.0, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("defect", "words"),
    [
        (
            Seed(height_mm=120, angle_deg=0),
            r"seed at 120 mm, 0 deg: there is no wall at this height; .* reaches to 100 mm",
        ),
        (Seed(height_mm=50, angle_deg=0, depth_mm=3.5), r"3.5 mm deep, lies outside the wall, which is 3 mm thick"),
        (Seed(height_mm=50, angle_deg=0, depth_mm=0.2), r"reaches out of the wall"),
        (Blister(height_mm=50, angle_deg=0, thickness_mm=3.2), r"blister at 50 mm, 0 deg: it reaches out of the wall"),
        (Cord(height_mm=50, angle_deg=0, direction_deg=0), r"cord .* reaches out of the wall"),
        (Check(height_mm=50, angle_deg=0, depth_mm=9), r"check .* lies outside the wall"),
        (BirdSwing(height_mm=50, angle_deg=0, root_diameter_mm=40), r"root of 40 mm reaches out of the wall"),
        (BirdSwing(height_mm=1, angle_deg=0), r"bird swing at 1 mm, 0 deg: the glass reaches to the axis"),
    ],
)
def test_what_does_not_lie_in_the_wall_is_named(defect, words):
    with pytest.raises(InputError, match=words):
        fitted(can(), [Seed(height_mm=80, angle_deg=0), defect])


def test_defects_that_overlap_are_both_named_and_a_stone_may_lie_in_its_own_halo():
    stone, seed = Stone(height_mm=50, angle_deg=0), Seed(height_mm=51, angle_deg=0)
    with pytest.raises(InputError, match="seed at 51 mm, 0 deg overlaps with stone at 50 mm, 0 deg; move one"):
        fitted(can(), [stone, seed])
    assert not fit(can(), [stone, replace(seed, height_mm=53)]).faults


def test_more_substances_than_bodies_are_refused():
    cords = [Cord(height_mm=50, angle_deg=20 * k, index_offset=0.001 * (k + 1)) for k in range(15)]
    with pytest.raises(InputError, match="at most 16; give stones one mineral"):
        with_defects(station("sidewall", can(), "flint"), can(), cords)


FILE = """
[[defect]]
kind = "seed"
height_mm = 50
angle_deg = -90
diameter_mm = 0.7

[[defect]]
kind = "stone"
height_mm = 30
angle_deg = 10
mineral = "zirconia"
class = "critical"
"""


def test_a_file_lists_defects(tmp_path):
    file = tmp_path / "d.toml"
    file.write_text(FILE)
    seed, stone = read_defects(file)
    assert seed == Seed(height_mm=50, angle_deg=-90, diameter_mm=0.7)
    assert stone == Stone(height_mm=30, angle_deg=10, mineral="zirconia", severity="critical")
    assert parse_defects(str(file)).on(can()) == (seed, stone)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("diameter_mm", "diametre_mm", r"defect 1: seed: key 'diametre_mm' .* did you mean 'diameter_mm'"),
        ('"seed"', '"sead"', r"defect 1: kind 'sead' .* did you mean 'seed'"),
        ("0.7", "-1", r"defect 1: seed: diameter_mm: must be above 0"),
        ("0.7", '"big"', r"defect 1: seed: diameter_mm: expected numbers"),
        ("height_mm = 30\n", "", r"defect 2: stone: the key 'height_mm' is missing"),
        ('"critical"', '"fatal"', r"defect 2: stone: class 'fatal'"),
        ("zirconia", "granite", r"defect 2: stone: mineral 'granite'"),
        ("angle_deg = 10", "angle_deg = nan", r"defect 2: stone: angle_deg: every number must be finite"),
        (FILE, "", "it lists no defect"),
        (FILE, "defect = 3", r"two brackets"),
        (FILE, "[[defect]]\n[[seed]]\n", "key 'seed'"),
    ],
)
def test_a_faulty_file_is_told_in_one_sentence(tmp_path, old, new, words):
    file = tmp_path / "d.toml"
    file.write_text(FILE.replace(old, new))
    with pytest.raises(InputError, match=words):
        read_defects(file)


def test_a_population_is_the_same_for_the_same_seed_and_fits():
    first, again, other = (sample("seedy", seed, TUMBLER) for seed in (3, 3, 4))
    assert first == again != other
    assert len(first) > 100
    assert not fit(TUMBLER, first).faults


def test_a_population_follows_its_distributions(tmp_path):
    file = tmp_path / "p.toml"
    file.write_text(
        'description = "test"\n[[defect]]\nkind = "seed"\nper_container = 400\n'
        "height_share = { uniform = [0.2, 0.6] }\n"
        "depth_share = { uniform = [0.3, 0.7] }\ndiameter_mm = { lognormal = [0.2, 0.4], most = 0.5 }\n"
    )
    seeds = sample(str(file), 5, can())
    assert abs(len(seeds) - 400) < 4 * np.sqrt(400)
    sizes, heights, depths, angles = (
        np.array([getattr(seed, field) for seed in seeds])
        for field in ("diameter_mm", "height_mm", "depth_mm", "angle_deg")
    )
    assert np.median(sizes) == pytest.approx(0.2, rel=0.1)
    assert np.std(np.log(sizes)) == pytest.approx(0.4, rel=0.15)
    assert sizes.max() <= 0.5
    assert 20.0 <= heights.min() < 22.0 < 58.0 < heights.max() <= 60.0
    assert 0.9 - 1e-6 <= depths.min() < depths.max() <= 2.1 + 1e-6
    assert np.mean(angles) == pytest.approx(180.0, abs=25.0)


def test_containers_of_a_day_differ_and_the_tenth_is_the_tenth():
    containers = list(day("worn_furnace", 7, TUMBLER, 4))
    assert containers == list(day("worn_furnace", 7, TUMBLER, 4))
    assert containers[3] == sample("worn_furnace", (7, 3), TUMBLER)
    assert len(set(containers)) == 4


@pytest.mark.parametrize("name", sorted(populations()))
def test_every_population_can_be_drawn(name):
    for seed in range(3):
        assert not fit(TUMBLER, sample(name, seed, TUMBLER)).faults


def test_a_wall_without_room_is_told(tmp_path):
    file = tmp_path / "p.toml"
    file.write_text(
        'description = "test"\n[[defect]]\nkind = "seed"\nper_container = 5\nheight_share = 0.5\ndiameter_mm = 4\n'
    )
    with pytest.raises(GlassWorkbenchError, match=r"p: \d of \d defects find no place in the wall, the first a seed"):
        sample(str(file), 1, can())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("seedy", "give the seed of seedy as a whole number, like seedy:1"),
        ("seedy:x", "give the seed of seedy"),
        ("sedy:1", "did you mean 'seedy'"),
        ("nowhere.toml", "there is no such file"),
        ("nowhere.toml:1", "there is no such file"),
    ],
)
def test_what_is_no_list_and_no_population_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        parse_defects(text)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("diameter_mm = { unifrom = [0, 1] }", "did you mean 'uniform'"),
        ("diameter_mm = { uniform = [1, 0] }", "too small"),
        ("diameter_mm = { uniform = [0, 1], normal = [0, 1] }", "name one distribution"),
        ("diameter_mm = { choice = [] }", "list the values"),
        ("depth_mm = 1", "key 'depth_mm'"),
        (
            '[[defect]]\nkind = "lean"\nper_container = 1\nheight_share = 0.5',
            "made with the wall, so it cannot be drawn",
        ),
        ("per_contaner = 1", "did you mean 'per_container'"),
    ],
)
def test_a_faulty_population_is_told(tmp_path, line, words):
    file = tmp_path / "p.toml"
    file.write_text(f'description = "t"\n[[defect]]\nkind = "seed"\nper_container = 1\nheight_share = 0.5\n{line}\n')
    with pytest.raises(InputError, match=words):
        sample(str(file), 1, can())


def test_defects_are_listed_and_rendered_on_the_command_line(tmp_path, capsys):
    assert main(["defects"]) == 0
    told = capsys.readouterr().out
    assert all(name in told for name in (*KINDS, *populations()))
    assert main(["defects", "stone"]) == 0
    assert "halo_index_offset" in capsys.readouterr().out
    assert main(["defects", "ston"]) == 2
    assert "did you mean 'stone'" in capsys.readouterr().err


def test_the_macro_api_adds_defects():
    scene = gw.with_defects(gw.station("studio", TUMBLER, "amber"), TUMBLER, gw.sample_defects("seedy", 1, TUMBLER))
    assert [body.name for body in scene.bodies] == ["outer", "cavity", "air_1"]
    assert "more" in scene.metadata["defects"]
    assert set(gw.defects()) == set(KINDS)
