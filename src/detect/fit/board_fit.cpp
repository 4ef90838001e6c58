#include "detect/fit/board_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/common/small_cholesky.h"
#include "detect/fit/board_fit_limits.h"

namespace chequer {
namespace {

constexpr int kMaxPasses = 8;
/// A step that moves corners and blur less ends the fit: the errors left are those of its square and cube.
constexpr double kSettledPx = 0.05, kSettledBlur = 0.1;
/// A board is explained where pixels are off by fewer variances (a guess). The next step over this one where residuals
/// are noise, for each variance that they have (measured: 0.01 to 0.06, 0.1 to 0.4 at three variances and beyond).
constexpr double kExplained = 2, kNextStep = 0.04;
/// Steps that shrink by less are taken to shrink by that (a guess).
constexpr double kLeastShrinking = 0.1;
/// Residuals that are less are rounding, not noise, variances (a guess).
constexpr double kLeastVariances = 1e-3;
/// Where a step moved corners farther, they are placed anew before the next one. (With 0.1 px, one of the tests' boards
/// under gloss lies 5 % farther off.)
constexpr double kFollowSettlingPx = 0.05;
/// A blur so much above what the pixels were chosen for asks for others.
constexpr double kWiderBlur = 1.2, kGrowingBlur = 0.5;
/// What a fit that has settled leaves.
struct SettleLimits {
  double square;         ///< of the way that the next steps would still lead, standard deviations, at most
  double shape;          ///< another shape of the blur lets Σ w r² fall by less for each pixel
  double shape_follows;  ///< a step that is made anyway has the shape that explains so much more
};
/// Measured: with a shape of 0.015, poses of moving boards with and without memory differ by a tenth more, in 2 % less
/// work. Noise alone explains less than 12 (kShapeCounts).
constexpr SettleLimits kUsualLimits{.square = 0.2, .shape = 0.008, .shape_follows = 12};
/// The same where another blur seems to be another place: of overexposed cells, the pixels at the light side of an edge
/// tell little, and of a board that is hidden in part, a turn moves the middle of what shows. Measured: poses with and
/// without memory differ by 0.08 to 0.10 deviations where boards are overexposed instead of 0.09 to 0.12, under hands
/// by 0.10 instead of 0.12, in 8 and 5 % more work.
constexpr SettleLimits kCloseLimits{.square = 0.01, .shape = 0.001, .shape_follows = 1};
/// Passes until what is done to the light (see board_fit_light.cpp) has settled too.
constexpr int kPassesOfLight = 4;
/// Until corners that were found lie right.
constexpr int kStepsOfFound = 3;
/// A board that seems blurred so many times more or less than the image's others is no start for them, nor they for it.
constexpr double kOtherBlur = 2;
/// Every how many pixels the first step uses: with half of them it comes near from any start, with a third from one
/// that knows the blur. Fewer tell the cells' levels too badly for the second step to judge what is occluded.
constexpr int kFirstStride = 2, kFirstStrideKnown = 3;
/// Where the levels are known too, all pixels of so many corners, spread over the board, place it as well as a third of
/// the pixels of all corners do (1.6 of a whole fit's standard deviations), in five sixths of the instructions. Of
/// every second of them, poses with and without memory would differ by a tenth more.
constexpr int kFewestSpread = 9;
/// Cells, in blurs, whose middles show their own light.
constexpr double kClearCell = 6;
/// Of a way, what it reaches beyond a board's rim, over what a blur does; and all of half of it beyond so much of a
/// cell.
constexpr double kMotionBlurReach = 0.1, kMotionBlurReachAllCells = 0.4;
/// Pixels at the rim are chosen by so many blurs (see OutwardReach).
constexpr double kReachBlurs = 2.2;
/// Larger ones have more pixels than the model with all its terms needs.
constexpr double kLargeCellPx = 12;
/// Steps towards a predicted board (kStillFromPrediction), …
constexpr int kMostFromPrediction = 4;
/// The same where others of the image tell its motion: a step that moves it less leaves a tenth of a pixel (measured).
constexpr int kMostAlongMotion = 3;
constexpr double kStillAlongMotionPx = 0.3;
/// … and where it has moved farther from where its pixels were chosen, they are chosen anew: those at the rim are
/// chosen by where the board is thought to lie, and a start that is 0.1 px off changes a pose by 0.1 standard
/// deviations. Corners that were found have boards off by as much. Where the rim's pixels fade out with the board, it
/// may be farther off (measured: up to 0.5 px, poses with and without memory agree as well).
constexpr double kOtherPixelsPx = 0.15, kOtherSoftPixelsPx = 0.35;
/// Where it has moved farther, the cells' illumination was sampled elsewhere than it lies.
constexpr double kOtherLevelsPx = 0.5;
/// Mean light of a cell of which much is saturated.
constexpr float kOverexposed = 0.98f;

bool IsOverexposed(const BoardFit::Start& start) {
  return std::any_of(start.light.begin(), start.light.end(),
                     [](const Eigen::Vector3f& light) { return light.maxCoeff() >= kOverexposed; });
}

}  // namespace

bool BoardFit::Prepare(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  run_.Start();
  run_->number = ++pixels_of_;
  run_->model.own_levels = choice.own_levels;
  static_cast<Terms::States&>(run_->model) = choice.terms;
  const bool any = ModelTerms::Of(choice.terms).any();
  run_->terms.plain_only = !choice.may_look_farther;
  run_->terms.may_move = choice.may_move && !choice.own_levels && !any;
  run_->terms.look_farther = any || (choice.from && choice.from->terms.look_farther);
  run_->view.size = start.size;
  run_->view.cell_ratio = start.cell_ratio;
  run_->inks.register_cells = start.register_cells;
  run_->view.overexposed = IsOverexposed(start);
  run_->view.channels = reader.channels();
  run_->view.red_phase = reader.mosaic() ? reader.mosaic()->red_x + 2 * reader.mosaic()->red_y : -1;
  for (int phase = 0; phase < 4; ++phase)
    run_->view.channel_of_phase[static_cast<std::size_t>(phase)] = reader.ChannelOf(phase & 1, phase >> 1);
  run_->model.blur_px = run_->light.window_blur_px = start.blur_px;
  run_->model.geometry = start.geometry;
  run_->model.blur_shape = start.blur_shape;
  run_->step.start_shape = start.blur_shape;
  // Another fit of the board has left its pixels.
  if (!Collect(reader, lens, choice.from && choice.from->terms.look_farther)) return false;
  BeginVisibility(start.visibility);
  run_->plain_input.stride = kFirstStride;
  const auto alike = [](double a, double b) { return std::max(a / b, b / a) < kOtherBlur; };
  // Dot gain looks like blur: where another board has taught it, its blur holds here, too.
  if (start.image && (run_->model.DotGainTerm::on() || alike(start.image->blur_px, run_->model.blur_px))) {
    run_->model.blur_px = start.image->blur_px;
    run_->model.edges = start.image->edges;
    run_->plain_input.stride = kFirstStrideKnown;
  }
  StartLevels(reader, start);
  if (choice.from) StartFrom(*choice.from);
  if (MayBeOutOfRegister()) {
    ShareInks(start);
    WeighYellow(start);
  }
  profiles_.Set(run_->model.edges);
  SetDerivatives();
  SetPlaces();
  return true;
}

bool BoardFit::Collect(const LightReader& reader, const Lens& lens, bool may_reuse) {
  run_->light.collected_for_motion = run_->model.motion_px;
  const double cell_px = run_->model.geometry.CellSide(), way = run_->model.motion_px.norm();
  const double reach_px =
      kMotionBlurReach * way + std::max(0.0, way / 2 - kMotionBlurReachAllCells * cell_px) / kReachBlurs;
  if (run_->terms.look_farther) run_->light.window_blur_px = run_->model.blur_px;
  // A pixel costs ten times as much where all terms are on, and large cells have many.
  const bool few = run_->terms.look_farther && cell_px > kLargeCellPx;
  const int of_lane = few ? BoardPixels::kFewOfLane : BoardPixels::kLaneCapacity;
  const double blur_px = run_->light.window_blur_px + reach_px;
  const BoardGeometry& geometry = run_->model.geometry;
  if (may_reuse && pixels_.HoldFor(lens, geometry, blur_px, of_lane)) {
    run_->light.collected_for = pixels_.collected_for();
    return pixels_.Reuse(lens, geometry) >= FittedBoard::kFewestCorners;
  }
  run_->light.collected_for = geometry;
  const int corners = pixels_.Collect(reader, lens, run_->view.size, geometry, blur_px, of_lane, run_->bend.taken_out);
  work_.Add(WorkStep::kCollectedPixel, static_cast<std::uint64_t>(pixels_.pixels()));
  return corners >= FittedBoard::kFewestCorners;
}

bool BoardFit::Recollect(const LightReader& reader, const Lens& lens, const Start& start) {
  const bool shaded = TakeBackShading();
  if (!Collect(reader, lens)) return false;
  SetDerivatives();
  SetPlaces();
  run_->step.corner_px = 0;  // since corners were placed
  if (shaded) EvenOutShading(start);
  return true;
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
  using Four = CornerFour::Values;
  const BlurShapeFit shape = FitOfShape(run_->step.placed_shape = run_->model.blur_shape);
  const bool round = run_->step.placed_shape.round(), printed_elsewhere = MayBeOutOfRegister();
  const Eigen::Vector2f bend_px = run_->model.blur_shape.BendPx().cast<float>();
  float* to = pixels_.lanes().parameter_data(LaneBlock::kCornerX);
  const int next = pixels_.lanes().padded();
  for (const CornerFour& at : pixels_.fours()) {
    const auto set = [&](LaneBlock::Parameter which, const Four& values) {
      for (int i = 0; i < 4; ++i) Eigen::Map<Four>(to + which * next + 4 * i).setConstant(values[i]);
    };
    Four x = at.board_x, y = at.board_y;
    for (std::size_t i = 0; printed_elsewhere && i < 4; ++i) {
      if (at.corner[i] < 0) continue;
      const Eigen::Vector2f printed = Printed(at.corner[i]).cast<float>();
      x[static_cast<Eigen::Index>(i)] = printed.x(), y[static_cast<Eigen::Index>(i)] = printed.y();
    }
    Four px_x = (at.x_by_x * at.x_by_x + at.x_by_y * at.x_by_y).rsqrt(),
         px_y = (at.y_by_x * at.y_by_x + at.y_by_y * at.y_by_y).rsqrt(),
         correlation = (at.x_by_x * at.y_by_x + at.x_by_y * at.y_by_y) * px_x * px_y;
    if (!round) {
      const CornerBlur<Four> blur = shape.At(shape.ByTurn(at.off_x, at.off_y));
      px_x /= blur.wider_x, px_y /= blur.wider_y, correlation += blur.skew;
      x -= at.x_by_x * bend_px.x() + at.x_by_y * bend_px.y();
      y -= at.y_by_x * bend_px.x() + at.y_by_y * bend_px.y();
    }
    set(LaneBlock::kCornerX, x), set(LaneBlock::kCornerY, y);
    set(LaneBlock::kPxPerCellX, px_x), set(LaneBlock::kPxPerCellY, px_y);
    set(LaneBlock::kCorrelation, correlation);
    if (run_->light.fades) {
      set(LaneBlock::kFadeX, at.fade_x / px_x), set(LaneBlock::kFadeY, at.fade_y / px_y);
      set(LaneBlock::kFadeXAt, at.fade_x_at), set(LaneBlock::kFadeYAt, at.fade_y_at);
    }
    to += 16;
  }
}

void BoardFit::SetLanes() {
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(run_->model.geometry);
  for (int i = 0; i < 9; ++i)
    run_->plain_input.board_from_plane[i] = static_cast<float>(board_from_plane(i / 3, i % 3));
  run_->plain_input.blur_px = static_cast<float>(run_->model.blur_px);
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  run_->plain_input.edge_x = profiles_.Across(board_by_pixel.row(0));
  run_->plain_input.edge_y = profiles_.Across(board_by_pixel.row(1));
  // The first step only has to come near.
  run_->plain_input.corner = !ComesNear() ? profiles_.Between(board_by_pixel.row(0)) : CornerExcess{};
  PhaseValues floor, slope;
  for (std::size_t phase = 0; phase < 4; ++phase) {
    const std::size_t channel = static_cast<std::size_t>(run_->view.channel_of_phase[phase]);
    floor[phase] = run_->model.noise.floor[channel];
    slope[phase] = run_->model.noise.slope[channel];
  }
  LaneBlock& lanes = pixels_.lanes();
  const auto set = [&](int which, int lane, const PhaseValues& values) {
    std::copy_n(values.data(), 4, lanes.parameter_data(which) + lane);
  };
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const int lane = pixels_.Lane(corner);
    if (!pixels_.inside(corner) || lane >= run_->plain_input.lanes) continue;
    const QuadrantLevels quadrants = LevelsOf(corner);
    for (int i = 0; i < 4; ++i)
      set(LaneBlock::kL00 + i, lane,
          run_->model.levels[static_cast<std::size_t>(quadrants[static_cast<std::size_t>(i)])]);
    PhaseValues of_corner = floor;
    if (MayBeOutOfRegister() && run_->inks.beside_yellow[static_cast<std::size_t>(corner)])
      for (std::size_t phase = 0; phase < 4; ++phase) of_corner[phase] += run_->inks.yellow_variance[phase];
    set(LaneBlock::kNoiseFloor, lane, of_corner);
    set(LaneBlock::kNoiseSlope, lane, slope);
  }
}

Eigen::Vector2d BoardFit::MoveOf(int corner) const {
  const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
  return BoardGeometry::Move(by.x, by.y, run_->step.moves);
}

Eigen::Matrix2d BoardFit::BoardByPixel() const { return pixels_.place(pixels_.corners() / 2).board_by_pixel; }

BoardEquations::Input BoardFit::PlainEquations() const {
  return {.pixels = &pixels_,
          .hidden = run_->visibility.corners(),
          .lanes = run_->plain_input.lanes,
          .red_phase = run_->view.red_phase,
          .own_levels = run_->model.own_levels};
}

void BoardFit::UsePixels(int stride, bool of_spread) {
  run_->plain_input.stride = stride;
  run_->plain_input.lanes = of_spread ? 4 * pixels_.spread_corners() : KernelInput::kAllLanes;
}

bool BoardFit::SpreadCornersSuffice() const {
  int count = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) count += pixels_.is_spread(corner) && used(corner);
  return count == pixels_.spread_corners() && count >= kFewestSpread;
}

int BoardFit::PixelsOfStep() const {
  int pixels = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    if (pixels_.Lane(corner) < run_->plain_input.lanes) pixels += pixels_.pixels(corner);
  return pixels;
}

bool BoardFit::Step(LaneSums sums) {
  SetLanes();
  run_->plain_input.sums = sums;
  AccumulateLanes(run_->plain_input, pixels_.lanes());
  run_->told.sums_gone = false;
  work_.Add(WorkStep::kFitStep);
  work_.Add(WorkStep::kFitPixel, static_cast<std::uint64_t>(PixelsOfStep() / run_->plain_input.stride));
  const bool fixed_levels = sums == LaneSums::kShapes;
  BoardEquations::Input equations = PlainEquations();
  equations.fixed_levels = fixed_levels;
  equations_.Assemble(equations);
  const SmallCholesky<BoardEquations::kUnknowns> solver(equations_.normal());
  if (!solver.positive()) return false;
  run_->step.moves = solver.Solve(equations_.gradient());
  run_->step.moved += run_->step.moves.head<BoardGeometry::kParameters>();
  run_->step.inks = {};
  if (!run_->step.moves.allFinite()) return false;
  run_->step.gain = run_->step.moves.dot(equations_.gradient());
  if (!fixed_levels) equations_.MoveLevels(run_->step.moves, run_->model.levels);
  constexpr int kBlurUnknown = BoardGeometry::kParameters;
  run_->model.geometry.MoveCoordinates(run_->step.moves.head<BoardGeometry::kParameters>());
  const double blur_px = run_->model.blur_px;
  MoveBlur(run_->step.moves[kBlurUnknown]);
  run_->step.corner_px = FarthestStepPx();
  MoveBlurShape(blur_px);
  return true;
}

void BoardFit::MoveBlur(double step_px) {
  const double blur = std::clamp(run_->model.blur_px + step_px, std::max(kLeastBlur, 0.6 * run_->model.blur_px),
                                 std::min(kMostBlur, 1.6 * run_->model.blur_px));
  run_->step.blur_share = std::abs(blur / run_->model.blur_px - 1);
  run_->model.blur_px = blur;
}

double BoardFit::FarthestStepPx() const {
  double farthest = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    if (pixels_.inside(corner))
      farthest = std::max(farthest, (pixels_.place(corner).pixel_by_board * MoveOf(corner)).squaredNorm());
  return std::sqrt(farthest);
}

double BoardFit::LeftVariances() const {
  if (run_->plain_input.sums == LaneSums::kShapes) return 1;  // no weights were summed
  return std::max((equations_.chi_square() - run_->step.gain) / std::max(WeightUsed(), 1.0), kLeastVariances);
}

double BoardFit::SquareOf(const BoardGeometry::Parameters& moves) const {
  constexpr int kMoves = BoardGeometry::kParameters;
  return moves.dot(equations_.normal().topLeftCorner<kMoves, kMoves>() * moves);
}

BoardFit::StepSize BoardFit::SizeOfStep() const {
  const double variances = LeftVariances();
  return {SquareOf(run_->step.moves.head<BoardGeometry::kParameters>()) / variances, variances};
}

bool BoardFit::WhatIsLeftCounts(const StepSize& step, const StepSize& before, double most) const {
  // With a budget, plain fits of all boards go before better ones of those that they do not explain.
  if (run_->terms.plain_only && step.variances > kExplained) return false;
  double next = kNextStep * std::max(step.variances, 1.0);
  // Two steps tell it better.
  if (before.square > 0) next = std::sqrt(step.square / before.square);
  // As each of those that follow shrinks by as much, they lead so many times as far as the last one. Plain fits under a
  // budget (above) do not go all the way.
  const double left = run_->terms.plain_only ? next : next / std::max(1 - next, kLeastShrinking);
  return left * left * step.square > most;
}

bool BoardFit::FollowsClosely() const {
  // With a budget, plain fits of all boards go before better ones.
  return !run_->terms.plain_only && (run_->view.overexposed || AnyUnused());
}

bool BoardFit::BeginsNear(const Start& start) const {
  return start.near && start.image && !run_->view.overexposed && !run_->model.own_levels &&
         !run_->model.MotionTerm::on();
}

bool BoardFit::Settle(const Lens& lens, const Start& start, bool noise_known) {
  LaneSums sums = noise_known ? LaneSums::kLevels : LaneSums::kNoise;
  run_->light.fades = true;
  bool edges_told = start.image != nullptr;
  StepSize step, before;
  for (int pass = 1; pass < kMaxPasses; before = step, ++pass) {
    const SettleLimits& settled = FollowsClosely() ? kCloseLimits : kUsualLimits;
    const bool moved = run_->step.corner_px > kFollowSettlingPx;
    if (moved) pixels_.PlaceCorners(lens, run_->model.geometry);
    if (moved || pass == 1 || run_->step.shape_gain > settled.shape_follows) SetPlaces();
    run_->plain_input.robust_limit = noise_known ? kRobustLimit : 1e9f;
    if (!Step(sums) || run_->step.corner_px > kRunawayPx) return false;
    if (pass == 1 && BeginsNear(start) && run_->step.corner_px > kOtherPixelsPx) return false;
    step = SizeOfStep();
    if (MayBeOutOfRegister()) MoveInks(start);
    const bool changed = FindOccludedCorners();
    // What is done to the light follows the fit by a pass or two.
    const bool uneven = run_->light.bent || AnyUnused(), again = run_->light.shade_twice && pass == 1;
    const bool follows = uneven ? pass < kPassesOfLight : again;
    if (noise_known && !changed && !follows && run_->step.corner_px < kSettledPx &&
        run_->step.blur_share < kSettledBlur && run_->step.shape_gain < settled.shape * pixels_.pixels() &&
        !WhatIsLeftCounts(step, before, settled.square)) {
      // Of the image's first board, which tells the others: as it ends, however many steps it took.
      if (!start.image && sums == LaneSums::kNoise)
        EstimateNoise(pixels_, run_->visibility.corners(), run_->view.channel_of_phase, run_->model.noise);
      run_->told.settled = true;
      run_->result.moved_square = SquareOf(run_->step.moved) / step.variances;
      // It tells its edges, too: those of a board that lies elsewhere seem to have another shape.
      if (edges_told || !TellEdges(lens)) break;
      // What they explain is no noise.
      edges_told = true;
      run_->told.settled = noise_known = false;
      continue;
    }
    if (uneven ? pass > 1 && pass < kPassesOfLight : again) FollowShading(lens, start);
    noise_known = true;
    // It is the camera's: what a board has told holds for the image's others, too. What theirs have beside it, of print
    // or of steps that are not at their end, is no noise of pixels; their misfit widens the covariance.
    if (start.image) continue;
    if (sums == LaneSums::kNoise)
      EstimateNoise(pixels_, run_->visibility.corners(), run_->view.channel_of_phase, run_->model.noise);
    sums = LaneSums::kNoise;
  }
  return true;
}

bool BoardFit::TellEdges(const Lens& lens) {
  Finish(lens);
  if (!run_->result.flat()) return false;
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  // Its sums take the place of the last step's.
  const std::optional<EdgeSpread> found = FindEdgeSpread(run_->plain_input, board_by_pixel.row(0),
                                                         board_by_pixel.row(1), run_->visibility.corners(), pixels_);
  run_->told.sums_gone = !found;
  if (!found) return false;
  run_->model.edges = *found;
  profiles_.Set(run_->model.edges);
  run_->model.blur_px = run_->model.edges.blur_px;
  return true;
}

bool BoardFit::ComeNearByFound(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  // Few corners on one side place those on the other badly.
  if (!Prepare(reader, lens, start, choice)) return false;
  UsePixels(1);
  int found = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (used(corner) && !start.found[static_cast<std::size_t>(corner)]) run_->visibility.Set(corner, Hidden::kLeftOut);
    found += used(corner);
  }
  if (found < FittedBoard::kFewestCorners || found == pixels_.corners()) return false;
  for (int step = 0; step < kStepsOfFound; ++step) {
    if (!Step(LaneSums::kLevels)) return false;
    for (int corner = 0; corner < pixels_.corners(); ++corner) {
      if (!used(corner)) continue;
      if ((pixels_.place(corner).pixel_by_board * MoveOf(corner)).norm() > kRunawayPx) return false;
    }
    pixels_.PlaceCorners(lens, run_->model.geometry);
    SetPlaces();
  }
  // Where these have the others, there are other pixels.
  Start again = start;
  again.geometry = run_->model.geometry;
  again.image = nullptr;
  if (!Prepare(reader, lens, again, choice)) return false;
  return Step(LaneSums::kLevels) && run_->step.corner_px <= kRunawayPx;
}

void BoardFit::FollowMotion(const Lens& lens) {
  BoardModel& model = run_->model;
  const BoardGeometry from = model.geometry;
  const double lens_px = model.blur_px;
  const bool of_spread = SpreadCornersSuffice();
  UsePixels(of_spread ? 1 : kFirstStrideKnown, of_spread);
  for (int step = 0; step < kMostAlongMotion; ++step) {
    model.blur_shape = {model.motion_px, model.turn};
    model.blur_px = model.blur_shape.BlurPx(lens_px);
    SetPlaces();
    if (!Step(LaneSums::kShapes) || run_->step.corner_px > kRunawayPx) {
      model.geometry = from;
      run_->step.corner_px = 0;
    }
    pixels_.PlaceCorners(lens, model.geometry);
    if (run_->step.corner_px < kStillAlongMotionPx) break;
  }
  model.blur_px = lens_px;
  model.blur_shape = {};
  SetPlaces();
}

bool BoardFit::Fit(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  if (!Prepare(reader, lens, start, choice)) return false;
  const bool looked_farther = run_->terms.look_farther;
  if (KnowsMotion(start)) FollowMotion(lens);
  if (!looked_farther && !ComeNear(reader, lens, start, choice)) return false;
  run_->terms.wide = looked_farther || BlursWidely() || SeemsMoved();
  run_->terms.look_farther = run_->terms.wide && (looked_farther || choice.may_look_farther);
  if (run_->terms.look_farther) {
    if (!looked_farther && CellPx() > kLargeCellPx && !Recollect(reader, lens, start)) return false;
    LookBeside(reader, lens);
  }
  // What asks for another fit, which may not be had now, is fitted to as many pixels as that would be.
  UsePixels(run_->terms.wide && !choice.may_look_farther ? StrideFor(kMostPixels) : 1);
  const bool noise_known = start.image || choice.from;
  const bool settled = run_->terms.look_farther ? SettleModel(reader, lens, start, noise_known, choice)
                                                : Settle(lens, start, noise_known);
  if (!settled && BeginsNear(start)) {
    // It was not near, after all.
    Start anew = start;
    anew.near = false;
    if (run_->step.corner_px < kRunawayPx) anew.geometry = run_->model.geometry;
    return Fit(reader, lens, anew, choice);
  }
  if (!settled) return false;
  FinishBent(reader, lens, start);
  return run_->result.determined();
}

bool BoardFit::FitAnew(const LightReader& reader, const Lens& lens, const Start& start) {
  if (!Recollect(reader, lens, start) || !Settle(lens, start, true)) return false;
  FinishBent(reader, lens, start);
  return run_->result.determined();
}

void BoardFit::FinishBent(const LightReader& reader, const Lens& lens, const Start& start) {
  Finish(lens);
  if (!run_->bend.found || run_->bend.taken_out) return;
  flat_ = *run_;
  if (FitBent(reader, lens, start)) return;
  *run_ = flat_;
  ++pixels_of_;  // they are none of this run's any more
}

bool BoardFit::FitBent(const LightReader& reader, const Lens& lens, const Start& start) {
  run_->bend.taken_out = run_->bend.found;
  run_->model.geometry = run_->bend.taken_out->middle();
  run_->step.corner_px = 0;
  if (run_->terms.look_farther ? !CollectAnew(reader, lens, start) : !Recollect(reader, lens, start)) return false;
  const bool settled = run_->terms.look_farther ? SettleModelByAll(reader, lens, start) : Settle(lens, start, true);
  if (settled) Finish(lens);
  // A bend that is taken out and not found again would be taken for known.
  return settled && run_->bend.found;
}

bool BoardFit::LeavePrediction(const LightReader& reader, const Lens& lens, const Start& start, LaneSums sums) {
  const double still_px = kStillFromPrediction * run_->model.blur_px;
  double moved_px = run_->step.corner_px;  // at most
  for (int step = 1; step < kMostFromPrediction && run_->step.corner_px > still_px; ++step) {
    pixels_.PlaceCorners(lens, run_->model.geometry);
    SetPlaces();
    if (!Step(sums) || run_->step.corner_px > kRunawayPx) return false;
    moved_px += run_->step.corner_px;
  }
  const double other_px = std::lerp(kOtherPixelsPx, kOtherSoftPixelsPx, BoardPixels::RimSoftness(CellPx()));
  if (moved_px > other_px && !Recollect(reader, lens, start)) return false;
  // Levels that were sampled so far off leave more residuals than noise does.
  if (moved_px <= kOtherLevelsPx || sums == LaneSums::kLevels) return true;
  UsePixels(kFirstStrideKnown);
  return Step(LaneSums::kLevels) && run_->step.corner_px <= kRunawayPx;
}

bool BoardFit::ComeNear(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  // The first step only has to come near: a part of the pixels does, whatever their noise.
  // Who judges the noise by what is left needs the levels as they fit. Another's are as sampled, where their neighbours
  // do not blur into them, and none is overexposed: it may be any that is as light, and edges would seem blurred
  // instead.
  const bool knows_levels = start.image && !run_->view.overexposed &&
                            BoardByPixel().rowwise().norm().maxCoeff() * kClearCell * run_->model.blur_px < 1;
  const LaneSums first = knows_levels && !run_->model.own_levels ? LaneSums::kShapes : LaneSums::kLevels;
  const bool knows_all = first == LaneSums::kShapes && run_->plain_input.stride == kFirstStrideKnown;
  if (knows_all && SpreadCornersSuffice()) UsePixels(1, true);
  if (!BeginsNear(start)) {
    const bool near = Step(first) && run_->step.corner_px <= kRunawayPx;
    if (!near && !ComeNearByFound(reader, lens, start, choice)) return false;
    if (start.predicted && !LeavePrediction(reader, lens, start, first)) return false;
  }
  if (run_->view.overexposed) {
    // Levels began at full scale, and the blur has taken up what they lacked: it begins anew.
    run_->model.blur_px = start.blur_px;
    if (!Step(first) || run_->step.corner_px > kRunawayPx) return false;
  }
  // The rim's pixels were chosen for a sharper image: what is blurred into them from beside the board would pull it.
  for (double chosen_for = start.blur_px; run_->model.blur_px > kWiderBlur * chosen_for;) {
    // A blur that grows as much as a step may goes on to grow.
    const bool grows = run_->step.blur_share > kGrowingBlur;
    if (!grows) chosen_for = run_->light.window_blur_px = run_->model.blur_px;
    if (!grows && !Recollect(reader, lens, start)) return false;
    if (!Step(first) || run_->step.corner_px > kRunawayPx) return false;
  }
  EvenOutShading(start);
  return true;
}

}  // namespace chequer
