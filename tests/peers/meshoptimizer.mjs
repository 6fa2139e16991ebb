// meshoptimizer's `simplify` as a process of its own, with the arguments and files of peer.py:
// node meshoptimizer.mjs FOLDER COLUMNS ROWS CELL_WIDTH CELL_HEIGHT ERROR
import { readFileSync, writeFileSync } from 'node:fs';
import { MeshoptSimplifier } from 'meshoptimizer/simplifier';

const folder = process.argv[2];
const [columns, rows, width, height, error] = process.argv.slice(3).map(Number);

function floats(path) {
    const bytes = readFileSync(path);
    return new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
}

/** Positions in metres of all samples, y downwards. */
function gridPositions(heights) {
    const positions = new Float32Array(3 * heights.length);
    heights.forEach((metres, sample) => {
        positions.set([(sample % columns) * width, Math.floor(sample / columns) * height, metres], 3 * sample);
    });
    return positions;
}

/** Two triangles a cell. */
function gridIndices() {
    const indices = new Uint32Array(6 * (columns - 1) * (rows - 1));
    let next = 0;
    for (let row = 0; row + 1 < rows; row++) {
        for (let column = 0; column + 1 < columns; column++) {
            const above = row * columns + column;
            const below = above + columns;
            indices.set([above, below, above + 1, above + 1, below, below + 1], next);
            next += 6;
        }
    }
    return indices;
}

/** Numbers the samples that are left, in place; they keep their heights. */
function compact(indices, heights) {
    const [numbers, count] = MeshoptSimplifier.compactMesh(indices);
    const vertices = new Float64Array(3 * count);
    numbers.forEach((number, sample) => {
        if (number < count) {
            vertices.set([sample % columns, Math.floor(sample / columns), heights[sample]], 3 * number);
        }
    });
    return vertices;
}

await MeshoptSimplifier.ready;
const heights = floats(`${folder}/heights.f32`);
const started = process.cpuUsage();
const [indices] = MeshoptSimplifier.simplify(gridIndices(), gridPositions(heights), 3, 0, error, ['ErrorAbsolute']);
const vertices = compact(indices, heights);
const used = process.cpuUsage(started);
console.log(JSON.stringify({ algorithm_seconds: (used.user + used.system) / 1e6 }));
writeFileSync(`${folder}/vertices.f64`, vertices);
writeFileSync(`${folder}/triangles.u32`, indices);
