// Motion: the light is the mean over the way of a point during the exposure. A few points of it are looked at, each
// with the blur that the way between two of them adds. motion_blur.h finds where the fit of long ways starts.
#ifndef CHEQUER_DETECT_TERM_MOTION
#define CHEQUER_DETECT_TERM_MOTION

#include "detect/fit/term.h"

namespace chequer {

struct MotionTerm {
  static constexpr int kColumns = 2;   ///< pixels along x and y
  enum Lane { kWayX, kWayY, kLanes };  ///< of a point during the exposure, cells
  struct Input {
    int taps = 1;  ///< points of the way that are looked at
  };

  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();  ///< the way of a point during the exposure, image pixels

  bool on() const { return !motion_px.isZero(); }

  void SetInput(double blur_px, Input& input) const {
    // The way between two points, in blurs of the lens: a box as wide is a Gaussian to 1 %. Fewer points would not show
    // how the light changes with the way.
    constexpr double kTapBlurs = 2.5;
    constexpr int kFewestTaps = 3, kMostTaps = 12;
    input.taps =
        std::clamp(static_cast<int>(std::ceil(motion_px.norm() / (kTapBlurs * blur_px))), kFewestTaps, kMostTaps);
  }

  template <class Set>
  void SetLanes(const Input& input, TermCorner& corner, const Set& set) const {
    const Eigen::Vector2d way = corner.by_pixel * motion_px, tap = way / input.taps;
    corner.blur += tap * tap.transpose() / 12;
    set(kWayX, way.x());
    set(kWayY, way.y());
  }

  double Move(const TermStep& step) {
    // Longer steps lead elsewhere; px, and as a share of the way. Then, px, what no longer counts.
    constexpr double kMostPx = 1, kMostShare = 0.25, kStillPx = 0.04;
    Eigen::Vector2d more(step.of[0], step.of[1]);
    const double most = std::max(kMostPx, kMostShare * motion_px.norm());
    if (more.norm() > most) more *= most / more.norm();
    motion_px += more;
    return more.norm() / kStillPx;
  }

  /// Starts from the step of UnevenBlurTerm, and takes the way's part out of the blur.
  void Start(const Eigen::Vector2d& uneven, double& blur_px) {
    // The longest way that the first step may find, blurs (a way of 5 has as much variance again), and what it leaves
    // of the blur's variance at least.
    constexpr double kMostFirst = 4.5, kLeastOfBlur = 0.1;
    // A way of length l has the variance l² / 12 along it, and the uneven part is half of that.
    const double length = std::min(std::sqrt(24 * uneven.norm()), kMostFirst * blur_px),
                 angle = std::atan2(uneven.y(), uneven.x()) / 2;
    motion_px = length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    // Across the way, the blur stays: the fit's lies between.
    blur_px = std::sqrt(std::max(blur_px * blur_px - length * length / 24, kLeastOfBlur * blur_px * blur_px));
  }

  /// Starts from how another board of the image moved, if this one seems to have moved like it. Whether it does.
  bool StartLike(Eigen::Vector2d other_px) {
    // It did if, of what is found first, so much at most goes another way, and the way is as long within these factors
    // (it is found too short).
    constexpr double kAcross = 0.35, kLeast = 0.4, kMost = 1.4;
    if (other_px.dot(motion_px) < 0) other_px = -other_px;  // there and back are the same
    if (other_px.isZero()) return false;
    const Eigen::Vector2d along = other_px.normalized();
    const double share = along.dot(motion_px) / other_px.norm();
    const Eigen::Vector2d across = motion_px - along.dot(motion_px) * along;
    if (share < kLeast || share > kMost || across.norm() > kAcross * motion_px.norm()) return false;
    motion_px = other_px;
    return true;
  }
};

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERM_MOTION

#ifdef CHEQUER_TERMS_ON_LANES

template <>
struct OnLanes<MotionTerm> {
  template <class AddPoint>
  static HWY_INLINE void AddPoints(const MotionTerm::Input& input, const LaneModel& m, V x, V y, Picture& p,
                                   const AddPoint& add_point) {
    const float taps = static_cast<float>(input.taps);
    for (int tap = 0; tap < input.taps; ++tap) {
      const V part = Splat((static_cast<float>(tap) + 0.5f) / taps - 0.5f);
      add_point(hn::MulAdd(part, m.of<MotionTerm>(MotionTerm::kWayX), x),
                hn::MulAdd(part, m.of<MotionTerm>(MotionTerm::kWayY), y), part);
    }
    Scale(Splat(1 / taps), p);
  }

  static HWY_INLINE void Derive(const LaneModel& m, const Picture& p, V* by) {
    const auto of = [&](ModelLanes::Parameter x_by, ModelLanes::Parameter y_by)
                        HWY_ATTR { return hn::MulAdd(m.of(x_by), p.way_x, hn::Mul(m.of(y_by), p.way_y)); };
    by[0] = of(ModelLanes::kByPixelXx, ModelLanes::kByPixelYx);
    by[1] = of(ModelLanes::kByPixelXy, ModelLanes::kByPixelYy);
  }
};

#endif  // CHEQUER_TERMS_ON_LANES
