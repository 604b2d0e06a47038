import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cmtof.scenes.rooms import solids
from cmtof.scenes.rooms.assembly import assemble, subdivided
from cmtof.scenes.rooms.materials import Material
from cmtof.scenes.rooms.meshing import face_vectors, spread, vertex_normals
from cmtof.scenes.rooms.thing import Light, Thing, pose, transformed

WHITE = Material((0.8, 0.8, 0.8))


def volume(vertices, faces):
    a, b, c = (vertices[faces[:, k]].astype(float) for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def area(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


@pytest.mark.parametrize(
    ("mesh", "expected", "tolerance"),
    [
        (solids.box((1, 2, 3)), 6.0, 1e-6),
        (solids.cylinder(1, 2, sides=256), 2 * np.pi, 1e-3),
        (solids.cylinder(1, 3, top=0.5, sides=256), np.pi * (1 + 0.5 + 0.25), 1e-3),
        (solids.ball(1, subdivisions=5), 4 / 3 * np.pi, 3e-3),
        (solids.rod((0, 0, 0), (1, 2, 2), 0.1, 256), 3 * np.pi * 0.01, 1e-3),
        (solids.prism([(0, 0), (2, 0), (2, 1), (0, 1)], 3), 6.0, 1e-6),
        (solids.revolve([(0, 0), (1, 0), (0, 3)], 256), np.pi, 1e-3),
        (solids.cushion((2, 2, 2), square=1.0), 4 / 3 * np.pi, 0.04),
    ],
)
def test_solids_have_their_volume_and_face_outwards(mesh, expected, tolerance):
    assert volume(*mesh) == pytest.approx(expected, rel=tolerance)


def test_a_bevel_takes_little_and_keeps_the_extent():
    plain, cut = solids.box((1, 2, 3)), solids.box((1, 2, 3), bevel=0.01)
    assert np.ptp(cut.vertices, axis=0) == pytest.approx([1, 2, 3])
    assert volume(*plain) - volume(*cut) == pytest.approx(12 * 0.01**2 / 2 * 2, rel=0.05)


def test_a_thick_sheet_is_closed_on_both_sides_but_for_its_rim():
    grid = np.stack(np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], indexing="ij"), -1)
    points = np.concatenate([grid, np.zeros((3, 3, 1))], -1)
    mesh = solids.sheet(points, thickness=0.1)
    assert area(*mesh) == pytest.approx(2.0)
    assert sorted(np.unique(mesh.vertices[:, 2].round(6))) == pytest.approx([-0.1, 0.0])


@given(st.floats(0.05, 5), st.floats(0.05, 5), st.floats(0.05, 5), st.floats(0.2, 1.0))
def test_division_keeps_area_volume_and_joins(x, y, z, longest):
    mesh = solids.prism([(0, 0), (x, 0), (x, y), (0, y)], z)
    vertices, faces, _ = subdivided(mesh.vertices.astype(float), mesh.faces, longest)
    edges = vertices[faces[:, [0, 1, 2, 0]]]
    assert np.linalg.norm(np.diff(edges, axis=1), axis=-1).max() <= longest
    assert volume(vertices, faces) == pytest.approx(x * y * z, rel=1e-5)
    assert area(vertices, faces) == pytest.approx(area(*mesh), rel=1e-5)


def test_division_leaves_no_crack_in_a_closed_solid():
    import trimesh

    mesh = solids.ball(2.0, subdivisions=1)
    vertices, faces, _ = subdivided(mesh.vertices.astype(float), mesh.faces, 0.4)
    assert len(faces) > len(mesh.faces)
    assert trimesh.Trimesh(vertices, faces, process=False).is_watertight


def test_normals_of_a_sphere_are_its_radii():
    mesh = solids.ball(0.7)
    cosine = (vertex_normals(*mesh) * mesh.vertices / 0.7).sum(axis=1)
    assert cosine.min() > 0.9995


def test_a_box_is_shaded_flat():
    mesh = solids.box((1, 1, 1))
    assert np.abs(vertex_normals(*mesh)).max(axis=1) == pytest.approx(1.0)


def test_faces_have_their_area_and_outward_normal():
    mesh = solids.box((1, 2, 3), (5, 0, 0))
    middle, normal, size = face_vectors(*mesh)
    assert size.sum() == pytest.approx(22.0)
    assert ((middle - [5, 0, 0]) * normal).sum(axis=1).min() > 0


def test_light_spreads_to_neighbours_then_to_the_part_and_keeps_a_constant():
    mesh = solids.joined([solids.box((1, 1, 1)), solids.box((1, 1, 1), (3, 0, 0))])
    part = np.repeat(np.int32([0, 1]), 12)
    values, weight = np.full((24, 3), 2.0, np.float32), np.zeros(24, np.float32)
    weight[0] = weight[12] = 1.0
    values[12] = 5.0
    found = spread(values, weight, mesh.faces, part, len(mesh.vertices), 2)
    assert found[:12] == pytest.approx(np.full((12, 3), 2.0))
    assert found[12:] == pytest.approx(np.full((12, 3), 5.0))


def test_a_child_moves_with_what_carries_it_and_keeps_its_own_number():
    tray = Thing("tray").add(solids.box((1, 1, 0.1)), WHITE)
    cup = Thing("cup").add(solids.box((0.1, 0.1, 0.1)), WHITE)
    tray.carry(cup, 0.3, 0.0, 0.1, turn=0.2)
    geometry = assemble([(tray, pose(5.0, 0.0, 1.0, np.pi / 2))], rng=np.random.default_rng(0))
    assert geometry.kinds == ("tray", "cup")
    of_cup = geometry.vertices[geometry.faces[geometry.instance[geometry.part] == 2]]
    assert of_cup.reshape(-1, 3).mean(axis=0) == pytest.approx([5.0, 0.3, 1.1], abs=1e-5)


def test_the_pattern_of_a_part_stays_with_it_when_it_is_moved():
    thing = Thing("board").add(
        solids.box((1, 1, 1)), Material((1, 1, 1), pattern="wood", scale=0.5)
    )
    local = np.array([0.2, -0.3, 0.4])
    for motion in (pose(), pose(3.0, -2.0, 1.0, 0.7)):
        made = assemble([(thing, motion)], rng=np.random.default_rng(1))
        map_ = made.materials["from_world"][0]
        here = map_[:, :3] @ transformed(local, motion) + map_[:, 3]
        assert here % 1 == pytest.approx((local / 0.5) % 1, abs=1e-5)


def test_a_lamp_moves_and_turns_with_its_thing():
    lamp = Thing("lamp").add(solids.box((0.1, 0.1, 0.1)), WHITE)
    lamp.lights.append(Light((1.0, 0, 0), (0.1, 0, 0), (0, 0.2, 0), 2.0, (1.0, 0, 0)))
    made = assemble([(lamp, pose(0, 0, 2.0, np.pi / 2))], rng=np.random.default_rng(0))
    light = made.lights[0]
    assert light["centre"] == pytest.approx([0, 1, 2], abs=1e-6)
    assert light["normal"] == pytest.approx([0, 1, 0], abs=1e-6)
    assert light["power"] == 2.0


def test_an_unknown_pattern_is_named():
    with pytest.raises(ValueError, match=r"Expected a pattern out of .* got 'tartan'. Choose one."):
        Material((1, 1, 1), pattern="tartan")
