#include "detect/board_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/board_fit_limits.h"
#include "detect/small_cholesky.h"
#include "detect/smear.h"

namespace chequer {
namespace {

constexpr int kMaxPasses = 8;
/// A step that moves corners and blur less ends the fit: the errors left are those of its square and cube.
constexpr double kSettledPx = 0.05, kSettledBlur = 0.1;
/// A blur so much above what the pixels were chosen for asks for others.
constexpr double kWiderBlur = 1.2;
/// Passes until what is done to the light (see board_fit_light.cpp) has settled too.
constexpr int kPassesOfLight = 4;
/// Until corners that were found lie right.
constexpr int kStepsOfFound = 3;
/// A board that seems blurred so many times more or less than the image's others is no start for them, nor they for it.
constexpr double kOtherBlur = 2;
/// Every how many pixels the first step uses: with half of them it comes near from any start, with a third from one
/// that knows the blur. Fewer tell the cells' levels too badly for the second step to judge what is hidden.
constexpr int kFirstStride = 2, kFirstStrideKnown = 3;
/// Cells, in blurs, whose middles show their own light.
constexpr double kClearCell = 6;
/// Of ways of more than a cell, little of the cells is left in the pixels, and some fits are off by more than the pixels'
/// noise tells: those whose corners lie farther off the plane than that, px (measured: 0.015 of most, 0.03 of these).
constexpr double kLongMotionCells = 1, kOffLongMotionPx = 0.016;
/// Of a way, what it reaches beyond a board's rim, over what a blur does; and all of half of it beyond so much of a cell.
constexpr double kSmearReach = 0.1, kSmearReachAllCells = 0.4;
/// Pixels at the rim are chosen by so many blurs (see OutwardReach).
constexpr double kReachBlurs = 2.2;
/// Light of a saturated pixel: code 254 and up.
constexpr float kSaturation = 253.5f / 255;
/// Mean light of a cell of which much is saturated.
constexpr float kOverexposed = 0.98f;

}  // namespace

bool BoardFit::Prepare(const LightReader& reader, const Lens& lens, const Start& start) {
  size_ = start.size;
  channels_ = reader.channels();
  red_phase_ = reader.mosaic() ? reader.mosaic()->red_x + 2 * reader.mosaic()->red_y : -1;
  for (int phase = 0; phase < 4; ++phase)
    channel_of_phase_[static_cast<std::size_t>(phase)] = reader.ChannelOf(phase & 1, phase >> 1);
  blur_px_ = start.blur_px;
  shade_twice_ = bent_light_ = fit_ink_ = look_farther_ = false;
  corner_move_px_ = 0;
  edges_ = {};
  result_.geometry = start.geometry;
  if (!Collect(reader, lens)) return false;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    int covered = 0;
    for (const int cell : CellsAround(size_, corner)) covered += start.covered[static_cast<std::size_t>(cell)];
    const std::size_t i = static_cast<std::size_t>(corner);
    usable_[i] = pixels_.inside(corner) && covered < 2 && !left_out_[i];
  }
  used_ = usable_;
  input_.stride = kFirstStride;
  if (start.image && std::max(start.image->blur_px / blur_px_, blur_px_ / start.image->blur_px) < kOtherBlur) {
    blur_px_ = start.image->blur_px;
    edges_ = start.image->edges;
    input_.stride = kFirstStrideKnown;
  }
  profiles_.Set(edges_);
  StartLevels(reader, start);
  SetDerivatives();
  SetPlaces();
  return true;
}

bool BoardFit::Collect(const LightReader& reader, const Lens& lens) {
  collected_for_ = result_.geometry;
  const double cell_px = std::sqrt(std::abs(result_.geometry.PlaneByBoard({0, 0}).determinant())), way = smear_px_.norm();
  const double reach_px = kSmearReach * way + std::max(0.0, way / 2 - kSmearReachAllCells * cell_px) / kReachBlurs;
  const int corners = pixels_.Collect(reader, lens, size_, result_.geometry, blur_px_ + reach_px);
  MarkSaturated(kSaturation, pixels_.lanes());
  work_.Add(WorkStep::kCollectedPixel, static_cast<std::uint64_t>(CountPixels()));
  return corners >= FittedBoard::kFewestCorners;
}

void BoardFit::SetDerivatives() {
  // Each coordinate's where the middle of the corner's pixels lies along its edge.
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const CornerPlace& place = pixels_.place(corner);
    const Eigen::Vector2d along_x_edge(place.board.x(), place.board.y() + place.middle.y()),
        along_y_edge(place.board.x() + place.middle.x(), place.board.y());
    derivatives_[static_cast<std::size_t>(corner)] = {BoardGeometry::MoveByParameters(along_x_edge, 0),
                                                      BoardGeometry::MoveByParameters(along_y_edge, 1)};
  }
  equations_.SetDerivatives(std::span(derivatives_).first(static_cast<std::size_t>(pixels_.corners())));
}

void BoardFit::SetPlaces() {
  LaneBlock& lanes = pixels_.lanes();
  const auto set = [&](LaneBlock::Parameter which, int lane, double value) {
    std::fill_n(lanes.parameter_data(which) + lane, 4, static_cast<float>(value));
  };
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    const CornerPlace& place = pixels_.place(corner);
    const Eigen::Matrix2d board_by_pixel = place.pixel_by_board.inverse();
    const double px_x = 1 / board_by_pixel.row(0).norm(), px_y = 1 / board_by_pixel.row(1).norm();
    const double wider_x = WiderBySmear(board_by_pixel.row(0), smear_px_, blur_px_),
                 wider_y = WiderBySmear(board_by_pixel.row(1), smear_px_, blur_px_);
    const int lane = pixels_.Lane(corner);
    set(LaneBlock::kCornerX, lane, place.board.x());
    set(LaneBlock::kCornerY, lane, place.board.y());
    set(LaneBlock::kPxPerCellX, lane, px_x / wider_x);
    set(LaneBlock::kPxPerCellY, lane, px_y / wider_y);
    set(LaneBlock::kCorrelation, lane, board_by_pixel.row(0).dot(board_by_pixel.row(1)) * px_x * px_y);
  }
}

void BoardFit::SetLanes() {
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(result_.geometry);
  for (int i = 0; i < 9; ++i) input_.board_from_plane[i] = static_cast<float>(board_from_plane(i / 3, i % 3));
  input_.blur_px = static_cast<float>(blur_px_);
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  input_.edge_x = profiles_.Across(board_by_pixel.row(0));
  input_.edge_y = profiles_.Across(board_by_pixel.row(1));
  // The first step only has to come near.
  input_.corner = input_.stride == 1 ? profiles_.Between(board_by_pixel.row(0)) : CornerExcess{};
  PhaseValues floor, slope;
  for (std::size_t phase = 0; phase < 4; ++phase) {
    const std::size_t channel = static_cast<std::size_t>(channel_of_phase_[phase]);
    floor[phase] = noise_.floor[channel];
    slope[phase] = noise_.slope[channel];
  }
  LaneBlock& lanes = pixels_.lanes();
  const auto set = [&](int which, int lane, const PhaseValues& values) {
    std::copy(values.begin(), values.end(), lanes.parameter_data(which) + lane);
  };
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    const int lane = pixels_.Lane(corner);
    const QuadrantLevels quadrants = LevelsOf(corner);
    for (int i = 0; i < 4; ++i)
      set(LaneBlock::kL00 + i, lane, levels_[static_cast<std::size_t>(quadrants[static_cast<std::size_t>(i)])]);
    set(LaneBlock::kNoiseFloor, lane, floor);
    set(LaneBlock::kNoiseSlope, lane, slope);
  }
}

Eigen::Vector2d BoardFit::MoveOf(int corner) const {
  const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
  const auto step = step_.head<BoardGeometry::kParameters>();
  return {by.x.dot(step), by.y.dot(step)};
}

Eigen::Matrix2d BoardFit::BoardByPixel() const { return pixels_.place(pixels_.corners() / 2).pixel_by_board.inverse(); }

bool BoardFit::Step(LaneSums sums) {
  SetLanes();
  input_.sums = sums;
  AccumulateLanes(input_, pixels_.lanes());
  work_.Add(WorkStep::kFitStep);
  work_.Add(WorkStep::kFitPixel, static_cast<std::uint64_t>(CountPixels()));
  const bool fixed_levels = sums == LaneSums::kShapes;
  equations_.Assemble({.pixels = &pixels_,
                       .used = used_,
                       .red_phase = red_phase_,
                       .fixed_levels = fixed_levels,
                       .own_levels = own_levels_});
  const SmallCholesky<BoardEquations::kUnknowns> solver(equations_.normal());
  if (!solver.positive()) return false;
  step_ = solver.Solve(equations_.gradient());
  if (!step_.allFinite()) return false;
  gain_ = step_.dot(equations_.gradient());
  if (!fixed_levels) equations_.MoveLevels(step_, levels_);
  constexpr int kBlurUnknown = BoardGeometry::kParameters;
  result_.geometry.MoveCoordinates(step_.head<BoardGeometry::kParameters>());
  const double blur = std::clamp(blur_px_ + step_[kBlurUnknown], std::max(kLeastBlur, 0.6 * blur_px_),
                                 std::min(kMostBlur, 1.6 * blur_px_));
  blur_change_ = std::abs(blur / blur_px_ - 1);
  blur_px_ = blur;
  corner_move_px_ = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    corner_move_px_ = std::max(corner_move_px_, (pixels_.place(corner).pixel_by_board * MoveOf(corner)).norm());
  }
  return true;
}

void BoardFit::Finish() {
  const LaneBlock& lanes = pixels_.lanes();
  double weight = 0, residual_square = 0, residual_count = 0, contrast = 0, shift_square = 0, shift_chi_square = 0;
  result_.corners_used = 0;
  result_.corner_used.fill(false);
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!used_[static_cast<std::size_t>(corner)]) continue;
    const CornerPlace& place = pixels_.place(corner);
    const int first = pixels_.Lane(corner);
    const double lit = LightAt(corner);
    for (int lane = first; lane < first + 4; ++lane) {
      weight += lanes.sum(kWeight, lane);
      residual_square += double{lanes.sum(kDarkSquare, lane) + lanes.sum(kLightSquare, lane)};
      residual_count += lanes.sum(kDarkCount, lane) + lanes.sum(kLightCount, lane);
    }
    const auto [information, gradient] = ShiftOf(corner);
    if (!(information.determinant() > 0)) continue;
    const std::size_t i = static_cast<std::size_t>(corner);
    result_.corner_used[i] = true;
    ++result_.corners_used;
    // What is left of the corner's own shift after the last step.
    const Eigen::Vector2d shift = information.inverse() * gradient;
    shift_square += (place.pixel_by_board * shift).squaredNorm();
    shift_chi_square += shift.dot(information * shift);
    contrast += lit * Contrast(corner);
  }
  const double n = std::max(result_.corners_used, 1);
  const double unknowns =
      (look_farther_ ? ModelColumns(model_input_.terms).shared : BoardEquations::kUnknowns) +
      channels_ * LevelCount(size_, own_levels_);
  const double chi_square = look_farther_ ? model_equations_.chi_square() : equations_.chi_square() - gain_;
  const double chi_square_per_pixel = chi_square / std::max(weight - unknowns, 1.0);
  // Edges that lie where no homography puts them (paper that is not flat, print, what is left of the lens's distortion)
  // move all pixels along them alike: the noise of pixels does not tell, the corners' own shifts do.
  const double chi_square_per_shift = shift_chi_square / std::max(2 * n - BoardGeometry::kParameters, 1.0);
  unexplained_shifts_ = chi_square_per_shift / std::max(chi_square_per_pixel, 1e-9);
  BoardGeometry::Information of_moves =
      InformationOnMoves() / std::max({chi_square_per_pixel, chi_square_per_shift, 1e-9});
  result_.reprojection_rms_px = std::sqrt(shift_square / n);
  if (smear_px_.norm() > kLongMotionCells * CellPx())
    of_moves /= std::max(shift_square / n / (kOffLongMotionPx * kOffLongMotionPx), 1.0);
  // What is left of a shadow moves the corners along its edge alike: measured, errors grow by as much again.
  if (own_levels_) of_moves /= std::max(unexplained_shifts_, 1.0);
  result_.information = result_.geometry.FromMoves(of_moves);
  result_.image = {noise_, blur_px_, edges_, smear_px_};
  result_.signal_to_noise = contrast / n / std::max(std::sqrt(residual_square / std::max(residual_count, 1.0)), 1e-6);
  TellLevels();
}

BoardGeometry::Information BoardFit::InformationOnMoves() const {
  constexpr int kMoves = BoardGeometry::kParameters;
  if (!look_farther_) {
    // The blur follows the geometry.
    const BoardEquations::Matrix& normal = equations_.normal();
    const BoardGeometry::Parameters by_blur = normal.col(kMoves).head<kMoves>();
    return normal.topLeftCorner<kMoves, kMoves>() - by_blur * by_blur.transpose() / normal(kMoves, kMoves);
  }
  const ModelEquations::SharedMatrix& all = model_equations_.information();
  const Eigen::Index others = all.rows() - kMoves;
  const ModelEquations::SharedMatrix common = all.bottomLeftCorner(others, kMoves);
  const Eigen::LDLT<ModelEquations::SharedMatrix> factor(all.bottomRightCorner(others, others));
  return all.topLeftCorner<kMoves, kMoves>() - common.transpose() * factor.solve(common);
}

ModelEquations::CornerShift BoardFit::ShiftOf(int corner) const {
  if (look_farther_) return model_equations_.ShiftOf(EquationsOfModel(), corner);
  const int lane = pixels_.Lane(corner);
  const auto sum = [&](int a, int b) { return equations_.SumOf(a, b, lane); };
  ModelEquations::CornerShift shift;
  shift.information << sum(kShiftX, kShiftX), sum(kShiftX, kShiftY), sum(kShiftX, kShiftY), sum(kShiftY, kShiftY);
  shift.gradient = Eigen::Vector2d(sum(kShiftX, kResidual), sum(kShiftY, kResidual)) -
                   equations_.ShiftGradientOfLevels(lane, LevelsOf(corner));
  shift.gradient -= shift.information * MoveOf(corner);
  return shift;
}

bool BoardFit::Settle(const Lens& lens, const Start& start, bool noise_known) {
  LaneSums sums = noise_known ? LaneSums::kLevels : LaneSums::kNoise;
  for (int pass = 1; pass < kMaxPasses; ++pass) {
    if (corner_move_px_ > kFollowPx) {
      pixels_.PlaceCorners(lens, result_.geometry);
      SetPlaces();
    }
    input_.robust_limit = noise_known ? kRobustLimit : 1e9f;
    if (!Step(sums) || corner_move_px_ > kRunawayPx) return false;
    const bool changed = FindHiddenCorners();
    // What is done to the light follows the fit by a pass or two.
    const bool uneven = bent_light_ || AnyUnused(), again = shade_twice_ && pass == 1;
    const bool follows = uneven ? pass < kPassesOfLight : again;
    // The image's first board tells its edges; what they explain is no noise.
    const bool told = pass == 1 && !start.image && TellEdges();
    if (noise_known && !changed && !follows && corner_move_px_ < kSettledPx && blur_change_ < kSettledBlur) break;
    if (uneven ? pass > 1 && pass < kPassesOfLight : again) {
      FindHiddenCells();
      EvenOutShading(start);
    }
    if (told) continue;
    if (sums == LaneSums::kNoise) EstimateNoise(pixels_, used_, channel_of_phase_, noise_);
    noise_known = true;
    sums = LaneSums::kNoise;
  }
  return true;
}

bool BoardFit::TellEdges() {
  Finish();
  if (!result_.flat()) return false;
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  const std::optional<EdgeShape> found =
      FindEdgeShape(input_, board_by_pixel.row(0), board_by_pixel.row(1), std::span(used_), pixels_);
  if (!found) return false;
  edges_ = *found;
  profiles_.Set(edges_);
  blur_px_ = edges_.blur_px;
  return true;
}

bool BoardFit::ComeNearByFound(const LightReader& reader, const Lens& lens, const Start& start) {
  // Few corners on one side place those on the other badly.
  if (!Prepare(reader, lens, start)) return false;
  input_.stride = 1;
  int found = 0;
  for (std::size_t corner = 0; corner < used_.size(); ++corner) {
    used_[corner] = used_[corner] && start.found[corner];
    found += used_[corner];
  }
  if (found < FittedBoard::kFewestCorners || found == pixels_.corners()) return false;
  for (int step = 0; step < kStepsOfFound; ++step) {
    if (!Step(LaneSums::kLevels)) return false;
    for (int corner = 0; corner < pixels_.corners(); ++corner) {
      if (!used_[static_cast<std::size_t>(corner)]) continue;
      if ((pixels_.place(corner).pixel_by_board * MoveOf(corner)).norm() > kRunawayPx) return false;
    }
    pixels_.PlaceCorners(lens, result_.geometry);
    SetPlaces();
  }
  // Where these have the others, there are other pixels.
  Start again = start;
  again.geometry = result_.geometry;
  again.image = nullptr;
  if (!Prepare(reader, lens, again)) return false;
  return Step(LaneSums::kLevels) && corner_move_px_ <= kRunawayPx;
}

bool BoardFit::Fit(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  left_out_ = choice.left_out;
  own_levels_ = choice.own_levels;
  may_move_ = choice.may_move && !choice.own_levels && !choice.shadow && choice.ink_spread == 0;
  shadow_ = choice.shadow;
  smear_px_ = choice.smear_px;
  ink_spread_ = choice.ink_spread;
  sure_of_motion_ = false;
  if (!Prepare(reader, lens, start)) return false;
  fit_ink_ = ink_spread_ != 0;
  look_farther_ = !smear_px_.isZero() || fit_ink_ || shadow_;
  if (!look_farther_ && !ComeNear(reader, lens, start)) return false;
  wide_ = look_farther_ || BlursWidely() || SeemsMoved();
  look_farther_ = wide_ && (look_farther_ || choice.may_look_farther);
  if (look_farther_) LookBeside(reader, lens);
  input_.stride = 1;
  const bool noise_known = start.image != nullptr;
  const bool settled = look_farther_ ? SettleModel(reader, lens, start, noise_known) : Settle(lens, start, noise_known);
  if (!settled) return false;
  Finish();
  return result_.determined();
}

bool BoardFit::ComeNear(const LightReader& reader, const Lens& lens, const Start& start) {
  // The first step only has to come near: a part of the pixels does, whatever their noise.
  input_.robust_limit = 1e9f;
  // Who judges the noise by what is left needs the levels as they fit. Another's are as sampled, where their neighbours
  // do not blur into them, and none is overexposed: it may be any that is as light, and edges would seem blurred instead.
  const bool overexposed = std::any_of(start.light.begin(), start.light.end(),
                                       [](const Eigen::Vector3f& light) { return light.maxCoeff() >= kOverexposed; });
  const bool knows_levels =
      start.image && !overexposed && BoardByPixel().rowwise().norm().maxCoeff() * kClearCell * blur_px_ < 1;
  const LaneSums first = knows_levels && !own_levels_ ? LaneSums::kShapes : LaneSums::kLevels;
  const bool near = Step(first) && corner_move_px_ <= kRunawayPx;
  if (!near && !ComeNearByFound(reader, lens, start)) return false;
  if (overexposed) {
    // Levels began at full scale, and the blur has taken up what they lacked: it begins anew.
    blur_px_ = start.blur_px;
    if (!Step(first) || corner_move_px_ > kRunawayPx) return false;
  }
  // The rim's pixels were chosen for a sharper image: what is blurred into them from beside the board would pull it.
  for (double chosen_for = start.blur_px; blur_px_ > kWiderBlur * chosen_for;) {
    chosen_for = blur_px_;
    if (!Collect(reader, lens)) return false;
    SetDerivatives();
    SetPlaces();
    if (!Step(first) || corner_move_px_ > kRunawayPx) return false;
  }
  hidden_cells_.assign(start.covered.begin(), start.covered.end());
  HideCellsBeside(left_out_);
  EvenOutShading(start);
  return true;
}

}  // namespace chequer
