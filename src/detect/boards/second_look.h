#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "chequer/detect_trace.h"
#include "detect/boards/place.h"
#include "detect/boards/place_view.h"
#include "detect/boards/strong_points.h"
#include "detect/common/light.h"
#include "detect/common/scratch.h"
#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"
#include "detect/grids/grids.h"

namespace chequer {

/// Looks once more, and closer, at places that are full of strong contrasts among yellow and blue but gave no board:
/// seen at a steep slant, the cells of a board are so narrow, or meet at such sharp angles, that the ring of the first
/// look does not fit. The points' own spread tells how the place must be stretched and squeezed for a board to look as
/// if seen from the front, its cells some 8 px wide; of that view, corners are found and linked as ever. A place that
/// spreads as in plain view but shows stripes is a board that moved while the image was exposed, by more than a cell:
/// it is viewed with the stripes made even. Where points are few, lie along a line, or show no board, what changes from
/// pixel to pixel around them tells the place instead, and where the lens blurs the narrow cells, the view is sharpened
/// along them. Costs nothing where no place stands out. Each place is viewed by its points and by its pixels, until
/// kMostLooks places have shown no board: a knocked camera blurs every board of an image, clutter has none.
class SecondLook {
 public:
  /// (A guess.)
  static constexpr int kMostLooks = 2;

  /// Takes over the points of an image; those in `boards` are explained already, and where there are many, only those
  /// count that stand among the inks of a marker. @param least contrast that counts. @param trace gets every place that
  /// is considered, for finding out why there is no board; may be null, which costs a comparison a place.
  void Start(const LightReader& reader, std::span<const StrongPoint> points, float least,
             std::span<const PixelBox> boards, std::vector<TracePlace>* trace = nullptr);
  /// Whether there may be a place that is not viewed yet.
  bool MayGoOn() const;
  /// Fills corners() and grids() with what the next place shows, or the last one once more. False once there is none
  /// left.
  bool Next(const Pyramid& pyramid, const LightReader& reader);
  /// The last look showed a board. It does not count as one of the image's looks.
  void CountBoard();

  /// The most units that Next() takes from here on until it has found nothing kMostLooks times, boards in its views
  /// included.
  std::uint64_t MostUnits() const;
  /// The same of one call alone (a guess).
  static constexpr std::uint64_t kMostUnitsOfLook = 2'000;
  /// What the image took so far, but for boards.
  const WorkMeter& work() const { return image_->work; }

  /// Of the last look, positions in the image.
  const std::vector<Corner>& corners() const { return view_.corners(); }
  const Grids& grids() const { return view_.grids(); }
  const GridLinker& linker() const { return view_.linker(); }
  /// Whether the place seems motion-blurred, and was sharpened.
  bool motion_blurred() const { return view_.motion_blurred(); }

 private:
  /// Where points lie closest; without a count if that leads nowhere.
  std::optional<Place> FindPlace();
  /// kViewed where the first look may have missed a board, else why not.
  static PlaceFate Judge(const Place& place);
  /// Views a place by its points, or else by its pixels. Whether it was viewed.
  bool LookAt(const Pyramid& pyramid, const LightReader& reader, const Place& place);
  /// The place around some points that its pixels' change tells, if the first look may have missed a board there and
  /// it stands among inks.
  std::optional<Place> FindChange(const Pyramid& pyramid, const LightReader& reader, const Place& points);
  /// Views that place; false if there is none.
  bool LookByChange(const Pyramid& pyramid, const LightReader& reader, const Place& points);
  // What follows does nothing where nobody asks for a trace.
  void NotePlace(const Place& place, PlaceFate fate);
  /// What would have been viewed if an image's looks had not been used up.
  void NoteTheRest();
  /// Of the place that was noted last.
  TracePlace* noted() { return image_->trace ? &image_->trace->back() : nullptr; }

  /// What is known of an image.
  struct Search {
    WorkMeter work;
    int looks = 0, places = 0, sparse = 0;  ///< that have shown no board
    StrongPoints points;
    std::optional<Place> unclear;  ///< was viewed, but shows little
    std::vector<TracePlace>* trace = nullptr;
  };

  Scratch<Search> image_;
  PlaceView view_;
};

}  // namespace chequer
