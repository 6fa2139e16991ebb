"""Packs that are one file: the same files as the folder, found as the format's readers find them."""

import gzip
import hashlib
import json
import sqlite3
import struct
import subprocess
import tempfile
import unittest
import zipfile
from pathlib import Path

import pmtiles.reader
import pmtiles.tile

import pack

TOOLS = Path(__file__).with_name("node_modules") / ".bin/3d-tiles-tools"


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def packed(format: str, name: str) -> Path:
    path = pack.folder() / name
    if not path.exists():
        pack.run("pack", pack.archive(), "--format", format, "-o", path)
    return path


class ThreeTz(unittest.TestCase):
    def test_the_index_leads_to_every_file_of_the_folder(self):
        expected = files(packed("3d-tiles", "3d-tiles"))
        path = packed("3tz", "sample.3tz")
        content = path.read_bytes()
        with zipfile.ZipFile(path) as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual(archive.infolist()[-1].filename, "@3dtilesIndex1@")
            self.assertEqual({entry.compress_type for entry in archive.infolist()}, {zipfile.ZIP_STORED})
            index = archive.read("@3dtilesIndex1@")
        entries = list(struct.iter_unpack("<QQQ", index))
        self.assertEqual(entries, sorted(entries))
        starts = {(first, second): start for first, second, start in entries}
        self.assertEqual(len(starts), len(expected))
        for name, file in expected.items():
            start = starts[struct.unpack("<QQ", hashlib.md5(name.encode()).digest())]
            # The local header as it stands before the file: no lengths that come later.
            signature, flags, method, packed_size, size = struct.unpack("<I2xHH8xII", content[start : start + 26])
            name_length, extra_length = struct.unpack("<HH", content[start + 26 : start + 30])
            self.assertEqual((signature, flags & 8, method, packed_size, size), (0x04034B50, 0, 0, len(file), len(file)))
            begin = start + 30 + name_length + extra_length
            self.assertEqual(content[begin : begin + size], file)

    def test_the_tools_of_3d_tiles_unpack_it(self):
        with tempfile.TemporaryDirectory() as output:
            whole = Path(output) / "whole"
            done = subprocess.run([TOOLS, "convert", "-i", packed("3tz", "sample.3tz"), "-o", whole], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            found, expected = files(whole), files(packed("3d-tiles", "3d-tiles"))
            self.assertEqual(set(found), set(expected))
            for name, file in expected.items():
                if name.endswith(".glb"):
                    self.assertEqual(found[name], file, name)
                else:
                    self.assertEqual(json.loads(found[name]), json.loads(file), name)


class Mbtiles(unittest.TestCase):
    def test_it_has_every_tile_of_the_folder(self):
        expected = files(packed("folder", "folder"))
        database = sqlite3.connect(packed("mbtiles-qm", "sample.mbtiles"))
        self.assertEqual(database.execute("PRAGMA integrity_check").fetchone(), ("ok",))
        self.assertEqual(database.execute("PRAGMA application_id").fetchone(), (0x4D504258,))
        rows = database.execute("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles")
        found = {f"{z}/{x}/{y}.terrain": gzip.decompress(data) for z, x, y, data in rows}
        said = dict(database.execute("SELECT name, value FROM metadata"))
        found["layer.json"] = said["json"].encode()
        self.assertEqual(found, expected)
        self.assertEqual(said["format"], "application/vnd.quantized-mesh")
        layer = json.loads(said["json"])
        self.assertEqual([float(side) for side in said["bounds"].split(",")], layer["bounds"])
        self.assertEqual((int(said["minzoom"]), int(said["maxzoom"])), (layer["minzoom"], layer["maxzoom"]))


class Pmtiles(unittest.TestCase):
    def test_it_has_every_tile_of_the_folder_a_zoom_further_on(self):
        expected = files(packed("folder", "folder"))
        source = pmtiles.reader.MemorySource(packed("pmtiles-qm", "sample-qm.pmtiles").read_bytes())
        reader = pmtiles.reader.Reader(source)
        header, layer = reader.header(), reader.metadata()
        self.assertEqual(layer, json.loads(expected.pop("layer.json")))
        tiles = dict(pmtiles.reader.all_tiles(source))
        self.assertEqual(len(tiles), len(expected))
        for name, file in expected.items():
            z, x, y = [int(number) for number in name.removesuffix(".terrain").split("/")]
            # In the file both roots are the northern half of zoom 1, and rows count from the north.
            self.assertEqual(gzip.decompress(tiles[z + 1, x, 2**z - 1 - y]), file, name)
        self.assertEqual(header["tile_compression"], pmtiles.tile.Compression.GZIP)
        self.assertEqual((header["min_zoom"], header["max_zoom"]), (layer["minzoom"] + 1, layer["maxzoom"] + 1))
        names = ["min_lon_e7", "min_lat_e7", "max_lon_e7", "max_lat_e7"]
        self.assertEqual([header[name] for name in names], [round(side * 1e7) for side in layer["bounds"]])


if __name__ == "__main__":
    unittest.main()
