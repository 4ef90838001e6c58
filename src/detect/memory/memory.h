#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "chequer/detector_memory.h"
#include "chequer/marker.h"
#include "detect/common/fixed_vector.h"
#include "detect/common/light.h"
#include "detect/common/search_regions.h"
#include "detect/common/visibility.h"
#include "detect/fit/fit.h"
#include "detect/memory/board_motion.h"

namespace chequer {

/// Of a frame, on any clock that runs on evenly.
using FrameTime = std::chrono::nanoseconds;

inline double Seconds(FrameTime time) { return std::chrono::duration<double>(time).count(); }

/// A board that was read in the last frame.
struct RememberedBoard {
  int family = 0;  ///< index into DetectorOptions::families
  std::uint64_t id = 0;
  std::uint64_t kernel = 0;  ///< that the id was read from
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  BoardMotion motion;
  PixelBox box;     ///< where it lies in the image, roughly
  float scale = 1;  ///< as of AnchoredBoard: with which it was found
  /// By cell: by how much it stood out from its neighbours when nothing lay over the board, as a share of the contrast
  /// (ExpectedBoards); empty where that is not known.
  FixedVector<float, kMaxCells> leads;
  Visibility visibility;  ///< what showed of it in the last frame
  BlurShape blur_shape;
  LightLevels light_levels;
  double blur_px = 0;  ///< with all of the motion that has no term of its own
  /// How far its fit took it from where it was expected, square of standard deviations.
  double moved_square = std::numeric_limits<double>::infinity();
  double contrast = 0;    ///< as sampled where it was (SampledContrast)
  FrameTime decided{};    ///< when its identity was last read
  bool may_carry = true;  ///< it was fitted in every frame since then
  LearntBoard learnt;     ///< empty without DetectorOptions::learn_levels

  /// A prediction adds its own errors to the pose's, so moved_square is 40 where a board goes on as expected, and 70
  /// for one in ten (measured). A fit that begins less than 11 deviations off ends with the first step by all pixels.
  static constexpr double kNearSquare = 80;
  bool lay_near() const { return moved_square < kNearSquare; }
  bool is_followed() const { return motion.before_s > 0; }
  /// Where it will lie `ahead_s` later.
  Eigen::Matrix3d Ahead(double ahead_s) const { return motion.Predict(plane_from_board, ahead_s); }
  /// It lies there by now, `passed_s` after it was as `last` says; null: nothing is known of that.
  /// @param last_place where it would have been then, had the camera already stood as it does now.
  void Move(const RememberedBoard* last, const Eigen::Matrix3d& last_place, const Eigen::Matrix3d& now,
            double passed_s);
};

/// A place that is searched in the next frame, whoever's turn it is: a board was lost there, or could not be read, or
/// something was left undone.
struct OpenPlace {
  PixelBox box;
  FrameTime since{};
};

/// What DetectorMemory holds.
struct MemoryState {
  bool filled = false;
  FrameTime captured{};
  /// The shortest time between two frames so far; 0: not known.
  double interval_s = 0;
  int width = 0, height = 0;
  /// Frames since the last one that was searched as a whole because nothing was known of it.
  int since_start = 0;
  /// By band of the image (SearchRegions): frames since it was searched.
  std::array<int, SearchRegions::kMostBands> since_search{};
  std::vector<RememberedBoard> boards;
  std::vector<OpenPlace> open;
  /// Of the boards of the last image that could tell, cells; 0: none. It is the printer's, so the next ones have it
  /// too: a fit that knows it takes half as much as one that finds it.
  double dot_gain = 0;
  /// Of the boards of the last frames.
  EdgeTally edge_tally;
  /// Of the last image whose traits were told in full, where they are simple: that costs a first board as much again as
  /// another board, and would say the same.
  std::optional<ImageTraits> simple_traits;
  int traits_age = 0;  ///< frames since then

  /// What a frame taught.
  struct Lesson {
    FrameTime now{};
    int frames_on = 1;                                       ///< since the last frame
    std::array<bool, SearchRegions::kMostBands> searched{};  ///< which bands
    std::span<const PixelBox> open;                          ///< see OpenPlace
    std::span<const PixelBox> cut;  ///< may be parts of something: searched in the next frame alone
  };

  /// Keeps the vectors' memory.
  void Clear();
  /// Forgets everything where this frame does not continue the last one: after a gap, in another size, or with a time
  /// that does not lie ahead. Returns by how many frames it comes after the last one, at least 1.
  int Continue(FrameTime now, int frame_width, int frame_height);
  /// Whether that one of `bands` bands has its turn in the next frame, `frames_on` after the last one. Each has one in
  /// `every` frames. Those between are other workers' who do not tell in time; what they may have dropped is searched
  /// after twice as many.
  bool HasTurn(int band, int bands, int every, int frames_on) const;
  /// Those of a frame, `frames_on` after the last one; nothing where its first board is to tell them in full.
  std::optional<ImageTraits> TraitsAhead(int frames_on) const;
  /// Becomes what is known after a frame. @param read its boards; swapped with those before.
  void Learn(const Lesson& lesson, std::vector<RememberedBoard>& read);
};

}  // namespace chequer
