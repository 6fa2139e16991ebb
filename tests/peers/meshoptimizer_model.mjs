// meshoptimizer's `simplify` of any mesh as a process of its own, with the files of models.py:
// node meshoptimizer_model.mjs FOLDER INDICES
import { readFileSync, writeFileSync } from 'node:fs';
import { MeshoptSimplifier } from 'meshoptimizer/simplifier';

const folder = process.argv[2];
const count = Number(process.argv[3]);

/** A file's numbers, which are little-endian as the machine's are. */
function numbers(name, Kind) {
    const bytes = readFileSync(`${folder}/${name}`);
    return new Kind(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
}

await MeshoptSimplifier.ready;
const [indices] = MeshoptSimplifier.simplify(
    numbers('triangles.u32', Uint32Array),
    numbers('positions.f32', Float32Array),
    3,
    count,
    Infinity,
);
writeFileSync(`${folder}/simplified.u32`, indices);
