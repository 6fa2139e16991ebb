"""Collision meshes: the surface is one, within its error, and at the same place in all formats."""

import collections
import hashlib
import unittest

import numpy
import trimesh

import pack


def glb(path):
    """Positions in the frame, and triangles."""
    scene = trimesh.load(path, process=False)
    (node,) = scene.graph.nodes_geometry
    transform, name = scene.graph[node]
    mesh = scene.geometry[name]
    x, y, z = trimesh.transform_points(mesh.vertices, transform).T
    # In the format y is up and z is south.
    return numpy.column_stack([x, -z, y]), mesh.faces


class Meshes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.path = pack.pack()
        cls.manifest = pack.manifest(cls.path)
        cls.said = cls.manifest["meshes"]
        cls.meshes = {tile["path"]: glb(cls.path / f"{tile['path']}.glb") for tile in cls.said["tiles"]}

    def test_the_surface_is_as_near_to_the_dem_as_is_said(self):
        worst = 0.0
        for positions, faces in self.meshes.values():
            corners = positions[faces]
            weights = [(1, 1, 1), (1, 1, 0), (4, 1, 1), (1, 6, 1)]
            points = [positions] + [numpy.average(corners, axis=1, weights=weight) for weight in weights]
            off = abs(pack.errors(self.manifest, numpy.concatenate(points)))
            # The outline may be beside the DEM's.
            self.assertLess(numpy.isnan(off).mean(), 0.05)
            worst = max(worst, numpy.nanmax(off))
        self.assertLessEqual(worst, self.said["error"])
        self.assertGreater(worst, self.manifest["surface"]["certified_error"] / 2)

    def test_no_gap_is_between_tiles(self):
        count, edges = 0, collections.Counter()
        numbers = {}
        for positions, faces in self.meshes.values():
            # To the bit.
            index = numpy.array([numbers.setdefault(tuple(at), len(numbers)) for at in positions.tolist()])
            count += len(positions)
            for three in index[faces].tolist():
                for start, end in zip(three, three[1:] + three[:1]):
                    edges[start, end] += 1
        self.assertGreater(count - len(numbers), 300, "tiles share vertices")
        self.assertEqual(max(edges.values()), 1, "all triangles are turned the same way")
        border = [edge for edge in edges if edge[::-1] not in edges]
        places = numpy.array(list(numbers))
        low, high = places.min(axis=0), places.max(axis=0)
        ends = places[numpy.array(border)][:, :, :2]
        # The box of degrees is no rectangle in metres: its sides bend by up to 60 m.
        inside = numpy.minimum(ends - low[:2], high[:2] - ends).min(axis=2)
        self.assertLess(inside.max(), 60.0)

    def test_obj_is_the_same_from_the_offset(self):
        for tile in self.said["tiles"]:
            mesh = trimesh.load(self.path / f"{tile['path']}.obj", process=False)
            positions, faces = self.meshes[tile["path"]]
            numpy.testing.assert_array_equal(mesh.vertices + tile["offset"], positions)
            numpy.testing.assert_array_equal(mesh.faces, faces)
            self.assertTrue((mesh.face_normals[:, 2] > 0).all())

    def test_checksums_are_those_of_the_files(self):
        files = {str(path.relative_to(self.path)) for path in self.path.rglob("*") if path.is_file()}
        self.assertEqual(files - {"manifest.json"}, set(self.manifest["files"]))
        for name, said in self.manifest["files"].items():
            content = (self.path / name).read_bytes()
            self.assertEqual(said, {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()})


if __name__ == "__main__":
    unittest.main()
