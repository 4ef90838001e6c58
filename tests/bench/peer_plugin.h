#pragma once

/// What a shared library implements so that `side_by_side --peer LIBRARY` lets its detector take part: for detectors
/// that no distribution packages, or whose licence does not go with this project's. Plain C, so that any compiler will
/// do.

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The version of this file, for ChequerPeer::abi.
#define CHEQUER_PEER_ABI 1

/// A marker that was found.
struct ChequerPeerMarker {
  int64_t id;
  /// (x, y) of the black square's corners, in pixels, the centre of the top-left pixel at (0, 0); in the order of the
  /// upright marker: top left, top right, bottom right, bottom left.
  double corners_px[4][2];
};

/// A detector. It works with one thread, at its quickest settings that still find its markers.
struct ChequerPeer {
  int abi;           ///< CHEQUER_PEER_ABI
  const char* name;  ///< its line in the table
  /// The folder of the frames that it reads: "tag36h11", "aruco4", or a name for the frames that `draw` is for.
  const char* pattern;

  /// Writes the cells of a marker, row by row from the top left: 0 black, anything else white. NULL where the pattern
  /// is one that side_by_side draws anyway; then the next three are not looked at.
  void (*draw)(int id, uint8_t* cells);
  int cells;  ///< of the whole board's side, its white rim included: 3 to 64
  int rim;    ///< cells of the white rim on each side; the marker's side is counted without
  int ids;    ///< ids run from 0 to ids - 1

  /// Makes a detector for frames of a size, or returns NULL.
  void* (*create)(int width, int height);
  void (*destroy)(void* detector);
  /// Finds the markers of a grey frame, writes at most `capacity` of them and returns how many it wrote. This is what
  /// is timed, with the conversion of the colour frame to grey.
  int (*detect)(void* detector, const uint8_t* grey, size_t stride_bytes, struct ChequerPeerMarker* markers,
                int capacity);
};

/// The detector of this library. What it points to lasts as long as the library is loaded.
__attribute__((visibility("default"))) const struct ChequerPeer* chequer_peer(void);

#ifdef __cplusplus
}
#endif
