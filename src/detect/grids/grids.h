#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"
#include "detect/grids/corner_search.h"
#include "detect/grids/edge_probes.h"

namespace chequer {

/// A corner's place in the lattice of its grid: x towards the right, y a quarter turn on (downwards if x is
/// rightwards), by the image's own handedness.
struct LatticeCorner {
  int x = 0;
  int y = 0;
  int corner = 0;  ///< index into the corners
};

/// Corners that hang together by links that are sides of closed squares of four corners. The lattice's origin and
/// direction are arbitrary, except that the cell between (0, 0) and (1, 1) is light.
struct Grid {
  int first = 0;  ///< its corners are Grids::corners[first, first + count)
  int count = 0;
  int min_x = 0, max_x = 0, min_y = 0, max_y = 0;
};

/// The grids of an image.
struct Grids {
  std::vector<Grid> grids;
  std::vector<LatticeCorner> corners;

  std::span<const LatticeCorner> Of(const Grid& grid) const {
    return std::span(corners).subspan(static_cast<std::size_t>(grid.first), static_cast<std::size_t>(grid.count));
  }
};

/// Links neighbouring corners to grids.
class GridLinker {
 public:
  /// The fewest corners of a grid that is kept: fewer do not determine a homography with something to spare.
  static constexpr int kFewest = 6;
  /// Sorts `corners`, then fills `out`. Guarantees that every link runs along an edge that the image shows, of opposite
  /// kinds at its ends, is mutual, no longer than CornerSearch::kLongest, and a side of a closed square; that the steps
  /// of a grid change by less than 20 % + 1 px from one to the next. It may join boards printed edge to edge, and lose
  /// single corners: the next stage knows. 0.15 µs a corner, linear in them. `plane` (with its offset
  /// to the image) tells whether the edge between two corners is there.
  void Link(const DetectionPlane& plane, std::vector<Corner>& corners, Grids& out);
  /// Of the corners as last linked.
  const CornerSearch& search() const { return search_; }
  /// What it took to link them.
  WorkMeter work() const;

  /// What leaves a corner.
  struct Links : NearestCorners {
    std::uint8_t squares = 0;  ///< bit k: the link of ray k is a side of a closed square
  };
  /// By corner, as last linked; for traces.
  std::span<const Links> links() const { return links_; }

 private:
  void KeepMutual();
  void KeepEdges(const DetectionPlane& detection, const std::vector<Corner>& corners);
  void KeepSquares(const std::vector<Corner>& corners);
  bool StartAt(int seed, const std::vector<Corner>& corners);
  void Walk(int seed, const std::vector<Corner>& corners, Grids& out);

  CornerSearch search_;
  std::vector<Links> links_;
  EdgeProbes probes_;
  /// Whose links the probes are.
  struct Probed {
    int corner = 0, ray = 0;
  };
  std::vector<Probed> probed_;
  std::vector<std::uint8_t> state_;
  std::vector<int> turn_;
  std::vector<LatticeCorner> queue_;
  /// Of each corner of the queue: the steps to its neighbours along x and y, image pixels.
  struct Basis {
    Eigen::Vector2f x = Eigen::Vector2f::Zero();
    Eigen::Vector2f y = Eigen::Vector2f::Zero();
  };
  std::vector<Basis> basis_;
};

}  // namespace chequer
