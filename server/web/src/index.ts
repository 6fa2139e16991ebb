// The package: archives of terrain, drawn on a canvas or in a scene of three.js, or only decoded and selected from.

export { openArchive } from "./archive_tileset.ts";
export { listTilesets } from "./server_tilesets.ts";
export { checkedMetadata, datumOf, heightsAbove, isLocal } from "./tileset.ts";
export type { Metadata, Tileset, TileSource, Zoom } from "./tileset.ts";

export { Viewer } from "./viewer.ts";
export type { Pose } from "./pose.ts";
export { DEFAULT_SETTINGS, TerrainLayer, type Stats, type TerrainSettings } from "./terrain_layer.ts";
export type { Imagery } from "./imagery.ts";
export { STYLES } from "./shaders.ts";
export { Frame, tileBounds, type Bounds } from "./frame.ts";
export { geographic, type GroundPoint } from "./ground.ts";

export { DecodeError, HeaderCut } from "./decode_error.ts";
export { loadDecoder } from "./decoder.ts";
export { decodeTile, decodeTilePrefix, TileDecoder } from "./spt.ts";
export { interiorLevels, type Level as TileLevel, type Surface, type Tile } from "./tile.ts";
export { COARSEST_DETAIL, drawnPrefix, finestDetail, placesOf, triangleCount, type Detail } from "./partition.ts";

export { childrenOf, keyOf, MAX_ZOOM, neighboursOf, parentOf, type Address } from "./address.ts";
export { select, type Choice, type Demand, type Hierarchy, type Level, type Selection, type TileRequest } from "./select.ts";
export { screenSpaceError, Sight, type Camera, type Ellipsoid, type HalfSpace } from "./sight.ts";
export { boxAround, distanceTo, grown, reachOf, solidAngle, type OrientedBox } from "./oriented_box.ts";
