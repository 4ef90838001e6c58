// Motion: the light is the mean over the way of a point during the exposure, on which the board also turns a little. A
// few points of it are looked at, each with the blur that the way between two of them adds. motion_blur.h finds where
// the fit of long ways starts.
#ifndef CHEQUER_DETECT_TERM_MOTION
#define CHEQUER_DETECT_TERM_MOTION

#include "detect/fit/term.h"

namespace chequer {

struct MotionTerm {
  static constexpr int kColumns = 3;  ///< of its middle, pixels along x and y; rad
  /// Of a point during the exposure, cells; that of the board's middle, turned by a right angle: by so much, times the
  /// turn and the time squared, the way is bent on a board that turns.
  enum Lane { kWayX, kWayY, kAcrossX, kAcrossY, kLanes };
  struct Input {
    int taps = 1;  ///< points of the way that are looked at
    float turn = 0;
  };

  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();  ///< the way of its middle during the exposure, image pixels
  double turn = 0;                                      ///< by which it turned meanwhile, on the board, rad

  bool on() const { return !motion_px.isZero(); }

  void SetInput(double blur_px, bool roughly, Input& input) const {
    // The way between two points, in blurs of the lens: by all pixels, and by some. A box as wide is a Gaussian so that
    // light is off by .1 to .26 % of an edge's contrast at most, and by .3 to .8 % (calculated for 8 to 3 points).
    // Fewer points would not show how the light changes with the way.
    constexpr double kTapBlurs = 3, kRoughTapBlurs = 4.5;
    constexpr int kFewestTaps = 3, kMostTaps = 12;
    const double tap_px = (roughly ? kRoughTapBlurs : kTapBlurs) * blur_px;
    input.taps = std::clamp(static_cast<int>(std::ceil(motion_px.norm() / tap_px)), kFewestTaps, kMostTaps);
    input.turn = static_cast<float>(turn);
  }

  template <class Set>
  void SetLanes(const Input& input, TermCorner& corner, const Set& set) const {
    const Eigen::Vector2d at = CornerOnBoard(corner.size, corner.row, corner.col),
                          of_middle = corner.by_pixel * motion_px,
                          way = of_middle + turn * Eigen::Vector2d(-at.y(), at.x()), tap = way / input.taps;
    corner.blur += tap * tap.transpose() / 12;
    set(kWayX, way.x());
    set(kWayY, way.y());
    set(kAcrossX, -of_middle.y());
    set(kAcrossY, of_middle.x());
  }

  template <class Vector>
  void AddPrior(Vector information, Vector pull) const {
    // Robots turn by 3 rad/s, cameras that are knocked by as much, and shutters are open for 10 ms (a guess).
    constexpr double kTurn = 0.03;
    information[2] = 1 / (kTurn * kTurn);
    pull[2] = -turn * information[2];
  }

  double Move(const TermStep& step) {
    // Longer steps lead elsewhere; px, and as a share of the way, and rad. Then, px and rad, what no longer counts.
    constexpr double kMostPx = 1, kMostShare = 0.25, kMostTurn = 0.03, kStillPx = 0.04, kStillTurn = 0.004;
    Eigen::Vector2d more(step.of[0], step.of[1]);
    const double most = std::max(kMostPx, kMostShare * motion_px.norm());
    if (more.norm() > most) more *= most / more.norm();
    motion_px += more;
    const double more_turn = std::clamp(step.of[2], -kMostTurn, kMostTurn);
    turn += more_turn;
    step.of[0] = more.x(), step.of[1] = more.y();
    return std::max(more.norm() / kStillPx, step.Make(2, more_turn, kStillTurn));
  }

  /// Takes the way's part out of a blur that looked round: across the way it stays, the fit's lies between.
  void TakeOutOf(double& blur_px) const {
    constexpr double kLeastOfBlur = 0.1;  // of its variance
    const double square = blur_px * blur_px;
    blur_px = std::sqrt(std::max(square - motion_px.squaredNorm() / 24, kLeastOfBlur * square));
  }

  /// Starts from the step of UnevenBlurTerm, and takes the way's part out of the blur.
  void Start(const Eigen::Vector2d& uneven, double& blur_px) {
    // The longest way that the first step may find, blurs: a way of 5 has as much variance again.
    constexpr double kMostFirst = 4.5;
    // A way of length l has the variance l² / 12 along it, and the uneven part is half of that.
    const double length = std::min(std::sqrt(24 * uneven.norm()), kMostFirst * blur_px),
                 angle = std::atan2(uneven.y(), uneven.x()) / 2;
    motion_px = length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    TakeOutOf(blur_px);
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
    const V turn = Splat(input.turn), way_x = hn::NegMulAdd(turn, y, m.of<MotionTerm>(MotionTerm::kWayX)),
            way_y = hn::MulAdd(turn, x, m.of<MotionTerm>(MotionTerm::kWayY)),
            bend_x = hn::Mul(turn, m.of<MotionTerm>(MotionTerm::kAcrossX)),
            bend_y = hn::Mul(turn, m.of<MotionTerm>(MotionTerm::kAcrossY));
    for (int tap = 0; tap < input.taps; ++tap) {
      const float time = (static_cast<float>(tap) + 0.5f) / taps - 0.5f;
      // The mean over the time of this point.
      const V part = Splat(time), square = Splat(time * time + 1 / (12 * taps * taps));
      add_point(hn::MulAdd(square, bend_x, hn::MulAdd(part, way_x, x)),
                hn::MulAdd(square, bend_y, hn::MulAdd(part, way_y, y)), part);
    }
    Scale(Splat(1 / taps), p);
  }

  static HWY_INLINE void Derive(const LaneModel& m, V x, V y, const Picture& p, V* by) {
    const auto of = [&](ModelLanes::Parameter x_by, ModelLanes::Parameter y_by)
                        HWY_ATTR { return hn::MulAdd(m.of(x_by), p.way_x, hn::Mul(m.of(y_by), p.way_y)); };
    by[0] = of(ModelLanes::kByPixelXx, ModelLanes::kByPixelYx);
    by[1] = of(ModelLanes::kByPixelXy, ModelLanes::kByPixelYy);
    // The mean of the time squared is a twelfth.
    const V across = hn::MulAdd(m.of<MotionTerm>(MotionTerm::kAcrossX), p.by_x,
                                hn::Mul(m.of<MotionTerm>(MotionTerm::kAcrossY), p.by_y));
    by[2] = hn::MulSub(x, p.way_y, hn::Mul(y, p.way_x));
    by[2] = hn::MulAdd(across, Splat(1.0f / 12), by[2]);
  }

  static HWY_INLINE void AddStretch(const LaneModel& m, const Picture& p, ByStretch& by) {
    const V way_x = m.of<MotionTerm>(MotionTerm::kWayX), way_y = m.of<MotionTerm>(MotionTerm::kWayY);
    by.xx = hn::MulAdd(p.way_x, way_x, by.xx);
    by.xy = hn::MulAdd(p.way_x, way_y, by.xy);
    by.yx = hn::MulAdd(p.way_y, way_x, by.yx);
    by.yy = hn::MulAdd(p.way_y, way_y, by.yy);
  }
};

#endif  // CHEQUER_TERMS_ON_LANES
