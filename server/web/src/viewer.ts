// The scene, the camera and the loop. Draws only when something has changed.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { Address } from "./address.ts";
import { fitToCanvas } from "./canvas.ts";
import type { ColourScale } from "./colour_scale.ts";
import { FlyControls } from "./fly_controls.ts";
import { geographic, type GroundPoint } from "./ground.ts";
import { bearingOf, lookOf, turnOf, type Axes, type Look, type Pose } from "./pose.ts";
import { SKY_FRAGMENT, SKY_VERTEX } from "./shaders.ts";
import { tileDecoders } from "./tile_decoders.ts";
import type { ContourPiece } from "./tile_mesh.ts";
import { DEFAULT_SETTINGS, TerrainLayer, type DrawnTile, type Stats, type TerrainSettings, type TileLevelView } from "./terrain_layer.ts";
import { isGlobe, type Tileset } from "./tileset.ts";

const FIELD_OF_VIEW_DEGREES = 45;
/** Of the first view: looking north-north-west, this far down. */
const FIRST_VIEW = { azimuthDegrees: 335, downDegrees: 32, fill: 0.8 };
const LONGEST_STEP_SECONDS = 0.1;
/** Metres that the camera stays above the ground. */
const CLEARANCE = 2;
/** Metres above the camera from where the ground below it is looked for. */
const FROM_ABOVE = 50_000;
/** Pixels that an arrow key moves the view, and how much nearer + brings it. */
const [KEY_PIXELS, KEY_ZOOM] = [40, 0.8];
/** Degrees from straight down that the orbit goes around ground which is nearly a plane. */
const MOST_POLAR_DEGREES = 89;
/** Radians from straight down and up that the orbit keeps, so that it has what is up in the picture. */
const LEAST_POLAR_ANGLE = 1e-6;
/** The sine of an angle from the orbit's axis: nearer, what is ahead tells too little of what is up in the picture. */
const ALONG_AXIS = 0.03;
/** Around whose up the orbit turns. */
const SCENE: Axes = { east: new THREE.Vector3(1, 0, 0), north: new THREE.Vector3(0, 1, 0), up: new THREE.Vector3(0, 0, 1) };

/** Shows one tileset at a time on a canvas. */
export class Viewer {
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW_DEGREES, 1, 1, 1e8);
  private readonly orbit: OrbitControls;
  private readonly fly: FlyControls;
  private layer: TerrainLayer | undefined;
  private needsFrame = true;
  private isSteering = true;
  private isFlying = false;
  private lastFrame = 0;
  private waiting: (() => void)[] = [];
  private waitingForRest: (() => void)[] = [];
  private mostPolarAngle = Math.PI;

  /** `onFrame` is called after each frame that was drawn. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly onFrame: () => void = () => {},
    private settings: TerrainSettings = DEFAULT_SETTINGS,
  ) {
    tileDecoders.prepare();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, logarithmicDepthBuffer: true });
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.camera.up.copy(SCENE.up);
    this.scene.add(skyMesh());
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.zoomToCursor = true;
    this.orbit.keyPanSpeed = KEY_PIXELS;
    this.orbit.minDistance = 2 * CLEARANCE;
    this.orbit.addEventListener("change", () => this.moved());
    this.orbit.listenToKeyEvents(canvas);
    // Before the controls' own listeners: they turn around, and come nearer to, the ground in the middle of the view.
    for (const type of ["pointerdown", "wheel", "keydown"]) canvas.addEventListener(type, () => this.aim(), { capture: true });
    canvas.addEventListener("keydown", (event) => this.zoomByKey(event.key));
    canvas.addEventListener("pointerdown", () => canvas.focus());
    this.fly = new FlyControls(this.camera, canvas, () => this.moved());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.renderer.setAnimationLoop((now) => this.frame(now));
  }

  /** Replaces what is shown and looks at all of it from the south. */
  open(tileset: Tileset): void {
    this.close();
    this.layer = new TerrainLayer(tileset, () => this.redraw());
    this.layer.set(this.settings);
    this.scene.add(this.layer.group);
    // Of most of the Earth, the far side has its ground above the eye.
    this.mostPolarAngle = isGlobe(tileset.metadata) ? Math.PI : THREE.MathUtils.degToRad(MOST_POLAR_DEGREES);
    this.lookAtAll();
  }

  /** Shows nothing. */
  close(): void {
    if (this.layer !== undefined) this.scene.remove(this.layer.group);
    this.layer?.dispose();
    this.layer = undefined;
  }

  /** Frames the bounds of the data obliquely. */
  lookAtAll(): void {
    if (this.layer === undefined) return;
    const box = this.layer.box;
    const [size, target] = [box.getSize(new THREE.Vector3()), box.getCenter(new THREE.Vector3())];
    const radius = Math.hypot(size.x, size.y) / 2;
    const distance = (FIRST_VIEW.fill * radius) / Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2));
    this.orbit.maxDistance = 20 * radius;
    this.place(target, FIRST_VIEW.azimuthDegrees, FIRST_VIEW.downDegrees, distance);
  }

  /** Looks at a point on the ground (degrees, metres) from `distance` metres away. */
  flyTo(longitude: number, latitude: number, height: number, distance: number, azimuth = 335, down = 32): void {
    const target = this.layer?.frame.position(longitude, latitude, height);
    if (target !== undefined) this.place(target, azimuth, down, distance);
  }

  /** Changes some of the settings. */
  set(changes: Partial<TerrainSettings>): void {
    this.settings = { ...this.settings, ...changes };
    this.layer?.set(changes);
  }

  get tileset(): Tileset | undefined {
    return this.layer?.tileset;
  }

  /** Whether any data are before the camera, and more than a speck of them. */
  get hasDataInSight(): boolean {
    return this.layer?.isInSight(this.camera, this.renderer.domElement.height) ?? true;
  }

  /** What the heights of what is shown make of colours. */
  get ownColours(): ColourScale | undefined {
    return this.layer?.ownColours;
  }

  get isLoading(): boolean {
    return this.layer?.isLoading ?? false;
  }

  /** The ground at a place of the canvas, from -1 to 1 to the right and upwards. */
  groundAt(x: number, y: number): GroundPoint | undefined {
    const caster = new THREE.Raycaster();
    this.camera.updateMatrixWorld();
    caster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    return this.layer?.hit(caster.ray);
  }

  /** The ground that is drawn at a longitude and latitude. */
  groundBelow(longitude: number, latitude: number): GroundPoint | undefined {
    return this.layer?.groundAt(longitude, latitude);
  }

  /** The tile that is drawn in the middle of the view, and its levels. */
  tileInMiddle(): { address: Address; levels: readonly TileLevelView[] } | undefined {
    const ground = this.groundAt(0, 0);
    const address = ground && this.layer?.tileAt(ground.longitude, ground.latitude);
    return address && { address, levels: this.layer!.levelsOf(address) };
  }

  /** As much of a tile as is loaded. */
  drawnTile(address: Address): DrawnTile | undefined {
    return this.layer?.drawnTile(address);
  }

  /** Draws a tile alone, at one of its levels; all again without one. */
  showAlone(address: Address | undefined, level?: TileLevelView): void {
    this.layer?.showAlone(address, level);
  }

  /** Pieces of the contour lines; none while there are no lines. */
  contourPieces(): readonly ContourPiece[] {
    return this.settings.contours ? (this.layer?.contourPieces() ?? []) : [];
  }

  /** Pixels of the canvas, from its top left, where a place in the scene is seen; undefined behind the eye. */
  pixelOf(place: THREE.Vector3Like): readonly [number, number] | undefined {
    const seen = new THREE.Vector3().copy(place).applyMatrix4(this.camera.matrixWorldInverse);
    if (seen.z >= 0) return undefined;
    const { x, y } = seen.applyMatrix4(this.camera.projectionMatrix);
    return [((x + 1) / 2) * this.canvas.clientWidth, ((1 - y) / 2) * this.canvas.clientHeight];
  }

  /** Whether no ground is before a place in the scene. */
  isInSight(place: THREE.Vector3): boolean {
    const toPlace = place.clone().sub(this.camera.position);
    const distance = toPlace.length();
    const ground = this.layer?.hit(new THREE.Ray(this.camera.position.clone(), toPlace.normalize()));
    return ground === undefined || ground.distance > 0.99 * distance;
  }

  /** Adds to the scene, whose metres are those of the frame of what is shown. */
  add(object: THREE.Object3D): void {
    this.scene.add(object);
    this.redraw();
  }

  /** How high the camera is above the ground that is drawn; undefined where there is none. */
  metresAboveGround(): number | undefined {
    if (this.layer === undefined) return undefined;
    const up = this.up(this.layer);
    const high = this.camera.position.clone().addScaledVector(up, FROM_ABOVE);
    const ground = this.layer.hit(new THREE.Ray(high, up.clone().negate()));
    return ground === undefined ? undefined : ground.distance - FROM_ABOVE;
  }

  /** Metres that a pixel of the page covers at a distance. */
  metresPerPixel(distance: number): number {
    return (2 * distance * Math.tan(THREE.MathUtils.degToRad(FIELD_OF_VIEW_DEGREES / 2))) / this.canvas.clientHeight;
  }

  get pose(): Required<Pose> | undefined {
    const place = this.eyePlace();
    return place && { longitude: place.longitude, latitude: place.latitude, height: place.height, ...turnOf(this.look(), place.axes) };
  }

  /** Degrees from north to the east of what is upwards in the picture. */
  get bearing(): number | undefined {
    const place = this.eyePlace();
    return place && bearingOf(this.look(), place.axes);
  }

  /** Looks from where a pose is. */
  setPose(pose: Pose): void {
    if (this.layer === undefined) return;
    const { frame, tileset } = this.layer;
    const { longitude, latitude, height, down, roll } = pose;
    const { ahead, right } = lookOf(pose, frame.axesAt(longitude, latitude));
    const steepness = Math.max(Math.sin(THREE.MathUtils.degToRad(down)), 0.05);
    const distance = THREE.MathUtils.clamp((height - tileset.metadata.heights[0]) / steepness, 10, this.orbit.maxDistance);
    const upright = ahead.clone().cross(SCENE.up);
    const isOpen = roll === undefined && upright.length() > ALONG_AXIS;
    this.lookFrom(frame.position(longitude, latitude, height), { ahead, right: isOpen ? upright : right }, distance);
  }

  /** Turns the view around what is in its middle until north is up. */
  faceNorth(): void {
    this.aim();
    this.orbit.rotateLeft(this.orbit.getAzimuthalAngle());
  }

  /** Sees the same part of the Earth, in the same way, as another viewer, which then is the one to steer. */
  follow(leader: Viewer): void {
    if (this.layer === undefined || leader.layer === undefined) return;
    const toOwn = leader.layer.frame.matrixTo(this.layer.frame);
    const position = leader.camera.position.clone().applyMatrix4(toOwn);
    const turn = leader.camera.quaternion.clone().premultiply(new THREE.Quaternion().setFromRotationMatrix(toOwn));
    if (position.equals(this.camera.position) && turn.equals(this.camera.quaternion)) return;
    this.camera.position.copy(position);
    this.camera.quaternion.copy(turn);
    this.orbit.target.copy(leader.orbit.target).applyMatrix4(toOwn);
    this.moved();
  }

  /** What does not steer takes no input. */
  setSteering(isSteering: boolean): void {
    this.isSteering = isSteering;
    this.orbit.enabled = isSteering && !this.isFlying;
    this.fly.enabled = isSteering && this.isFlying;
  }

  /** Flying looks from where the orbit was; orbiting turns around what is in the middle of the view. */
  setFlying(flying: boolean): void {
    if (!flying && this.isFlying) {
      this.lookFrom(this.camera.position, this.look(), Math.max(this.camera.position.distanceTo(this.orbit.target), 1));
    }
    this.isFlying = flying;
    this.setSteering(this.isSteering);
  }

  stats(): Stats | undefined {
    return this.layer?.stats();
  }

  get failure(): string | undefined {
    return this.layer?.failure;
  }

  /** Resolves once everything that the view needs is loaded and drawn. */
  settled(): Promise<void> {
    return new Promise((resolve) => {
      this.waiting.push(resolve);
      this.redraw();
    });
  }

  /** Resolves once the view has rested for a while, and has the finer light that it then gets. */
  rested(): Promise<void> {
    return new Promise((resolve) => {
      this.waitingForRest.push(resolve);
      this.redraw();
    });
  }

  /** Draws a frame, for something in the scene has changed. */
  redraw(): void {
    this.needsFrame = true;
  }

  private moved(): void {
    this.layer?.invalidate();
  }

  private place(target: THREE.Vector3, azimuth: number, down: number, distance: number): void {
    const look = lookOf({ azimuth, down }, SCENE);
    this.lookFrom(target.clone().addScaledVector(look.ahead, -distance), look, distance);
  }

  /**
   * Looks from an eye around what is so far ahead. The orbit keeps the picture's right level in the scene; where it looks along its axis,
   * only that right tells how the picture is turned.
   */
  private lookFrom(eye: THREE.Vector3, { ahead, right }: Look, distance: number): void {
    const polar = THREE.MathUtils.clamp(Math.acos(THREE.MathUtils.clamp(-ahead.z, -1, 1)), LEAST_POLAR_ANGLE, Math.PI - LEAST_POLAR_ANGLE);
    const onLevel = SCENE.up.clone().cross(right).normalize();
    const orbited = onLevel.multiplyScalar(Math.sin(polar)).addScaledVector(SCENE.up, -Math.cos(polar));
    // Someone who looks further up does so until another view is asked for.
    this.orbit.maxPolarAngle = Math.max(this.mostPolarAngle, polar);
    this.camera.position.copy(eye);
    this.orbit.target.copy(eye).addScaledVector(orbited, distance);
    this.orbit.update();
    this.moved();
  }

  private look(): Look {
    const { quaternion } = this.camera;
    return { ahead: new THREE.Vector3(0, 0, -1).applyQuaternion(quaternion), right: new THREE.Vector3(1, 0, 0).applyQuaternion(quaternion) };
  }

  /** Where the eye is, and the directions there. */
  private eyePlace(): { longitude: number; latitude: number; height: number; axes: Axes } | undefined {
    if (this.layer === undefined) return undefined;
    const { frame } = this.layer;
    const { longitude, latitude } = geographic(frame, this.camera.position);
    const axes = frame.axesAt(longitude, latitude);
    const height = this.camera.position.clone().sub(frame.position(longitude, latitude, 0)).dot(axes.up);
    return { longitude, latitude, height, axes };
  }

  private resize(): void {
    if (!fitToCanvas(this.renderer, this.camera, this.canvas)) return;
    this.moved();
    this.redraw();
  }

  private frame(now: number): void {
    const seconds = Math.min((now - this.lastFrame) / 1000, LONGEST_STEP_SECONDS);
    this.lastFrame = now;
    if (this.orbit.enabled) this.orbit.update();
    if (this.fly.update(seconds, this.flySpeed())) this.moved();
    if (!this.needsFrame) return;
    this.needsFrame = false;
    if (this.isSteering) this.stayAbove();
    this.camera.updateMatrixWorld();
    if (this.layer !== undefined) this.layer.uniforms.clearDistance.value = this.focusDistance(this.layer);
    this.layer?.update(this.camera, this.renderer.domElement.height, now);
    this.renderer.render(this.scene, this.camera);
    this.onFrame();
    if (this.layer?.isSettled === true) this.waiting.splice(0).forEach((resolve) => resolve());
    if (this.layer?.isFinished === true) this.waitingForRest.splice(0).forEach((resolve) => resolve());
  }

  /** The controls' target goes to the ground in the middle of the view, which stays as it is. */
  private aim(): void {
    const ground = this.orbit.enabled ? this.groundAt(0, 0) : undefined;
    if (ground !== undefined) this.orbit.target.copy(ground.position);
  }

  private zoomByKey(key: string): void {
    if (!this.orbit.enabled) return;
    if (key === "+" || key === "=") this.orbit.dollyIn(KEY_ZOOM);
    if (key === "-") this.orbit.dollyOut(KEY_ZOOM);
  }

  /** Lifts the camera, and what it looks at, out of the ground. */
  private stayAbove(): void {
    const above = this.metresAboveGround();
    if (this.layer === undefined || above === undefined || above >= CLEARANCE) return;
    const up = this.up(this.layer);
    this.camera.position.addScaledVector(up, CLEARANCE - above);
    this.orbit.target.addScaledVector(up, CLEARANCE - above);
    this.moved();
  }

  private up(layer: TerrainLayer): THREE.Vector3 {
    return this.camera.position.clone().sub(layer.frame.earthCentre).normalize();
  }

  /** How far away what is looked at is. */
  private focusDistance(layer: TerrainLayer): number {
    const { position } = this.camera;
    return this.groundAt(0, 0)?.distance ?? Math.max(layer.box.distanceToPoint(position), position.z - layer.box.min.z);
  }

  /** Half the height over the lowest ground every second: calm near the ground, quick high above it. */
  private flySpeed(): number {
    const lowest = this.layer?.box.min.z ?? 0;
    return Math.max(20, (this.camera.position.z - lowest) / 2);
  }
}

function skyMesh(): THREE.Mesh {
  const geometry = new THREE.BufferGeometry().setIndex([0, 1, 2]);
  geometry.boundingSphere = new THREE.Sphere();
  const material = new THREE.ShaderMaterial({
    vertexShader: SKY_VERTEX,
    fragmentShader: SKY_FRAGMENT,
    depthTest: false,
    depthWrite: false,
  });
  const sky = new THREE.Mesh(geometry, material);
  sky.frustumCulled = false;
  sky.renderOrder = -1;
  return sky;
}
