// One tileset in the scene: selects, loads, shows, and blends from one level of detail to the next.

import * as THREE from "three";
import { degreesOf, keyOf, type Address } from "./address.ts";
import { CLOCK } from "./circuit_breaker.ts";
import { colourScaleOf, type ColourScale } from "./colour_scale.ts";
import { isFilled } from "./filled.ts";
import { FinerLight } from "./finer_light.ts";
import { Frame, tileBounds } from "./frame.ts";
import { COARSEST_DETAIL, finestDetail, triangleCount, type Detail } from "./partition.ts";
import { select, type Choice, type Selection } from "./select.ts";
import { Sight, type Camera, type Ellipsoid } from "./sight.ts";
import { geographic, raised, type GroundPoint, type Hit } from "./ground.ts";
import { largestMotion, Morph, type Moving } from "./morph.ts";
import { detailFor, imageryFault, picturesOf, type Imagery, type Picture } from "./imagery.ts";
import { normalsOf, rasterLoader, squareForLight } from "./normals.ts";
import { STYLES } from "./shaders.ts";
import type { SquareRaster, SquareRasters } from "./square_rasters.ts";
import { distanceTo, solidAngle, type OrientedBox } from "./oriented_box.ts";
import { interiorLevels, type Tile } from "./spt.ts";
import type { ContourPiece, SharedUniforms, TileMesh } from "./tile_mesh.ts";
import { CACHE_BYTES, TileStore } from "./tile_store.ts";
import { isGlobe, type Tileset } from "./tileset.ts";

/** What is on the screen. */
export interface Stats {
  readonly tiles: number;
  readonly triangles: number;
  /** Lowest and highest zoom drawn; undefined while nothing is. */
  readonly zooms: readonly [number, number] | undefined;
  /** Largest certified vertical error of what is drawn, metres. */
  readonly error: number;
  /** Compressed bytes of all tiles loaded so far. */
  readonly bytes: number;
  /** And of all rasters of normals. */
  readonly normalsBytes: number;
  /** And of all imagery. */
  readonly imageryBytes: number;
}

/** A way to draw a tile. */
export interface TileLevelView {
  readonly detail: Detail;
  /** Certified, metres. */
  readonly error: number;
  readonly triangles: number;
}

/** A tile and where each of its vertices is drawn when it comes in. */
export interface DrawnTile {
  readonly tile: Tile;
  readonly places: readonly THREE.Vector3[];
}

/** How terrain is drawn. */
export interface TerrainSettings {
  /** Pixels that what is drawn may be off the source. */
  readonly maxPixels: number;
  /** Heights are drawn so many times larger. */
  readonly exaggeration: number;
  /** Which of the styles, by its place in the list of them. */
  readonly style: number;
  /** What colours of heights mean; what the archive's own heights make of it where this is not said. */
  readonly colours: ColourScale | undefined;
  /** Whether lines of equal height are drawn. */
  readonly contours: boolean;
  /** Whether ground that was filled is told apart; in the style of certified errors it always is. */
  readonly filled: boolean;
  readonly wireframe: boolean;
  /** Whether light comes from rasters of normals, which have to be loaded, where the source has them. */
  readonly detailedLight: boolean;
  /** What the style for it shows; none is loaded without one. */
  readonly imagery: Imagery | undefined;
}

export const DEFAULT_SETTINGS: TerrainSettings = {
  maxPixels: 2,
  exaggeration: 1,
  style: 0,
  colours: undefined,
  contours: false,
  filled: false,
  wireframe: false,
  detailedLight: true,
  imagery: undefined,
};

/** A blend takes as long, or longer where much moves, but not for ever. */
const [SHORTEST_BLEND_MILLISECONDS, LONGEST_BLEND_MILLISECONDS] = [250, 1000];
/** What may be drawn at once, and how much finer than asked a picture has to be before a coarser one takes its place. */
const BUDGET = { triangles: 4e6, bytes: CACHE_BYTES, keep: 0.8 };
const CONTOURS_PER_RANGE = 25;
/** A view that has all it needs, and has not moved for so long, gets finer light. */
const REST_MILLISECONDS = 500;
/** Shares of the picture, and of distances, that are no move. */
const SAME = 1e-7;
/** Metres: no ground is lower. */
const BELOW_ALL = -1e9;
/** From afar, colours tell heights that cover no pixel: errors count as if all heights together covered so many at least. */
const LEAST_PIXELS_OF_HEIGHTS = 32;
/** Metres above the ellipsoid from where the ground is looked for, and how far beside a tile, in its widths, it may be found. */
const [FROM_ABOVE, EDGE] = [100_000, 1e-6];
/** By how much triangles are wider where a ray meets none: tiles beside each other round a vertex of their common side apart. */
const SLACK = 1e-4;
/** Data that cover no more than the square of so many pixels are not seen. */
const SPECK_PIXELS = 4;
/** Metres, of vertices and of a ray that runs along the side of a box. */
const ROUNDING = 1;

/** A tile in the scene, and the error of its level, metres. */
type Drawn = Pick<Choice, "address" | "error">;

/** Where a ray meets one. */
type Met = Hit & Drawn;

/** A tileset, drawn for a view that moves. */
export class TerrainLayer {
  readonly group = new THREE.Group();
  readonly frame: Frame;
  /** Holds the data, without exaggeration. */
  readonly box: THREE.Box3;
  readonly uniforms: SharedUniforms;
  /** Holds the data, along east, north and up in their middle. */
  private readonly dataBox: OrientedBox;
  /** What the heights of the archive make of colours. */
  readonly ownColours: ColourScale;
  private readonly store: TileStore;
  private readonly morph = new Morph<Choice>((address) => this.store.get(address));
  private readonly normals: SquareRasters<SquareRaster>;
  private readonly finerLight: FinerLight;
  private pictures: SquareRasters<Picture> | undefined;
  private settings = DEFAULT_SETTINGS;
  private alone: Choice | undefined;
  private shown = new Map<string, Choice>();
  /** What is in the scene: while the picture changes, not what is shown yet. */
  private drawn = new Map<string, Drawn>();
  private blend = { share: 1, step: 1, isRunning: false };
  private lastUpdate = 0;
  /** What the camera makes of the frame, and whether it has been the same for a while, with all that it needs. */
  private readonly view = new THREE.Matrix4();
  private isAtRest = false;
  private cancelRest: (() => void) | undefined;
  /** Whether something has changed since tiles were asked for, and since the picture was chosen. */
  private isStale = true;
  private isPictureStale = true;
  private missing = 0;

  /** `onChange` is called when something new could be drawn. */
  constructor(
    readonly tileset: Tileset,
    private readonly onChange: () => void = () => {},
  ) {
    const { bounds, heights } = tileset.metadata;
    const [longitude, latitude] = [(bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2];
    // A globe is turned about its axis, with the pole that is in the data, or the northern one, on top.
    this.frame = new Frame(longitude, isGlobe(tileset.metadata) ? (latitude < 0 ? -90 : 90) : latitude);
    this.box = this.frame.box(bounds, heights);
    this.dataBox = this.frame.orientedBox(bounds, heights);
    this.uniforms = {
      exaggeration: { value: 1 },
      baseHeight: { value: heights[0] },
      heights: { value: new THREE.Vector2(...heights) },
      landFrom: { value: 0 },
      seaLevel: { value: BELOW_ALL },
      contourInterval: { value: 1 },
      hazeDistance: { value: Math.max(60_000, 2.5 * this.box.getSize(new THREE.Vector3()).length()) },
      clearDistance: { value: 0 },
      style: { value: 0 },
      contours: { value: false },
      showsFilled: { value: false },
      axis: { value: this.frame.axis },
    };
    this.ownColours = colourScaleOf(tileset.metadata);
    this.setColours();
    this.normals = normalsOf(tileset.source, () => this.invalidate());
    this.finerLight = new FinerLight(rasterLoader(tileset.source), this.normals, () => this.invalidate());
    this.store = new TileStore(tileset, this.frame, this.uniforms, () => this.invalidate());
  }

  /** What is wrong, in one line. */
  get failure(): string | undefined {
    return this.store.failure ?? (this.shownPictures && imageryFault(this.shownPictures));
  }

  private get shownPictures(): SquareRasters<Picture> | undefined {
    return STYLES[this.settings.style] === "Imagery" ? this.pictures : undefined;
  }

  /** Whether nothing will change until the view does, but for the light of a view that rests. */
  get isSettled(): boolean {
    return !this.isPictureStale && !this.blend.isRunning && !this.isLoading;
  }

  /** Whether the view has come to rest, and all finer light is in it that there is. */
  get isFinished(): boolean {
    return this.isSettled && this.isAtRest && !this.finerLight.isLoading && !this.finerLight.isFading;
  }

  /** Whether something that the view needs is not here yet. */
  get isLoading(): boolean {
    return this.missing > 0 || this.store.isLoading || this.normals.isLoading || this.pictures?.isLoading === true;
  }

  /** Where a ray in the scene first meets the ground that is drawn. */
  hit(ray: THREE.Ray): GroundPoint | undefined {
    const met = this.firstMet(ray, [...this.drawn.values()]);
    return met && this.groundPoint(ray, met);
  }

  /** The ground that is drawn at a longitude and latitude. */
  groundAt(longitude: number, latitude: number): GroundPoint | undefined {
    const surface = this.frame.position(longitude, latitude, 0);
    const down = surface.sub(this.frame.position(longitude, latitude, 1)).normalize();
    const ray = new THREE.Ray(this.frame.position(longitude, latitude, FROM_ABOVE), down);
    const isAround = ({ address }: Drawn) => {
      const degrees = degreesOf(address.zoom);
      const [x, y] = [(longitude + 180) / degrees - address.x, (latitude + 90) / degrees - address.y];
      return Math.min(x, y) >= -EDGE && Math.max(x, y) <= 1 + EDGE;
    };
    const met = this.firstMet(ray, [...this.drawn.values()].filter(isAround));
    return met && { ...this.groundPoint(ray, met), longitude, latitude };
  }

  /** Where a ray first meets one of the tiles; where it slips between them, the triangle beside it. The nearest tiles are asked first. */
  private firstMet(ray: THREE.Ray, tiles: readonly Drawn[]): Met | undefined {
    const margin = Math.abs(this.store.raise) + ROUNDING;
    const entry = new THREE.Vector3();
    const along = tiles.flatMap(({ address, error }) => {
      const mesh = this.store.get(address)?.mesh;
      const box = mesh?.box.clone().expandByScalar(margin);
      if (mesh === undefined || box === undefined || ray.intersectBox(box, entry) === null) return [];
      return [{ mesh, address, error, from: box.containsPoint(ray.origin) ? 0 : entry.distanceTo(ray.origin) }];
    });
    let [met, beside]: [Met | undefined, Met | undefined] = [undefined, undefined];
    for (const { mesh, address, error, from } of along.sort((a, b) => a.from - b.from)) {
      if (met !== undefined && from > met.distance) break;
      const hit = mesh.hit(ray, this.uniforms.exaggeration.value, this.uniforms.baseHeight.value, met?.distance ?? Infinity, SLACK);
      if (hit?.isInside === true) met = { ...hit, address, error };
      else if (hit !== undefined && hit.distance < (beside?.distance ?? Infinity)) beside = { ...hit, address, error };
    }
    return met ?? beside;
  }

  /** Whether a camera of the same scene sees any data, and more than a speck of them, in a picture so many pixels high. */
  isInSight(from: THREE.PerspectiveCamera, pixelsHigh: number): boolean {
    const camera = this.seenFrom(from, pixelsHigh);
    const pixels = (Math.sqrt(solidAngle(this.dataBox, camera.eye)) * pixelsHigh) / (2 * halfHeightOf(from));
    const isNear = distanceTo(this.dataBox, camera.eye) === 0;
    return new Sight(camera).sees(this.dataBox) && (isNear || pixels >= SPECK_PIXELS);
  }

  /** Pieces of the contour lines of the tiles that are in sight, where they are drawn. */
  contourPieces(): ContourPiece[] {
    const { contourInterval } = this.uniforms;
    const meshes = [...this.drawn.values()].flatMap(({ address }) => this.store.get(address)?.mesh ?? []);
    const pieces = meshes.filter(({ object }) => object.visible).flatMap((mesh) => mesh.contours(contourInterval.value));
    for (const { height, ends } of pieces) for (const end of ends) this.raised(end, height);
    return pieces;
  }

  /** The tile that is drawn at a longitude and latitude. */
  tileAt(longitude: number, latitude: number): Address | undefined {
    const isInside = ({ zoom, x, y }: Address) => {
      const degrees = degreesOf(zoom);
      return Math.floor((longitude + 180) / degrees) === x && Math.floor((latitude + 90) / degrees) === y;
    };
    return [...this.shown.values()].find(({ address }) => isInside(address))?.address;
  }

  /** What a drawn tile can be drawn as: its interior levels, coarsest first, and the finest with all sides fine. */
  levelsOf(address: Address): TileLevelView[] {
    const levels = this.store.allLevels(address);
    if (levels.length === 0) return [];
    const interiors = Array.from({ length: interiorLevels({ levels }) }, (_, interior) => ({ ...COARSEST_DETAIL, interior }));
    return [...interiors, finestDetail({ levels })].map((detail) => {
      const { error } = levels[detail.interior]!;
      return { detail, error, triangles: triangleCount({ levels }, detail) };
    });
  }

  /** As much of a tile as is loaded. */
  drawnTile(address: Address): DrawnTile | undefined {
    const found = this.store.get(address);
    if (found === undefined) return undefined;
    const { tile, spots } = found;
    const vertices = spots.slice(0, tile.representatives.length);
    return { tile, places: vertices.map(({ position, height }) => this.raised(position.clone(), height)) };
  }

  /** Draws one tile that is drawn now, alone, at one of its levels; again all that the view needs without one. */
  showAlone(address: Address | undefined, level?: TileLevelView): void {
    this.alone = address && level && { address, ...level.detail, error: level.error };
    this.invalidate();
  }

  /** Moves a place of a height to where the exaggeration draws it, or back. */
  private raised(place: THREE.Vector3, height: number, direction: 1 | -1 = 1): THREE.Vector3 {
    const { exaggeration, baseHeight } = this.uniforms;
    return raised(place, this.frame.earthCentre, direction * (exaggeration.value - 1) * (height - baseHeight.value));
  }

  private groundPoint(ray: THREE.Ray, { distance, height, address, error }: Met): GroundPoint {
    const position = ray.at(distance, new THREE.Vector3());
    const place = geographic(this.frame, this.raised(position.clone(), height, -1));
    return { distance, height, position, ...place, error: this.isFilledAt(address, place) ? undefined : error };
  }

  private isFilledAt(address: Address, { longitude, latitude }: Pick<GroundPoint, "longitude" | "latitude">): boolean {
    const filled = this.store.get(address)?.cells.filled;
    const [[west, south], degrees] = [tileBounds(address), degreesOf(address.zoom)];
    return filled !== undefined && isFilled(filled, (longitude - west) / degrees, (latitude - south) / degrees);
  }

  /** Changes some of the settings. */
  set(changes: Partial<TerrainSettings>): void {
    const { imagery } = this.settings;
    this.settings = { ...this.settings, ...changes };
    const { exaggeration, style, contours, filled, wireframe } = this.settings;
    this.uniforms.exaggeration.value = exaggeration;
    this.uniforms.style.value = style;
    this.setColours();
    this.uniforms.contours.value = contours;
    this.uniforms.showsFilled.value = filled || STYLES[style] === "Certified error";
    for (const { address } of this.drawn.values()) this.store.get(address)?.mesh.setWireframe(wireframe);
    if (this.settings.imagery !== imagery) this.changePictures();
    this.invalidate();
  }

  /** Where there is sea is a matter of the archive, whatever scale it shares. */
  private setColours(): void {
    const { ends: [lowest, highest], seaLevel } = this.settings.colours ?? this.ownColours;
    this.uniforms.heights.value.set(lowest, highest);
    this.uniforms.landFrom.value = seaLevel ?? lowest;
    this.uniforms.seaLevel.value = this.ownColours.seaLevel ?? BELOW_ALL;
    this.uniforms.contourInterval.value = niceInterval((highest - lowest) / CONTOURS_PER_RANGE);
  }

  /** Nothing that is drawn is below it; it hides what is beyond the horizon. */
  private get ground(): Ellipsoid {
    const { heights, zooms } = this.tileset.metadata;
    return this.frame.ellipsoid(heights[0] - Math.max(...zooms.map((zoom) => zoom.coarsest_error)));
  }

  /** The next update selects anew. */
  invalidate(): void {
    this.isStale = true;
    this.isPictureStale = true;
    this.onChange();
  }

  /**
   * Brings what is drawn up to date for a camera of the same scene, in a picture so many pixels high.
   * Call it before each frame; `now` is milliseconds, as of an animation loop. A blend once begun runs to its end before the
   * next picture; what that will need is asked for already.
   */
  update(from: THREE.PerspectiveCamera, pixelsHigh: number, now: number): void {
    const camera = this.seenFrom(from, pixelsHigh);
    if (!isSameView(camera.view, this.view)) {
      this.view.copy(camera.view);
      this.leaveRest();
    }
    const elapsed = now - this.lastUpdate;
    this.lastUpdate = now;
    this.advanceBlend(elapsed);
    if (this.finerLight.isFading) this.fadeLight(elapsed);
    const sight = new Sight(camera);
    if (this.isStale || (this.isPictureStale && !this.blend.isRunning)) this.reselect(camera, sight);
    for (const { address } of this.drawn.values()) {
      const object = this.store.get(address)?.mesh.object;
      if (object !== undefined) object.visible = sight.sees(this.store.bounds(address));
    }
    if (this.blend.isRunning || this.finerLight.isFading) this.onChange();
    if (this.isSettled && !this.isAtRest) this.cancelRest ??= CLOCK.after(REST_MILLISECONDS, () => this.rest());
  }

  stats(): Stats {
    const choices = [...this.shown.values()];
    const zooms = choices.map(({ address }) => address.zoom);
    const trianglesOf = (choice: Choice) => {
      const tile = this.store.get(choice.address)?.tile;
      return tile === undefined ? 0 : triangleCount(tile, choice);
    };
    return {
      tiles: choices.length,
      triangles: choices.reduce((sum, choice) => sum + trianglesOf(choice), 0),
      zooms: zooms.length > 0 ? [Math.min(...zooms), Math.max(...zooms)] : undefined,
      error: choices.reduce((worst, { error }) => Math.max(worst, error), 0),
      bytes: this.store.bytesLoaded,
      normalsBytes: this.normals.bytesLoaded + this.finerLight.bytesLoaded,
      imageryBytes: this.pictures?.bytesLoaded ?? 0,
    };
  }

  dispose(): void {
    this.leaveRest();
    this.store.close();
    this.finerLight.close();
    this.normals.close();
    this.pictures?.close();
    this.group.clear();
  }

  /** What the selection knows of a camera, in the frame. */
  private seenFrom(from: THREE.PerspectiveCamera, pixelsHigh: number): Camera & { readonly view: THREE.Matrix4 } {
    from.updateMatrixWorld();
    this.group.updateWorldMatrix(true, false);
    const toFrame = this.group.matrixWorld.clone().invert();
    const toClip = from.projectionMatrix.clone().multiply(from.matrixWorldInverse).multiply(this.group.matrixWorld);
    const { x: lowest, y: highest } = this.uniforms.heights.value;
    const pixelsPerRadian = pixelsHigh / (2 * halfHeightOf(from));
    return {
      eye: new THREE.Vector3().setFromMatrixPosition(from.matrixWorld).applyMatrix4(toFrame),
      pixelsPerRadian: Math.abs(this.uniforms.exaggeration.value) * pixelsPerRadian,
      farthest: (Math.max(highest - lowest, 1) * pixelsPerRadian) / LEAST_PIXELS_OF_HEIGHTS,
      frustum: new THREE.Frustum().setFromProjectionMatrix(toClip).planes,
      ground: this.ground,
      view: toClip,
    };
  }

  private rest(): void {
    this.cancelRest = undefined;
    this.isAtRest = true;
    this.invalidate();
  }

  private leaveRest(): void {
    this.isAtRest = false;
    this.cancelRest?.();
    this.cancelRest = undefined;
  }

  private advanceBlend(elapsed: number): void {
    if (!this.blend.isRunning) return;
    const step = Math.max(this.blend.step, elapsed / LONGEST_BLEND_MILLISECONDS);
    this.blend.share = Math.min(1, this.blend.share + Math.min(elapsed / SHORTEST_BLEND_MILLISECONDS, step));
    if (this.blend.share < 1) {
      for (const { address } of this.drawn.values()) this.meshOf(address).setBlend(this.blend.share);
      return;
    }
    this.blend.isRunning = false;
    this.drawn = new Map(this.shown);
    for (const choice of this.shown.values()) this.meshOf(choice.address).show(choice);
    this.putInScene();
  }

  private reselect(camera: Camera, sight: Sight): void {
    this.isStale = false;
    if (!this.blend.isRunning) this.store.takeUp();
    this.store.startSelection();
    // What is drawn is not dropped, whatever is selected.
    for (const { address } of this.drawn.values()) this.store.levels(address);
    const demand = { ...BUDGET, tolerance: this.settings.maxPixels };
    const { choices, requests } = this.alone === undefined ? select(this.store, camera, demand, [...this.shown.values()]) : this.selectAlone(this.alone);
    if (!this.blend.isRunning) {
      this.isPictureStale = false;
      this.show(choices, camera);
    }
    this.missing = requests.length;
    this.store.request(requests);
    // Tiles come first: what lies on coarser ones would soon be of no use.
    if (this.store.isLoading || this.store.hasMore) return;
    const seen = choices.filter(({ address }) => sight.sees(this.store.bounds(address)));
    if (this.settings.detailedLight && this.tileset.source.normals !== undefined) {
      const lit = seen.map(({ address }) => squareForLight(address, this.meanPixelsAcross(address, camera)));
      this.normals.request(lit.map((address) => ({ address, detail: 0 })));
      if (this.isAtRest && !this.normals.isLoading) this.refineLight(seen, camera, sight);
    }
    this.shownPictures?.request(seen.map(({ address }) => ({ address, detail: detailFor(this.pixelsAcross(address, camera), address) })));
  }

  /** Once all of the tile is loaded. */
  private selectAlone(choice: Choice): Pick<Selection, "choices" | "requests"> {
    const { address } = choice;
    const levels = this.store.allLevels(address).length;
    const isThere = this.store.levelsThere(address) === levels;
    return isThere ? { choices: [choice], requests: [] } : { choices: [...this.shown.values()], requests: [{ address, levels }] };
  }

  private refineLight(tiles: readonly Choice[], camera: Camera, sight: Sight): void {
    const isThere = this.finerLight.load(
      tiles.map(({ address }) => address),
      {
        pixels: (square) => (this.isNear(square, camera) ? this.pixelsAcross(square, camera) : this.meanPixelsAcross(square, camera)),
        isInSight: (square) => sight.sees(this.store.bounds(square)),
        exists: (square) => this.store.exists(square),
      },
    );
    if (isThere) this.putInScene();
  }

  private fadeLight(elapsed: number): void {
    this.finerLight.fade(elapsed);
    for (const { address } of this.drawn.values()) this.meshOf(address).setFinerNormals(this.finerLight.patchOf(address));
  }

  /** Whether a tile's parts are at distances so different that there is no mean of them. */
  private isNear(address: Address, { eye }: Camera): boolean {
    const box = this.store.bounds(address);
    return distanceTo(box, eye) < 2 * box.halfSizes[1];
  }

  /** Pixels that a tile's side covers where it is nearest; those of the exaggeration do not count. */
  private pixelsAcross(address: Address, { eye, pixelsPerRadian }: Camera): number {
    const box = this.store.bounds(address);
    return (2 * box.halfSizes[1] * pixelsPerRadian) / Math.abs(this.uniforms.exaggeration.value) / Math.max(distanceTo(box, eye), 1);
  }

  /** And that it covers on the whole: most tiles are seen from aside. */
  private meanPixelsAcross(address: Address, { eye, pixelsPerRadian }: Camera): number {
    const seen = Math.sqrt(solidAngle(this.store.bounds(address), eye)) * pixelsPerRadian;
    return seen / Math.abs(this.uniforms.exaggeration.value);
  }

  private changePictures(): void {
    const { imagery } = this.settings;
    this.pictures?.close();
    this.pictures = imagery && picturesOf(imagery, () => this.invalidate());
  }

  /** Draws a picture, beginning with the one before it. */
  private show(choices: readonly Choice[], camera: Camera): void {
    const before = this.shown;
    this.shown = new Map(choices.map((choice) => [keyOf(choice.address), choice]));
    const moving = this.morph.between(before, this.shown);
    this.drawn = new Map(moving.map(({ address, before, after }) => [keyOf(address), { address, error: Math.max(before.error, after.error) }]));
    const hidden = new Set(moving.map(({ after }) => keyOf(after.address)));
    for (const [key, choice] of this.shown) {
      // It follows when what is drawn in its place has become it.
      if (hidden.has(key)) continue;
      this.drawn.set(key, choice);
      this.meshOf(choice.address).show(choice);
    }
    for (const moved of moving) this.meshOf(moved.address).move(moved);
    this.blend = { share: 0, step: this.largestStep(moving, camera), isRunning: moving.length > 0 };
    this.putInScene();
  }

  private putInScene(): void {
    this.group.clear();
    const { detailedLight } = this.settings;
    this.finerLight.place(detailedLight ? [...this.drawn.values()].map(({ address }) => address) : [], this.isAtRest);
    for (const { address, error } of this.drawn.values()) {
      const mesh = this.meshOf(address);
      this.group.add(mesh.object);
      mesh.setWireframe(this.settings.wireframe);
      mesh.setError(error);
      mesh.setNormals(detailedLight ? this.normals.finest(address) : undefined);
      mesh.setFinerNormals(this.finerLight.patchOf(address));
      mesh.setPicture(this.pictures?.finest(address));
    }
  }

  private meshOf(address: Address): TileMesh {
    return this.store.get(address)!.mesh;
  }

  /**
   * How far a blend may go in one frame, so that the ground moves by no more pixels than it may be off.
   */
  private largestStep(moving: readonly Moving<Choice>[], camera: Camera): number {
    const sight = new Sight(camera);
    const scale = (place: THREE.Vector3) => camera.pixelsPerRadian / place.distanceTo(camera.eye);
    const seen = moving.filter(({ address }) => sight.sees(this.store.bounds(address)));
    const pixels = seen.map((moved) => largestMotion(this.store.get(moved.address)!.tile, moved, scale));
    return this.settings.maxPixels / Math.max(...pixels, 1e-6);
  }
}

/** But for what an orbit rounds, which computes its place anew in each frame: shares of the longest number in a column. */
function isSameView({ elements }: THREE.Matrix4, other: THREE.Matrix4): boolean {
  const longest = (column: number) => Math.max(...elements.slice(4 * column, 4 * column + 4).map(Math.abs));
  return elements.every((element, at) => Math.abs(element - other.elements[at]!) <= SAME * longest(at >> 2));
}

/** Of the picture, at a distance of 1. */
function halfHeightOf(camera: THREE.PerspectiveCamera): number {
  return Math.tan(THREE.MathUtils.degToRad(camera.getEffectiveFOV() / 2));
}

/** 1, 2 or 5 times a power of ten, at least `least`. */
function niceInterval(least: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(least, 0.01)));
  return power * ([1, 2, 5].find((factor) => factor * power >= least) ?? 10);
}
