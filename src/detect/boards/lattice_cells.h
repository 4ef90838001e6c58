#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "detect/boards/lattice.h"
#include "detect/common/cell_unmixer.h"
#include "detect/common/light.h"
#include "detect/common/neighbours.h"
#include "detect/common/work_meter.h"

namespace chequer {

/// A cell of a lattice.
struct CellSample {
  Eigen::Vector3f light = Eigen::Vector3f::Zero();
  float blue_share = 0;  ///< of the light
  bool inside = false;   ///< the image, at a place that is known
  bool sampled = false;
};

/// What the cells around a window's corners show, row by row in the lattice's orientation.
struct Footprint {
  Lattice::Window window;
  std::vector<CellSample> samples;
  std::vector<std::uint8_t> visible;  ///< lighter or darker than its neighbours, as it should be
  int showing = 0;                    ///< of them, all
};

/// The cells of a lattice, sampled when they are asked for. Cell (x, y) has corner (x, y) at its top left, and is light
/// where x + y is even.
class LatticeCells {
 public:
  /// Both must outlive the cells' use.
  void Start(const Lattice& lattice, const LightReader& reader);
  /// Of a grid that fits into a board, all windows have this homography; else cells are placed by their neighbours.
  void PlaceOnPlane(const Eigen::Matrix3d& image_from_lattice);
  bool on_plane() const { return on_plane_; }
  const Eigen::Matrix3d& image_from_lattice() const { return image_from_lattice_; }
  /// Takes a window's own homography.
  void Refine(const Eigen::Matrix3d& image_from_lattice) { image_from_lattice_ = image_from_lattice; }
  /// Samples a window's cells anew where that homography has them: neighbours leave the cells at the corners of a board
  /// out, and place others roughly.
  void Resample(const Lattice::Window& window);

  /// Whether windows in single cells would hold other cells' chroma.
  bool mixed() const { return mixed_; }
  /// Else, whether they may hold so much of it that inks look alike.
  bool small() const { return small_; }
  /// Solves for the light of all of them at once. They are neither mixed nor small from then on.
  void Unmix(CellUnmixer& unmixer);

  const CellSample& At(int x, int y) {
    CellSample& sample = cells_[Slot(x, y)];
    if (!sample.sampled) {
      work_.Add(WorkStep::kCellSample);
      Sample(x, y, sample);
    }
    return sample;
  }
  /// As it was sampled, if it was.
  const CellSample& Known(int x, int y) const { return cells_[Slot(x, y)]; }
  void Look(const Lattice::Window& window, Footprint& footprint);

  /// Where a cell lies in the image.
  struct Place {
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
    double side = 0;  ///< the shorter one, pixels
  };
  std::optional<Place> PlaceOf(int x, int y) const {
    return on_plane_ ? PlaceByHomography(x, y) : PlaceByNeighbours(x, y);
  }
  const WorkMeter& work() const { return work_; }

 private:
  std::size_t Slot(int x, int y) const {
    return static_cast<std::size_t>((y - window_.y) * window_.cols + x - window_.x);
  }
  Place PlaceByHomography(int x, int y) const;
  std::optional<Place> PlaceByNeighbours(int x, int y) const;
  void Sample(int x, int y, CellSample& sample) const;

  const Lattice* lattice_ = nullptr;
  const LightReader* reader_ = nullptr;
  Eigen::Matrix3d image_from_lattice_ = Eigen::Matrix3d::Identity();
  bool on_plane_ = false, mixed_ = false, small_ = false;
  Lattice::Window window_;  ///< of cells
  std::vector<CellSample> cells_;
  WorkMeter work_;
  // What single steps need.
  std::vector<Eigen::Vector3f> unmixed_;
  NeighbourLead neighbours_;
  std::vector<std::uint8_t> inside_;
  std::vector<float> value_, sorted_;
};

}  // namespace chequer
