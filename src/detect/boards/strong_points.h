#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "detect/boards/place.h"
#include "detect/common/light.h"
#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"

namespace chequer {

/// What the pixels around points show of yellow and blue.
class InkSigns {
 public:
  /// The pixels around a point that show its cells' colours. The first four tell most of clutter.
  static constexpr std::size_t kAround = 8, kFirstAround = 4;
  /// The farthest of them, px: the largest of the offsets.
  static constexpr float kAroundPx = 4;

  /// Looks at the pixels around a point from `first` to before `past`.
  void Add(const LightReader& reader, const Eigen::Vector2f& at, std::size_t first = 0, std::size_t past = kAround);
  /// @param least by how much yellow returns less blue than red and green, and blue more, together, as a share of the
  /// light.
  bool AreThere(float least = kLeastInk) const { return yellow_ + blue_ > least * light_; }

 private:
  /// White and ink make 0.6 to 1.5 even where cells are 3 px high, photographs mostly less than 0.3.
  static constexpr float kLeastInk = 0.55f;

  float yellow_ = 0, blue_ = 0, light_ = 0;
};

/// Whether a point stands among yellow and blue. Clutter around a board, which would hide how the board's own points
/// spread, hardly ever does.
bool ShowsInks(const LightReader& reader, const Eigen::Vector2f& at);

/// The points of an image with strong contrast that no board explains, and the places where they lie closest.
class StrongPoints {
 public:
  /// Fewer points are no place: a board that can be read leaves more behind (a guess).
  static constexpr int kFewest = 6;

  /// Takes over the points outside of `boards`. @param least contrast that counts.
  void Start(int width, int height, std::span<const StrongPoint> points, float least, std::span<const PixelBox> boards);
  /// Where there are many points, leaves out the weakest of too many, and those that do not stand among inks.
  void ThinOut(const LightReader& reader, WorkMeter& work);
  bool empty() const { return points_.empty(); }
  /// Where points lie closest, from their fullest tile on. Too few of them are forgotten at once. Nothing if there are
  /// no points.
  std::optional<Place> FindPlace(WorkMeter& work);
  /// Whether a place is larger than a board. Its fullest tile is forgotten.
  static bool IsTooLarge(const Place& place);
  /// Some points of the last place.
  std::span<const Eigen::Vector2f> members() const { return members_; }
  /// Leaves out the points of a place.
  void Forget(const Place& place, WorkMeter& work);
  /// The most instructions that it takes from here on to find `places` places.
  std::uint64_t MostInstructions(int places) const;

 private:
  /// Leaves out the points that do not stand among yellow and blue.
  void KeepInks(const LightReader& reader, WorkMeter& work);
  /// Columns and rows of the tiles that count points.
  int cols() const;
  int rows() const;
  std::size_t TileOf(float x, float y) const;

  int width_ = 0, height_ = 0;
  std::vector<StrongPoint> points_;
  bool thinned_out_ = false;
  std::vector<Eigen::Vector2f> members_;
  std::vector<std::uint16_t> in_tile_;
  std::vector<std::uint8_t> explained_;  ///< tiles with boards
};

}  // namespace chequer
