// A tile on the graphics card. Its places in space and its triangles are uploaded once, coarsest first; changing the
// level of detail uploads, for each vertex, the index of the place it is drawn at, and moves the end of what is drawn.

import * as THREE from "three";
import { degreesOf, type Address } from "./address.ts";
import { tileBounds, type Frame } from "./frame.ts";
import { firstHit, raised, type Hit } from "./ground.ts";
import { FILLED_CELLS, filledTexels } from "./filled.ts";
import type { LightPatch } from "./finer_light.ts";
import { drawnPrefix, isSameDetail, placesOf, type Detail } from "./partition.ts";
import { movingPrefix, type Moving, type ShownTile } from "./morph.ts";
import { TERRAIN_FRAGMENT, TERRAIN_VERTEX, TEXTURE_WIDTH, WIRE_FRAGMENT } from "./shaders.ts";
import type { PlacedTile, Spot } from "./spots.ts";
import type { Tile } from "./tile.ts";
import { MERCATOR_END, type Picture } from "./imagery.ts";
import type { RasterPlace, SquareRaster } from "./square_rasters.ts";
import { WATER_CELLS } from "./water.ts";

/** Uniforms that all tiles share: one object each, so that one assignment reaches every tile. */
export interface SharedUniforms {
  readonly exaggeration: THREE.IUniform<number>;
  readonly baseHeight: THREE.IUniform<number>;
  /** Of the first and the last colour. */
  readonly heights: THREE.IUniform<THREE.Vector2>;
  /** Where the colours of land begin. */
  readonly landFrom: THREE.IUniform<number>;
  /** What is below is sea, besides the water that an archive knows. */
  readonly seaLevel: THREE.IUniform<number>;
  readonly contourInterval: THREE.IUniform<number>;
  readonly hazeDistance: THREE.IUniform<number>;
  readonly axis: THREE.IUniform<THREE.Vector3>;
  /** How far what is looked at is, metres: haze belongs to what is beyond. */
  readonly clearDistance: THREE.IUniform<number>;
  /** Which of the styles, by its place in the list of them. */
  readonly style: THREE.IUniform<number>;
  /** Whether lines of equal height are drawn. */
  readonly contours: THREE.IUniform<boolean>;
  /** Whether ground that was filled is told apart. */
  readonly showsFilled: THREE.IUniform<boolean>;
}

/** What is known of parts of a tile's square; undefined where it is of none. */
export interface Cells {
  /** A bit for each cell whose ground was filled. */
  readonly filled: Uint8Array | undefined;
  /** A texel for each cell, 255 where there is water. */
  readonly water: Uint8Array<ArrayBuffer> | undefined;
}

/** A straight piece of a line of equal height. */
export interface ContourPiece {
  readonly height: number;
  readonly ends: readonly [THREE.Vector3, THREE.Vector3];
}

/** Share of the way to the eye at which lines are drawn in front of the surface. */
const LINE_LIFT = 0.9985;
/** Of one triangle: three edges of two corners. */
const INDICES_OF_EDGES = 6;

/** The surface of one tile at a changeable level of detail. */
export class TileMesh {
  readonly object: THREE.Group;
  /** Holds every place a vertex may be drawn at, without exaggeration: while it moves, those of other tiles, too. */
  box: THREE.Box3;
  /** Bytes of textures and indices. */
  readonly byteLength: number;
  private readonly tile: Tile;
  private readonly ownBox: THREE.Box3;
  private readonly geometry = new THREE.BufferGeometry();
  /** The tile's own places, and while it moves, those of other tiles behind them. */
  private spots: SpotTextures;
  private readonly places: THREE.DataTexture;
  private readonly ownSpots: SpotTextures;
  private readonly positions: THREE.IUniform<THREE.DataTexture | null> = { value: null };
  private readonly squares: THREE.IUniform<THREE.DataTexture | null> = { value: null };
  private readonly blend = { value: 1 };
  private readonly certifiedError = { value: 0 };
  private readonly normals: THREE.IUniform<THREE.Texture | null> = { value: null };
  private readonly normalsPlace = { value: new THREE.Vector3(0, 0, 0) };
  private readonly finerNormals: THREE.IUniform<THREE.Texture | null> = { value: null };
  private readonly finerPlace = { value: new THREE.Vector4(0, 0, 0, 0) };
  private readonly finerEnds = { value: new THREE.Vector4(0, 0, 0, 0) };
  private readonly finerShare = { value: 0 };
  private readonly picture: THREE.IUniform<THREE.Texture | null> = { value: null };
  private readonly picturePlace = { value: new THREE.Vector3(0, 0, 0) };
  private readonly pictureRows = { value: new THREE.Vector4(0, 0, 0, 1) };
  private readonly pictureLatitudes = { value: new THREE.Vector2(0, 0) };
  private readonly filled: THREE.DataTexture | undefined;
  private readonly water: THREE.DataTexture | undefined;
  private readonly uniforms: Record<string, THREE.IUniform>;
  private readonly surface: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
  private wire: THREE.LineSegments | undefined;
  private drawn = 0;
  /** What is shown without a move. */
  private resting: Detail | undefined;

  constructor({ tile, spots }: PlacedTile, { filled, water }: Cells, frame: Frame, shared: SharedUniforms) {
    this.tile = tile;
    this.ownBox = new THREE.Box3().setFromPoints(spots.map(({ position }) => position));
    this.box = this.ownBox;
    const centre = this.ownBox.getCenter(new THREE.Vector3());
    this.ownSpots = new SpotTextures(spots, tile.address, centre);
    this.spots = this.ownSpots;
    const drawnAt = padded(Uint32Array, 2 * tile.representatives.length, 2);
    this.places = dataTexture(drawnAt, THREE.RGIntegerFormat, THREE.UnsignedIntType, "RG32UI", 2);
    this.geometry.setIndex(new THREE.BufferAttribute(tile.corners, 1));
    this.geometry.boundingSphere = new THREE.Sphere();
    this.filled = filled && cellTexture(filledTexels(filled), FILLED_CELLS);
    this.water = water && cellTexture(water, WATER_CELLS);
    if (this.water !== undefined) this.water.minFilter = this.water.magFilter = THREE.LinearFilter;
    const bytesOfCells = (filled === undefined ? 0 : FILLED_CELLS ** 2) + (water?.byteLength ?? 0);
    this.byteLength = this.spots.byteLength + drawnAt.byteLength + tile.corners.byteLength + bytesOfCells;
    this.useSpots(this.ownSpots);
    this.uniforms = {
      ...shared,
      positions: this.positions,
      squares: this.squares,
      places: { value: this.places },
      blend: this.blend,
      certifiedError: this.certifiedError,
      normals: this.normals,
      normalsPlace: this.normalsPlace,
      finerNormals: this.finerNormals,
      finerPlace: this.finerPlace,
      finerEnds: this.finerEnds,
      finerShare: this.finerShare,
      picture: this.picture,
      picturePlace: this.picturePlace,
      pictureRows: this.pictureRows,
      pictureLatitudes: this.pictureLatitudes,
      filled: { value: this.filled ?? null },
      hasFilled: { value: filled !== undefined },
      water: { value: this.water ?? null },
      hasWater: { value: water !== undefined },
      earthCentre: { value: frame.earthCentre.clone().sub(centre) },
    };
    this.surface = new THREE.Mesh(this.geometry, surfaceMaterial(this.uniforms));
    this.surface.frustumCulled = false;
    this.object = new THREE.Group().add(this.surface);
    this.object.position.copy(centre);
  }

  /** Shows a level of detail. */
  show(detail: Detail): void {
    if (this.resting !== undefined && isSameDetail(this.resting, detail)) return;
    this.resting = detail;
    this.box = this.ownBox;
    this.useSpots(this.ownSpots);
    const places = placesOf(this.tile, detail);
    this.draw(places, places, drawnPrefix(this.tile, detail));
    this.setBlend(1);
  }

  /** Shows the first of two pictures, and what is between them as it is blended. */
  move(moving: Moving<ShownTile>): void {
    this.resting = undefined;
    const others: Spot[] = [];
    const ownPlaces = this.tile.positions.length / 3;
    const placeOf = (spot: Spot) => (spot.own?.tile === this.tile ? spot.own.place : ownPlaces + others.push(spot) - 1);
    const [from, to] = [moving.from, moving.to].map((spots) => Uint32Array.from(spots, placeOf)) as [Uint32Array, Uint32Array];
    this.box = others.reduce((box, { position }) => box.expandByPoint(position), this.ownBox.clone());
    if (others.length > 0) this.useSpots(this.ownSpots.with(others));
    this.draw(from, to, movingPrefix(this.tile, moving));
    this.setBlend(0);
  }

  /** From the first picture, 0, to the second one, 1. */
  setBlend(blend: number): void {
    this.blend.value = blend;
  }

  /** For the style that shows it. */
  setError(metres: number): void {
    this.certifiedError.value = metres;
  }

  /** Light comes from normals, or from facets without any. */
  setNormals(found: RasterPlace<SquareRaster> | undefined): void {
    this.normals.value = found?.raster.texture ?? null;
    this.normalsPlace.value.set(found?.size ?? 0, found?.x ?? 0, found?.y ?? 0);
  }

  /** Of a part of the tile light is finer. */
  setFinerNormals(patch: LightPatch | undefined): void {
    this.finerNormals.value = patch?.texture ?? null;
    this.finerShare.value = patch?.share.value ?? 0;
    if (patch === undefined) return;
    this.finerPlace.value.set(patch.size.x, patch.size.y, patch.corner.x, patch.corner.y);
    this.finerEnds.value.copy(patch.ends);
  }

  /** The ground is coloured by a picture, if there is one. */
  setPicture(found: RasterPlace<Picture> | undefined): void {
    this.picture.value = found?.raster.texture ?? null;
    this.picturePlace.value.set(found?.size ?? 0, found?.x ?? 0, found?.y ?? 0);
    if (found === undefined) return;
    const { base, bottom, height } = found.raster;
    const south = THREE.MathUtils.degToRad(tileBounds(found.of)[1]);
    this.pictureRows.value.set(base, MERCATOR_END - base, bottom, height);
    this.pictureLatitudes.value.set(south - base, THREE.MathUtils.degToRad(degreesOf(found.of.zoom)));
  }

  /** Where a ray in the scene first meets what is drawn; where it meets no triangle, they are wider by a share of their size. */
  hit(ray: THREE.Ray, exaggeration: number, baseHeight: number, farthest: number, slack: number): Hit | undefined {
    const centre = this.object.position;
    const own = new THREE.Ray(ray.origin.clone().sub(centre), ray.direction);
    const earthCentre = this.uniforms["earthCentre"]!.value as THREE.Vector3;
    const raise = (place: THREE.Vector3, height: number) => raised(place, earthCentre, (exaggeration - 1) * (height - baseHeight));
    const { corners, representatives } = this.tile;
    const places = this.places.image.data as Uint32Array;
    const surface = { corners, texels: this.spots.texels, places, vertexCount: representatives.length, triangleCount: this.drawn };
    return firstHit(own, surface, raise, farthest, slack);
  }

  /** Where the drawn surface is as high as a multiple of `interval`, as pieces of lines in the frame, without exaggeration. */
  contours(interval: number): ContourPiece[] {
    const places = this.places.image.data as Uint32Array;
    const pieces: ContourPiece[] = [];
    for (let at = 0; at < 3 * this.drawn; at += 3) {
      const corners = [0, 1, 2].map((corner) => 4 * places[2 * this.tile.corners[at + corner]!]!);
      const heights = corners.map((corner) => this.spots.texels[corner + 3]!);
      const height = interval * Math.ceil(Math.min(...heights) / interval);
      if (height >= Math.max(...heights)) continue;
      const ends: THREE.Vector3[] = [];
      for (const [from, to] of [[0, 1], [1, 2], [2, 0]] as const) {
        const share = (height - heights[from]!) / (heights[to]! - heights[from]!);
        if (!(share >= 0 && share < 1)) continue;
        const [start, end] = [from, to].map((corner) => new THREE.Vector3().fromArray(this.spots.texels, corners[corner])) as [THREE.Vector3, THREE.Vector3];
        ends.push(start.lerp(end, share).add(this.object.position));
      }
      if (ends.length === 2) pieces.push({ height, ends: [ends[0]!, ends[1]!] });
    }
    return pieces;
  }

  setWireframe(visible: boolean): void {
    if (visible && this.wire === undefined) {
      this.wire = wireOf(this.tile, this.uniforms);
      this.object.add(this.wire);
      this.drawTriangles(this.drawn);
    }
    if (this.wire !== undefined) this.wire.visible = visible;
  }

  dispose(): void {
    this.useSpots(this.ownSpots);
    for (const part of [this.geometry, this.ownSpots, this.places, this.surface.material, this.filled, this.water]) part?.dispose();
    this.wire?.geometry.dispose();
    (this.wire?.material as THREE.Material | undefined)?.dispose();
  }

  private drawTriangles(count: number): void {
    this.drawn = count;
    this.geometry.setDrawRange(0, 3 * count);
    this.wire?.geometry.setDrawRange(0, INDICES_OF_EDGES * count);
  }

  private draw(from: Uint32Array, to: Uint32Array, triangles: number): void {
    const texels = this.places.image.data as Uint32Array;
    for (let vertex = 0; vertex < to.length; vertex++) {
      texels[2 * vertex] = to[vertex]!;
      texels[2 * vertex + 1] = from[vertex]!;
    }
    this.places.needsUpdate = true;
    this.drawTriangles(triangles);
  }

  private useSpots(spots: SpotTextures): void {
    if (this.spots !== spots && this.spots !== this.ownSpots) this.spots.dispose();
    this.spots = spots;
    this.positions.value = spots.positions;
    this.squares.value = spots.squares;
  }
}

/** Places as textures: in the frame, relative to the tile's own centre so that single precision is enough, and in its square. */
class SpotTextures {
  /** x, y, z and the height. */
  readonly texels: Float32Array<ArrayBuffer>;
  /** From 0 to 1 eastwards and northwards. */
  readonly inSquare: Float32Array<ArrayBuffer>;
  readonly positions: THREE.DataTexture;
  readonly squares: THREE.DataTexture;
  private readonly count: number;

  /** Of a tile's spots; behind those that `own` has, where it is given. */
  constructor(
    spots: readonly Spot[],
    private readonly address: Address,
    private readonly centre: THREE.Vector3,
    own?: SpotTextures,
  ) {
    const first = own?.count ?? 0;
    this.count = first + spots.length;
    this.texels = padded(Float32Array, 4 * this.count, 4);
    this.inSquare = padded(Float32Array, 2 * this.count, 2);
    if (own !== undefined) {
      this.texels.set(own.texels.subarray(0, 4 * first));
      this.inSquare.set(own.inSquare.subarray(0, 2 * first));
    }
    const [west, south] = tileBounds(address);
    const degrees = degreesOf(address.zoom);
    for (let at = 0; at < spots.length; at++) {
      const { longitude, latitude, height, position } = spots[at]!;
      const [texel, square] = [4 * (first + at), 2 * (first + at)];
      this.texels[texel] = position.x - centre.x;
      this.texels[texel + 1] = position.y - centre.y;
      this.texels[texel + 2] = position.z - centre.z;
      this.texels[texel + 3] = height;
      this.inSquare[square] = (longitude - west) / degrees;
      this.inSquare[square + 1] = (latitude - south) / degrees;
    }
    this.positions = dataTexture(this.texels, THREE.RGBAFormat, THREE.FloatType, "RGBA32F", 4);
    this.squares = dataTexture(this.inSquare, THREE.RGFormat, THREE.FloatType, "RG32F", 2);
  }

  get byteLength(): number {
    return this.texels.byteLength + this.inSquare.byteLength;
  }

  /** The same and others behind them. */
  with(others: readonly Spot[]): SpotTextures {
    return new SpotTextures(others, this.address, this.centre, this);
  }

  dispose(): void {
    this.positions.dispose();
    this.squares.dispose();
  }
}

/** An array of whole texture rows. */
function padded<T>(Array: new (length: number) => T, length: number, channels: number): T {
  const row = TEXTURE_WIDTH * channels;
  return new Array(Math.max(1, Math.ceil(length / row)) * row);
}

function dataTexture(
  texels: Float32Array<ArrayBuffer> | Uint32Array<ArrayBuffer>,
  format: THREE.PixelFormat,
  type: THREE.TextureDataType,
  internalFormat: THREE.PixelFormatGPU,
  channels: number,
): THREE.DataTexture {
  const rows = texels.length / channels / TEXTURE_WIDTH;
  const texture = new THREE.DataTexture(texels, TEXTURE_WIDTH, rows, format, type);
  texture.internalFormat = internalFormat;
  texture.needsUpdate = true;
  return texture;
}

function cellTexture(texels: Uint8Array<ArrayBuffer>, cells: number): THREE.DataTexture {
  const texture = new THREE.DataTexture(texels, cells, cells, THREE.RedFormat, THREE.UnsignedByteType);
  texture.needsUpdate = true;
  return texture;
}

function surfaceMaterial(uniforms: Record<string, THREE.IUniform>): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    uniforms: { ...uniforms, lift: { value: 1 } },
    vertexShader: TERRAIN_VERTEX,
    fragmentShader: TERRAIN_FRAGMENT,
    side: THREE.DoubleSide,
  });
}

/** The edges of the triangles in their order, so that what is drawn is a prefix as well. */
function wireOf(tile: Tile, uniforms: Record<string, THREE.IUniform>): THREE.LineSegments {
  const edges = new Uint32Array(2 * tile.corners.length);
  for (let at = 0; at < tile.corners.length; at += 3) {
    const [a = 0, b = 0, c = 0] = tile.corners.subarray(at, at + 3);
    edges.set([a, b, b, c, c, a], 2 * at);
  }
  const geometry = new THREE.BufferGeometry().setIndex(new THREE.BufferAttribute(edges, 1));
  geometry.boundingSphere = new THREE.Sphere();
  const wire = new THREE.LineSegments(geometry, wireMaterial(uniforms));
  wire.frustumCulled = false;
  wire.renderOrder = 1;
  return wire;
}

function wireMaterial(uniforms: Record<string, THREE.IUniform>): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    uniforms: { ...uniforms, lift: { value: LINE_LIFT } },
    vertexShader: TERRAIN_VERTEX,
    fragmentShader: WIRE_FRAGMENT,
    transparent: true,
    depthWrite: false,
  });
}
