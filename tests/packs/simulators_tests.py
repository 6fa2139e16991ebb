"""What simulators make of a pack, asked for heights."""

import unittest
from xml.etree import ElementTree

import mujoco
import numpy
import pybullet
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdValidation

import pack

COUNT = 2000


class Simulators(unittest.TestCase):
    def check(self, manifest, points, claim):
        """Nearly all rays meet the ground, within `claim` of the DEM, and use some of it."""
        self.assertGreater(len(points), 0.99 * COUNT)
        off = abs(pack.errors(manifest, numpy.array(points)))
        self.assertFalse(numpy.isnan(off).any())
        self.assertLessEqual(off.max(), claim)
        self.assertGreater(off.max(), 5.0)

    def test_mujoco_has_the_ground_where_it_is(self):
        for options in [(), pack.MANY]:
            with self.subTest(options):
                path = pack.pack(*options)
                manifest = pack.manifest(path)
                model = mujoco.MjModel.from_xml_path(str(path / "mujoco.xml"))
                data = mujoco.MjData(model)
                mujoco.mj_forward(model, data)
                points, group = [], numpy.zeros(1, dtype=numpy.int32)
                for x, y in pack.places(manifest, COUNT):
                    start, down = numpy.array([x, y, 3000.0]), numpy.array([0.0, 0.0, -1.0])
                    distance = mujoco.mj_ray(model, data, start, down, None, 1, -1, group, None)
                    if distance >= 0:
                        points.append([x, y, 3000.0 - distance])
                # MuJoCo keeps 24 bits of the range.
                self.check(manifest, points, manifest["heightmaps"]["error_of_metres"] + 0.001)

    def test_pybullet_collides_with_the_meshes(self):
        path = pack.pack()
        manifest = pack.manifest(path)
        client = pybullet.connect(pybullet.DIRECT)
        for tile in manifest["meshes"]["tiles"]:
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_MESH,
                fileName=str(path / f"{tile['path']}.obj"),
                flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                physicsClientId=client,
            )
            pybullet.createMultiBody(0, shape, basePosition=tile["offset"], physicsClientId=client)
        points = []
        for x, y in pack.places(manifest, COUNT):
            ((body, _, _, at, _),) = pybullet.rayTest([x, y, 3000.0], [x, y, -1000.0], physicsClientId=client)
            if body >= 0:
                points.append(at)
        pybullet.disconnect(client)
        # A ray of 4 km in single precision.
        self.check(manifest, points, manifest["meshes"]["error"] + 0.01)

    def test_a_ball_that_falls_comes_to_rest_on_the_ground_in_mujoco(self):
        path = pack.pack()
        manifest = pack.manifest(path)
        x, y = numpy.array(manifest["heightmaps"]["low"]) * 0.3
        world = ElementTree.parse(path / "mujoco.xml")
        ball = ElementTree.SubElement(world.find("worldbody"), "body", pos=f"{x} {y} 1100")
        ElementTree.SubElement(ball, "freejoint")
        ElementTree.SubElement(ball, "geom", type="sphere", size="1", condim="6", friction="10 10 10")
        spec = mujoco.MjSpec.from_string(
            ElementTree.tostring(world.getroot(), encoding="unicode"),
            assets={name: (path / name).read_bytes() for name in manifest["files"] if name.endswith(".bin")},
        )
        model = spec.compile()
        data = mujoco.MjData(model)
        while data.time < 40.0:
            mujoco.mj_step(model, data)
        (above,) = pack.errors(manifest, data.qpos[None, :3])
        self.assertLess(abs(data.qvel[2]), 1.0)
        self.assertLess(abs(above - 1.0), manifest["heightmaps"]["error_of_metres"] + 1.0)


class Stage(unittest.TestCase):
    def test_usd_is_valid_and_collides_triangle_by_triangle_where_the_ground_is(self):
        path = pack.pack()
        manifest = pack.manifest(path)
        stage = Usd.Stage.Open(str(path / "terrain.usda"))
        self.assertEqual(UsdGeom.GetStageUpAxis(stage), "Z")
        self.assertEqual(UsdGeom.GetStageMetersPerUnit(stage), 1.0)
        self.assertEqual(str(stage.GetDefaultPrim().GetPath()), "/Terrain")
        meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
        self.assertEqual(len(meshes), len(manifest["meshes"]["tiles"]))
        points = []
        for mesh, tile in zip(meshes, manifest["meshes"]["tiles"]):
            prim = mesh.GetPrim()
            self.assertTrue(prim.HasAPI(UsdPhysics.CollisionAPI) and prim.HasAPI(UsdPhysics.MeshCollisionAPI))
            self.assertEqual(UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get(), "none")
            self.assertEqual(mesh.GetSubdivisionSchemeAttr().Get(), "none")
            corners = mesh.GetFaceVertexIndicesAttr().Get()
            self.assertEqual(len(corners), 3 * tile["triangles"])
            self.assertEqual(set(mesh.GetFaceVertexCountsAttr().Get()), {3})
            transform = mesh.ComputeLocalToWorldTransform(Usd.TimeCode.Default())
            local = mesh.GetPointsAttr().Get()
            low, high = mesh.GetExtentAttr().Get()
            numpy.testing.assert_array_equal([low, high], [numpy.min(local, axis=0), numpy.max(local, axis=0)])
            points += [transform.Transform(Gf.Vec3d(at)) for at in local]
        off = abs(pack.errors(manifest, numpy.array(points)))
        self.assertLessEqual(numpy.nanmax(off), manifest["meshes"]["error"])
        self.assertGreater(numpy.nanmax(off), 5.0)

    def test_usd_has_no_fault_that_its_validators_know(self):
        stage = Usd.Stage.Open(str(pack.pack() / "terrain.usda"))
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        self.assertGreater(len(validators), 5)
        faults = UsdValidation.ValidationContext(validators).Validate(stage)
        self.assertEqual([str(fault.GetErrorAsString()) for fault in faults], [])


if __name__ == "__main__":
    unittest.main()
