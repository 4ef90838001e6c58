// Of BoardFit: the fit of the model with all its terms (model_kernel.h).
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/board_fit.h"
#include "detect/board_fit_limits.h"

namespace chequer {
namespace {

/// Blur, of a cell's shorter way across, from which on the cells beyond a corner's four count: the edges beyond are half
/// a cell away from a corner's farthest pixels.
constexpr double kWideBlur = 0.14;
/// The way between two points of motion that are looked at, in blurs of the lens: a box as wide is a Gaussian to 1 %.
constexpr double kTapBlurs = 2.5;
/// Fewer points would not show how the light changes with the way.
constexpr int kFewestTaps = 3, kMostTaps = 12;
/// Of a board's pixels: so many bring the fit near, and so many at most finish it. What they leave out costs precision
/// that boards of cells as large have in plenty.
constexpr int kPixelsNear = 1000, kMostPixels = 6000;
/// Passes in all; of them, those that follow what is done to the light.
constexpr int kMostModelPasses = 14, kModelPassesOfLight = 4;
/// A step that moves corners and blur less ends the fit; with less than the first, all pixels are looked at.
constexpr double kNearPx = 0.1, kModelSettledPx = 0.04, kModelSettledBlur = 0.04;
/// The same in the first one where the corners of a board that moved were seen in its stripes.
constexpr double kRunawayMovedPx = 6;
/// Where corners lie as much farther off than was thought, other pixels are the board's.
constexpr double kCollectAnewPx = 0.3, kCollectAnewMotionPx = 3;
/// Longest steps; longer ones lead elsewhere. Those of a motion also as a share of it.
constexpr double kMostMotionStepPx = 1, kMostMotionStepShare = 0.25, kMostGainStep = 0.05;
const ShadowEdge::Parameters kMostShadowStep(0.1, 0.3, 0.3, 0.5);
/// What is known of a shadow's edge before the pixels are looked at: standard deviations.
const ShadowEdge::Parameters kShadowKnownTo(0.1, 0.3, 0.4, 0.8);
/// Steps of terms that no longer count: px, cells, and as the edge's parameters; and how many times longer ones are near
/// enough for all pixels.
constexpr double kStillMotionPx = 0.04, kStillGain = 0.0003, kNearTerms = 10;
const ShadowEdge::Parameters kStillShadow(0.003, 0.003, 0.004, 0.03);
/// Blur, cells and px, from which on it may be motion.
constexpr double kMovedBlur = 0.12, kMovedBlurPx = 1.2;
/// Standard deviations by which the blur along one direction must differ from that across it to be motion: measured, 33
/// and more of ways of half a cell, up to 3 of wide blurs.
constexpr double kLeastUneven = 8;
/// With as many, it is one, whatever else there may be.
constexpr double kSureUneven = 30;
/// Another board of the image moved alike if, of what is found first, so much at most goes another way, and the way is as
/// long within these factors (it is found too short).
constexpr double kAcrossMotion = 0.35, kLeastOfMotion = 0.4, kMostOfMotion = 1.4;
/// The least dot gain that is looked for with it, cells: it makes edges uneven, too.
constexpr double kLeastFirstGain = 0.03;
/// The longest way that the first step may find, blurs (a way of 5 has as much variance again), and what it leaves of the
/// blur's variance at least.
constexpr double kMostFirstMotion = 4.5, kLeastOfBlur = 0.1;
/// The gain over the first step to it, as levels and blur have taken up the rest: measured.
constexpr double kFirstGainStep = 1.75;
/// Ink spreads over no more of a cell.
constexpr double kMostGain = 0.3;
/// How far beyond the rim the light beside the board is looked up, cells, and half the width of the window.
constexpr double kBeside = 0.75, kBesideHalf = 0.25;

/// Of the 4 × 4 cells around a corner: the one of its four that is as dark or light, and near.
std::size_t QuadrantOfColour(int row, int col) {
  const int near_row = std::clamp(row, 1, 2), near_col = std::clamp(col, 1, 2);
  const bool same = (row + col + near_row + near_col) % 2 == 0;
  return static_cast<std::size_t>(2 * (near_row - 1) + (same ? near_col - 1 : 2 - near_col));
}

}  // namespace

bool BoardFit::BlursWidely() const {
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    const Eigen::Matrix2d& pixel_by_board = pixels_.place(corner).pixel_by_board;
    const double across =
        pixel_by_board.determinant() / std::max(pixel_by_board.col(0).norm(), pixel_by_board.col(1).norm());
    if (blur_px_ > kWideBlur * across) return true;
  }
  return false;
}

void BoardFit::LookBeside(const LightReader& reader, const Lens& lens) {
  const int rows = size_.rows + 2, cols = size_.cols + 2;
  beside_.resize(static_cast<std::size_t>(rows * cols));
  // Beyond what the board sends there during the exposure.
  const Eigen::Vector2d reach =
      Eigen::Vector2d::Constant(kBeside) + (BoardByPixel() * smear_px_).cwiseAbs() / 2;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      if (row > 0 && col > 0 && row < rows - 1 && col < cols - 1) continue;
      const auto along = [](int i, int count, double beyond) {
        const double middle = i + 0.5 - 0.5 * count, rim = 0.5 * count - 1;
        return i == 0 ? -rim - beyond : i == count - 1 ? rim + beyond : middle;
      };
      const Eigen::Vector2d board(along(col, cols, reach.x()), along(row, rows, reach.y()));
      Eigen::Matrix2d pixel_by_plane;
      const Eigen::Vector2d pixel = lens.ToImage(result_.geometry.ToPlane(board), &pixel_by_plane);
      const double half_px =
          kBesideHalf * std::sqrt(std::abs((pixel_by_plane * result_.geometry.PlaneByBoard(board)).determinant()));
      const float lit = shadow_ ? static_cast<float>(shadow_->At(board)) : 1;
      const Eigen::Vector3f light =
          reader.Rgb(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(half_px)) / lit;
      for (std::size_t phase = 0; phase < 4; ++phase)
        beside_[static_cast<std::size_t>(row * cols + col)][phase] =
            channels_ == 3 ? light[channel_of_phase_[phase]] : RedAndGreen::Of(light[0], light[1]);
    }
}

void BoardFit::MapLevels() {
  const int corners = pixels_.corners();
  model_levels_.resize(static_cast<std::size_t>(corners));
  for (int corner = 0; corner < corners; ++corner) {
    const int row = corner / (size_.cols - 1), col = corner % (size_.cols - 1);
    const QuadrantLevels quadrants = LevelsOf(corner);
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) {
        const int cell_row = row + r - 1, cell_col = col + c - 1;
        const bool on_board = cell_row >= 0 && cell_row < size_.rows && cell_col >= 0 && cell_col < size_.cols;
        int level = on_board ? cell_row * size_.cols + cell_col : ModelEquations::kNoLevel;
        if (on_board && own_levels_) level = quadrants[QuadrantOfColour(r, c)];
        model_levels_[static_cast<std::size_t>(corner)][static_cast<std::size_t>(4 * r + c)] = level;
      }
  }
}

void BoardFit::SetModelInput(int stride) {
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(result_.geometry);
  for (int i = 0; i < 9; ++i) model_input_.board_from_plane[i] = static_cast<float>(board_from_plane(i / 3, i % 3));
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  model_input_.edge_x = profiles_.Across(board_by_pixel.row(0));
  model_input_.edge_y = profiles_.Across(board_by_pixel.row(1));
  model_input_.taps =
      model_input_.terms.motion
          ? std::clamp(static_cast<int>(std::ceil(smear_px_.norm() / (kTapBlurs * blur_px_))), kFewestTaps, kMostTaps)
          : 1;
  if (shadow_) {
    const ShadowEdge::Parameters& values = shadow_->values();
    const auto value = [](double of) { return static_cast<float>(of); };
    model_input_.shadow = {value(values[ShadowEdge::kTakes]), value(std::cos(values[ShadowEdge::kDirection])),
                           value(std::sin(values[ShadowEdge::kDirection])), value(values[ShadowEdge::kOffset]),
                           value(std::exp(-values[ShadowEdge::kLogWidth]))};
  }
  model_input_.stride = stride;
}

void BoardFit::SetModelLanes() {
  const ModelColumns columns(model_input_.terms);
  model_lanes_.Reset(pixels_.lanes().padded(), columns.products());
  const int cols = size_.cols + 2;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    const CornerPlace& place = pixels_.place(corner);
    const int lane = pixels_.Lane(corner);
    const auto set = [&](int which, double value) {
      std::fill_n(model_lanes_.parameter_data(which) + lane, 4, static_cast<float>(value));
    };
    const Eigen::Matrix2d by_pixel = place.pixel_by_board.inverse();
    const Eigen::Vector2d way = by_pixel * smear_px_, tap = way / model_input_.taps;
    // Of a point of the way: the lens's blur, and what the way to the next adds.
    const Eigen::Matrix2d lens = blur_px_ * blur_px_ * by_pixel * by_pixel.transpose();
    const Eigen::Matrix2d blur = lens + tap * tap.transpose() / 12;
    for (int axis = 0; axis < 2; ++axis) {
      const double variance = blur(axis, axis);
      set(ModelLanes::kScaleX + axis, 1 / std::sqrt(variance));
      set(ModelLanes::kBlurX + axis, lens(axis, axis) / variance / blur_px_);
    }
    set(ModelLanes::kCornerX, place.board.x());
    set(ModelLanes::kCornerY, place.board.y());
    set(ModelLanes::kCovariance, blur(0, 1));
    set(ModelLanes::kByPixelXx, by_pixel(0, 0));
    set(ModelLanes::kByPixelXy, by_pixel(0, 1));
    set(ModelLanes::kByPixelYx, by_pixel(1, 0));
    set(ModelLanes::kByPixelYy, by_pixel(1, 1));
    set(ModelLanes::kWayX, way.x());
    set(ModelLanes::kWayY, way.y());
    const int row = corner / (size_.cols - 1), col = corner % (size_.cols - 1);
    const bool even_dark = IsDark(row, col);
    set(ModelLanes::kGain, even_dark ? ink_spread_ : -ink_spread_);
    // An edge of the rim moves out where its cell is dark, and stays where it is light: half of the gain either way
    // about a line half of it farther out.
    const double out = even_dark ? 0.5 : -0.5;
    const auto set_rim = [&](int first, bool at_start, bool at_end) {
      set(first, at_start ? 0.5 + out : 1);
      set(first + 1, at_end ? 0.5 - out : 1);
      set(first + 2, at_start ? -0.5 + out : -1);
      set(first + 3, at_end ? -0.5 - out : -1);
    };
    set_rim(ModelLanes::kEvenX0, col == 0, col == size_.cols - 2);
    set_rim(ModelLanes::kEvenY0, row == 0, row == size_.rows - 2);
    set(ModelLanes::kHalfEven, even_dark ? 0.5 : 0);
    set(ModelLanes::kHalfOdd, even_dark ? 0 : 0.5);
    const Eigen::Vector2d mixed = lens * Eigen::Vector2d(double{model_input_.shadow.normal_x}, double{model_input_.shadow.normal_y});
    set(ModelLanes::kShadowX, mixed.x());
    set(ModelLanes::kShadowY, mixed.y());
    for (std::size_t phase = 0; phase < 4; ++phase) {
      const std::size_t channel = static_cast<std::size_t>(channel_of_phase_[phase]);
      const auto set_phase = [&](int which, float value) {
        model_lanes_.parameter_data(which)[lane + static_cast<int>(phase)] = value;
      };
      set_phase(ModelLanes::kNoiseFloor, noise_.floor[channel]);
      set_phase(ModelLanes::kNoiseSlope, noise_.slope[channel]);
      for (int i = 0; i < ModelColumns::kLevels; ++i) {
        const int level = model_levels_[static_cast<std::size_t>(corner)][static_cast<std::size_t>(i)];
        set_phase(ModelLanes::kLevel00 + i,
                  level != ModelEquations::kNoLevel
                      ? levels_[static_cast<std::size_t>(level)][phase]
                      : beside_[static_cast<std::size_t>((row + i / 4) * cols + col + i % 4)][phase]);
      }
    }
  }
}

bool BoardFit::SolveModel(int stride) {
  SetModelInput(stride);
  SetModelLanes();
  AccumulateModel(model_input_, pixels_.lanes(), model_lanes_);
  work_.Add(WorkStep::kModelCorner, static_cast<std::uint64_t>(pixels_.corners()));
  const int looked_at = CountPixels() / stride;
  work_.Add(WorkStep::kModelPixel, static_cast<std::uint64_t>(looked_at));
  work_.Add(WorkStep::kModelTap, static_cast<std::uint64_t>(looked_at) * static_cast<std::uint64_t>(model_input_.taps));
  return model_equations_.Solve(EquationsOfModel());
}

ModelEquations::Input BoardFit::EquationsOfModel() const {
  ModelEquations::Input equations;
  equations.pixels = &pixels_;
  equations.lanes = &model_lanes_;
  equations.columns = ModelColumns(model_input_.terms);
  equations.used = used_;
  equations.levels = model_levels_;
  equations.channel_of_phase = channel_of_phase_;
  equations.level_count = LevelCount(size_, own_levels_);
  equations.band = own_levels_ ? 3 : 3 * size_.cols + 3;
  if (!shadow_) return equations;
  equations.prior_information.setZero(equations.columns.shared);
  equations.prior_pull.setZero(equations.columns.shared);
  const ShadowEdge::Parameters known = kShadowKnownTo.cwiseProduct(kShadowKnownTo).cwiseInverse();
  equations.prior_information.segment<4>(equations.columns.shadow) = known;
  equations.prior_pull.segment<4>(equations.columns.shadow) =
      known.cwiseProduct(shadow_start_.values() - shadow_->values());
  return equations;
}

bool BoardFit::StepModel(int stride, bool first) {
  if (!SolveModel(stride)) return false;
  const ModelColumns columns(model_input_.terms);
  const ModelEquations::Shared& step = model_equations_.step();
  step_.head<BoardGeometry::kParameters>() = step.head<BoardGeometry::kParameters>();
  result_.geometry.MoveCoordinates(step.head<BoardGeometry::kParameters>());
  const double blur = std::clamp(blur_px_ + step[columns.blur], std::max(kLeastBlur, 0.6 * blur_px_),
                                 std::min(kMostBlur, 1.6 * blur_px_));
  blur_change_ = std::abs(blur / blur_px_ - 1);
  blur_px_ = blur;
  for (std::size_t level = 0; level < levels_.size(); ++level)
    for (std::size_t phase = 0; phase < 4; ++phase)
      levels_[level][phase] +=
          static_cast<float>(model_equations_.LevelStep(static_cast<int>(level), channel_of_phase_[phase]));
  terms_move_ = 0;
  if (model_input_.terms.motion) {
    Eigen::Vector2d more = step.segment<2>(columns.motion);
    const double most = std::max(kMostMotionStepPx, kMostMotionStepShare * smear_px_.norm());
    if (more.norm() > most) more *= most / more.norm();
    smear_px_ += more;
    terms_move_ = std::max(terms_move_, more.norm() / kStillMotionPx);
  }
  if (model_input_.terms.dot_gain) {
    const double more = std::clamp(step[columns.dot_gain], -kMostGainStep, kMostGainStep);
    ink_spread_ = std::clamp(ink_spread_ + more, -kMostGain, kMostGain);
    terms_move_ = std::max(terms_move_, std::abs(more) / kStillGain);
  }
  if (model_input_.terms.shadow) {
    const ShadowEdge::Parameters more =
        ShadowEdge::Parameters(step.segment<4>(columns.shadow)).cwiseMax(-kMostShadowStep).cwiseMin(kMostShadowStep);
    shadow_ = ShadowEdge(shadow_->values() + more);
    terms_move_ = std::max(terms_move_, more.cwiseAbs().cwiseQuotient(kStillShadow).maxCoeff());
  }
  corner_move_px_ = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    corner_move_px_ = std::max(corner_move_px_, (pixels_.place(corner).pixel_by_board * MoveOf(corner)).norm());
  }
  return corner_move_px_ <= (first && model_input_.terms.motion ? kRunawayMovedPx : kRunawayPx);
}

void BoardFit::StartGain(double step, double start_blur_px) {
  model_input_.terms.dot_gain = fit_ink_ = true;
  ink_spread_ = std::clamp(kFirstGainStep * step, -2 * kMostGainStep, 2 * kMostGainStep);
  blur_px_ = std::min(blur_px_, start_blur_px);
}

bool BoardFit::FindTerms(int stride, const Start& start) {
  const ModelTerms terms = model_input_.terms;
  model_input_.terms.uneven_blur = model_input_.terms.dot_gain = true;
  const bool solved = SolveModel(stride);
  const ModelColumns columns(model_input_.terms);
  model_input_.terms = terms;
  if (!solved) return false;
  const ModelEquations::Shared& step = model_equations_.step();
  const Eigen::Vector2d uneven = step.segment<2>(columns.uneven_blur);
  const double gain = step[columns.dot_gain];
  const double by_motion = uneven.dot(model_equations_.InformationOn<2>(columns.uneven_blur) * uneven),
               by_gain = gain * gain * model_equations_.InformationOn<1>(columns.dot_gain)(0, 0);
  if (by_gain > by_motion && std::abs(gain) > kLeastFirstGain) {
    StartGain(gain, start.blur_px);
    return true;
  }
  if (!(by_motion > kLeastUneven * kLeastUneven)) return false;
  model_input_.terms.motion = true;
  // A way of length l has the variance l² / 12 along it, and the uneven part is half of that.
  const double length = std::min(std::sqrt(24 * uneven.norm()), kMostFirstMotion * blur_px_),
               angle = std::atan2(uneven.y(), uneven.x()) / 2;
  smear_px_ = length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  // Across the way, the blur stays: the fit's lies between.
  blur_px_ = std::sqrt(std::max(blur_px_ * blur_px_ - length * length / 24, kLeastOfBlur * blur_px_ * blur_px_));
  sure_of_motion_ = by_motion > kSureUneven * kSureUneven;
  if (start.image) StartLike(*start.image);
  return true;
}

void BoardFit::StartLike(const ImageTraits& image) {
  Eigen::Vector2d motion_px = image.motion_px;
  if (motion_px.dot(smear_px_) < 0) motion_px = -motion_px;  // there and back are the same
  if (motion_px.isZero()) return;
  const Eigen::Vector2d along = motion_px.normalized();
  const double share = along.dot(smear_px_) / motion_px.norm();
  const Eigen::Vector2d across = smear_px_ - along.dot(smear_px_) * along;
  if (share < kLeastOfMotion || share > kMostOfMotion || across.norm() > kAcrossMotion * smear_px_.norm()) return;
  smear_px_ = motion_px;
  blur_px_ = image.blur_px;
}

bool BoardFit::SeemsMoved() const {
  return may_move_ && smear_px_.isZero() && blur_px_ > std::max(kMovedBlur * CellPx(), kMovedBlurPx);
}

int BoardFit::CountPixels() const {
  int all = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    for (int phase = 0; phase < 4; ++phase) all += pixels_.lanes().count(pixels_.Lane(corner) + phase);
  return all;
}

int BoardFit::StrideFor(int pixels) const { return std::max(1, (CountPixels() + pixels - 1) / pixels); }

bool BoardFit::SettleModel(const LightReader& reader, const Lens& lens, const Start& start, bool noise_known) {
  model_input_.terms = {.motion = !smear_px_.isZero(), .dot_gain = fit_ink_, .shadow = shadow_.has_value()};
  MapLevels();
  const Eigen::Vector2d collected_for_motion = smear_px_;
  int stride = StrideFor(kPixelsNear), judgements = 0;
  bool still = false, all = false;
  for (int pass = 0; pass < kMostModelPasses; ++pass) {
    if (corner_move_px_ > kFollowPx) pixels_.PlaceCorners(lens, result_.geometry);
    model_input_.robust_limit = noise_known ? kRobustLimit : 1e9f;
    if (pass == 0 && !all && SeemsMoved()) FindTerms(stride, start);
    if (!StepModel(stride, pass == 0)) return false;
    // What was not fitted yet says nothing of what is occluded, or of the noise.
    const bool fitted = pass > 0, judged = fitted && (still || pass >= kModelPassesOfLight);
    const bool terms_still = terms_move_ <= 1;
    still = terms_still && corner_move_px_ < kFollowPx;
    const bool changed = judged && FindHiddenCorners(judgements++ < kModelPassesOfLight);
    const bool near =
        fitted && !changed && corner_move_px_ < kNearPx && blur_change_ < kNearPx && terms_move_ <= kNearTerms;
    if (work_.units() > start.most_units) return near;
    const bool settled = terms_still && corner_move_px_ < kModelSettledPx && blur_change_ < kModelSettledBlur;
    if (all && judged && near && settled) break;
    const bool light_follows = fitted && pass < kModelPassesOfLight && !shadow_;
    if (light_follows) {
      FindHiddenCells();
      EvenOutShading(start);
    }
    if (fitted) {
      EstimateNoise(pixels_, used_, channel_of_phase_, noise_);
      noise_known = true;
    }
    if (all || !(near || pass >= kMostModelPasses / 2)) continue;
    // Pixels chosen for corners that were far off, or before the way was known, reach into what lies beside the rim.
    const bool elsewhere = FarthestMove(collected_for_) > kCollectAnewPx ||
                           (smear_px_ - collected_for_motion).norm() > kCollectAnewMotionPx;
    judgements = 0;  // by other pixels, or by more
    if (elsewhere && !CollectAnew(reader, lens)) return false;
    all = still = true;
    stride = StrideFor(kMostPixels);
    pass = 0;
  }
  return true;
}

bool BoardFit::CollectAnew(const LightReader& reader, const Lens& lens) {
  if (!Collect(reader, lens)) return false;
  SetDerivatives();
  SetPlaces();
  LookBeside(reader, lens);
  return true;
}

}  // namespace chequer
