/* Heights of terrain at places: docs/heights.md. Made by cbindgen from heights/src/capi.rs. */

#ifndef TERRAIN_HEIGHTS_H
#define TERRAIN_HEIGHTS_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

// What there is at a place.
typedef enum TerrainStatus {
  // Ground: the answer is set.
  TERRAIN_STATUS_MEASURED = 0,
  // Within the archive's bounds, but its source has no samples there.
  TERRAIN_STATUS_VOID = 1,
  // Out of the archive's bounds, or no place on the Earth.
  TERRAIN_STATUS_OUTSIDE = 2,
  // The archive cannot be read there.
  TERRAIN_STATUS_FAILED = 3,
  // Ground, but not measured: a void of the source was filled there. The answer is set; its error is not a number.
  TERRAIN_STATUS_FILLED = 4,
} TerrainStatus;

// An open archive.
typedef struct TerrainHeights TerrainHeights;

// The ground at a place.
typedef struct TerrainGround {
  // Metres above what `terrain_heights_above` says; in a frame, metres up of its origin.
  double height;
  // Metres along the vertical that the source may be from that, certified; in a frame, along its up.
  double error;
  // Unit normal of the surface: east, north, up, of the place or of the frame.
  double normal[3];
} TerrainGround;

// A local frame: metres east, north and up of its origin, flat in space, so that the Earth curves away below. All in Earth-centred
// metres. `terrain_frame` makes it; a program may as well set it itself, the axes being unit vectors at right angles.
typedef struct TerrainFrame {
  // Where its origin is.
  double origin[3];
  // Its axis to the east.
  double east[3];
  // Its axis to the north.
  double north[3];
  // Its axis upwards.
  double up[3];
} TerrainFrame;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Opens the archive at `path`. Decoded surfaces take `cache_bytes` of memory at most, besides those that are being asked. Gives NULL
// where the archive cannot be read; `message`, if it is not NULL, then has the reason, cut to `message_size` bytes with the zero
// at its end.
//
// # Safety
// `path` is a text with a zero at its end; `message` has `message_size` bytes, or is NULL.
struct TerrainHeights *terrain_heights_open(const char *path,
                                            uint64_t cache_bytes,
                                            char *message,
                                            size_t message_size);

// Closes what `terrain_heights_open` gave; NULL is nothing. Nobody may be asking it, then or later.
//
// # Safety
// `heights` is what `terrain_heights_open` gave, and was not closed.
void terrain_heights_close(struct TerrainHeights *heights);

// The archive's finest zoom.
//
// # Safety
// `heights` is open.
uint8_t terrain_heights_finest_zoom(const struct TerrainHeights *heights);

// What heights are above, in words; valid until `heights` is closed.
//
// # Safety
// `heights` is open.
const char *terrain_heights_above(const struct TerrainHeights *heights);

// The ground at degrees of longitude and latitude, on the surface of `zoom`; 255 is the finest. Any number of threads may ask at a
// time, and all get the same. `ground` is set where there is any. A tile is read and decoded when it is asked first, and when it was
// not for long; all else takes less than a microsecond or so and allocates nothing.
//
// # Safety
// `heights` is open; `ground` points at one.
enum TerrainStatus terrain_heights_at(const struct TerrainHeights *heights,
                                      double longitude,
                                      double latitude,
                                      uint8_t zoom,
                                      struct TerrainGround *ground);

// Makes the local frame of a place: degrees of longitude and latitude, and metres above the ellipsoid. Gives whether there is such a
// place.
//
// # Safety
// `frame` points at one.
bool terrain_frame(double longitude,
                   double latitude,
                   double height,
                   struct TerrainFrame *frame);

// The ground at metres east and north in a local frame, where its vertical meets the surface of `zoom`, in all else as
// `terrain_heights_at`: the height of `ground` is metres up in the frame, its error is along the frame's up, and its normal is in
// the frame's axes. Heights of the archive are taken as above the ellipsoid. The error is infinite where the ground is so steep that a
// vertical so far from its own may miss it; what is more than 45° from the origin is outside. It takes some microseconds.
//
// # Safety
// `heights` is open; `frame` points at one, and so does `ground`.
enum TerrainStatus terrain_heights_in_frame(const struct TerrainHeights *heights,
                                            const struct TerrainFrame *frame,
                                            double east,
                                            double north,
                                            uint8_t zoom,
                                            struct TerrainGround *ground);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TERRAIN_HEIGHTS_H */
