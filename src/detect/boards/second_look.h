#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "chequer/detect_trace.h"
#include "detect/boards/motion_blur_view.h"
#include "detect/boards/place.h"
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
  /// The last look showed a board: it does not count among those that are given to an image.
  void CountBoard();

  /// The most units that Next() takes from here on until it has found nothing kMostLooks times, boards in its views
  /// included.
  std::uint64_t MostUnits() const;
  /// The same of one call alone.
  static constexpr std::uint64_t kMostUnitsOfLook = 2'000;
  /// What the image took so far, but for boards.
  const WorkMeter& work() const { return image_->work; }

  /// Of the last look, positions in the image.
  const std::vector<Corner>& corners() const { return shown_->corners; }
  const Grids& grids() const { return shown_->grids; }
  const GridLinker& linker() const { return shown_->linker; }
  /// Whether the place seems motion-blurred, and was sharpened.
  bool motion_blurred() const { return shown_->motion_blurred; }

 private:
  /// Where there are many points, leaves out the weakest of too many, and those that do not stand among inks.
  void ThinOut(const LightReader& reader);
  /// Leaves out the points that do not stand among yellow and blue.
  void KeepInks(const LightReader& reader);
  /// Where points lie closest, from their fullest tile on; without a count if that leads nowhere. Too few of them are
  /// forgotten at once.
  std::optional<Place> FindPlace();
  /// kViewed where the first look may have missed a board, else why not.
  static PlaceFate Judge(const Place& place);
  /// Leaves out the points of a place.
  void Forget(const Place& place);
  void LookAt(const Pyramid& pyramid, Place place);
  void View(const Pyramid& pyramid, const Place& place);
  /// The place around some points that its pixels' change tells, if the first look may have missed a board there and
  /// it stands among inks.
  std::optional<Place> FindChange(const Pyramid& pyramid, const LightReader& reader, const Place& points);
  /// Views that place; false if there is none.
  bool LookByChange(const Pyramid& pyramid, const LightReader& reader, const Place& points);
  /// Views a place with what is blurred along its narrow side raised again.
  void ViewSharpened(const Pyramid& pyramid, const Place& place);
  /// Whether so much is linked that it will be a board if it is one.
  bool ShowsBoard() const;
  /// Views a place that seems motion-blurred, sharpened; false if it does not.
  bool LookThroughMotionBlur(const Pyramid& pyramid, const Place& place);
  /// Finds and links the corners of the view of a place.
  void ShowCorners(const Place& place, const Eigen::Matrix2f& image_by_view, float scale);
  void NotePlace(const Place& place, PlaceFate fate);
  void NoteView(const Place& place, const Eigen::Matrix2f& image_by_view);
  /// What would have been viewed if an image's looks had not been used up.
  void NoteTheRest();

  /// What is known of an image.
  struct Search {
    int width = 0, height = 0;
    WorkMeter work;
    int looks = 0, places = 0, sparse = 0;  ///< that have shown no board
    std::vector<StrongPoint> points;
    bool thinned_out = false;
    std::vector<Eigen::Vector2f> members;  ///< some points of the last place
    std::optional<Place> unclear;          ///< was viewed, but shows little
    std::vector<std::uint16_t> in_tile;
    std::vector<std::uint8_t> explained;  ///< tiles with boards
    std::vector<TracePlace>* trace = nullptr;
  };
  /// What one view shows.
  struct Shown {
    DetectionPlane view;
    std::vector<std::uint8_t> smoothed;
    MotionBlurScratch motion_blur;
    PeakScan scan;
    std::vector<RefusedPeak> refused;
    GridLinker linker;
    std::vector<Corner> corners;
    Grids grids;
    bool motion_blurred = false;
    std::vector<StrongPoint> seen;  ///< what looks like corners
  };

  Scratch<Search> image_;
  Scratch<Shown> shown_;
};

}  // namespace chequer
