#include "detect/fit/board_fit.h"

#include <algorithm>
#include <cmath>

#include "core/small_cholesky.h"
#include "detect/fit/board_fit_limits.h"
#include "detect/fit/motion_edges.h"

namespace chequer {
namespace {

/// A board that seems blurred so many times more or less than the image's others is no start for them, nor they for it.
constexpr double kOtherBlur = 2;
/// Of a way, what it reaches beyond a board's rim, over what a blur does; and all of half of it beyond so much of a
/// cell.
constexpr double kMotionBlurReach = 0.1, kMotionBlurReachAllCells = 0.4;
/// Pixels at the rim are chosen by so many blurs (see OutwardReach).
constexpr double kReachBlurs = 2.2;
/// Larger ones have more pixels than the model with all its terms needs.
constexpr double kLargeCellPx = 12;
/// Plain blurs, which are wide with the way, that make a way long: four of the lens's. Its shape is then so far from a
/// round one that steps of the plain model may not come to its end. Where only those that did not were left to the
/// other model, poses with and without memory differed by .8 to 1.1 deviations instead of .1 (measured, cells of 18
/// px). In smaller cells than large ones, such a way is wide.
constexpr double kLongWayOfPlain = 3;
/// Boards that are hidden in part and lie farther from where their pixels were chosen have others (measured: under
/// hands, poses with and without memory differ by 0.08 deviations instead of 0.10, in a tenth more work).
constexpr double kOtherPixelsOfRestPx = 0.2;

/// Where corners are off by so many times what noise explains, the board may have another dot gain than the image's
/// others.
constexpr double kShiftsOfOtherGain = 3;

/// A bend that was taken out and is found again so near, standard deviations, is the right one (a choice; of one board
/// on a small radius the passes differed by 17, 4 and 1). Passes are at most so many (a bound).
constexpr double kSettledBend = 0.5;
constexpr int kMostBentPasses = 4;

bool AreBlursAlike(double blur_px, double other_px) {
  return std::max(blur_px, other_px) < kOtherBlur * std::min(blur_px, other_px);
}

bool IsOverexposed(const BoardFit::Start& start) {
  return std::any_of(start.light.begin(), start.light.end(),
                     [](const Eigen::Vector3f& light) { return light.maxCoeff() >= LightLevels::kOverexposed; });
}

}  // namespace

bool BoardFit::Prepare(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  run_.Start();
  run_->number = ++pixels_of_;
  run_->model.own_levels = choice.own_levels;
  static_cast<Terms::States&>(run_->model) = choice.terms;
  run_->terms.plain_only = !choice.may_look_farther;
  // A dot gain that another board has told says nothing of how this one moved.
  run_->terms.may_move =
      choice.may_move && !choice.own_levels && !ModelTerms::Of(choice.terms).AnyBeside<DotGainTerm>();
  run_->terms.look_farther = !BoardModel::IsPlain(choice.terms) || (choice.from && choice.from->terms.look_farther);
  run_->view.size = start.size;
  run_->view.cell_ratio = start.cell_ratio;
  run_->view.edge_tally = start.edge_tally;
  run_->inks.register_cells = start.register_cells;
  run_->bend.turns_over_rows = start.turns_over_rows;
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
  if (const double blur_px = BlurOfImage(start); blur_px > 0) {
    // A board that moves is blurred more than others.
    run_->model.blur_px = AreBlursAlike(start.own_blur_px, blur_px) ? start.own_blur_px : blur_px;
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

double BoardFit::BlurOfImage(const Start& start) const {
  if (!start.image) return 0;
  // Dot gain looks like blur: where another board has taught it, its blur holds here, too.
  return run_->model.DotGainTerm::on() || AreBlursAlike(start.image->blur_px, start.blur_px) ? start.image->blur_px : 0;
}

double BoardFit::MotionReachPx() const {
  const double cell_px = run_->model.geometry.CellSide(), way = run_->model.motion_px.norm();
  return kMotionBlurReach * way + std::max(0.0, way / 2 - kMotionBlurReachAllCells * cell_px) / kReachBlurs;
}

bool BoardFit::Collect(const LightReader& reader, const Lens& lens, bool may_reuse) {
  if (run_->terms.look_farther || run_->light.few) run_->light.window_blur_px = run_->model.blur_px;
  // A pixel costs ten times as much where all terms are on, and large cells have many.
  const bool few = (run_->terms.look_farther || run_->light.few) && run_->model.geometry.CellSide() > kLargeCellPx;
  const int of_lane = few ? BoardPixels::kFewOfLane : BoardPixels::kLaneCapacity;
  const double blur_px = run_->light.window_blur_px + MotionReachPx();
  const BoardGeometry& geometry = run_->model.geometry;
  if (may_reuse && pixels_.HoldFor(lens, geometry, blur_px, of_lane)) {
    run_->light.collected_for = pixels_.collected_for();
    run_->light.collected_for_blur_px = pixels_.collected_for_blur_px();
    return pixels_.Reuse(lens, geometry) >= FittedBoard::kFewestCorners;
  }
  run_->light.collected_for = geometry;
  run_->light.collected_for_blur_px = blur_px;
  const int corners = pixels_.Collect(reader, lens, run_->view.size, geometry, blur_px, of_lane, run_->bend.taken_out);
  work_.Add(WorkStep::kCollectedPixel, static_cast<std::uint64_t>(pixels_.pixels()));
  return corners >= FittedBoard::kFewestCorners;
}

bool BoardFit::Recollect(const LightReader& reader, const Lens& lens, const Start& start) {
  const bool shaded = TakeBackShading();
  if (!Collect(reader, lens)) return false;
  SetDerivatives();
  SetPlaces();
  if (run_->light.fades) SetWindows();
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
  run_->step.placed_way = round ? WayInBlur{} : shape.InMiddle();
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
    to += 16;
  }
}

void BoardFit::SetLanes() {
  MovePixelsByLight();
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(run_->model.geometry);
  for (int i = 0; i < 9; ++i)
    run_->plain_input.board_from_plane[i] = static_cast<float>(board_from_plane(i / 3, i % 3));
  run_->plain_input.blur_px = static_cast<float>(run_->model.blur_px);
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  run_->plain_input.edge_x = profiles_.Across(board_by_pixel.row(0));
  run_->plain_input.edge_y = profiles_.Across(board_by_pixel.row(1));
  // The first step only has to come near.
  run_->plain_input.corner = !ComesNear() ? profiles_.Between(board_by_pixel.row(0)) : CornerExcess{};
  AddMotion(run_->step.placed_way, run_->plain_input);
  const float gain = static_cast<float>(run_->model.dot_gain);
  run_->plain_input.grown = gain != 0;
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
    if (run_->plain_input.grown) {
      const int row = corner / (run_->view.size.cols - 1), col = corner % (run_->view.size.cols - 1);
      std::fill_n(lanes.parameter_data(LaneBlock::kGain) + lane, 4, IsDark(row, col) ? gain : -gain);
    }
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

BoardEquations::Input BoardFit::PlainEquations() const {
  return {.pixels = &pixels_,
          .hidden = run_->visibility.corners(),
          .lanes = run_->plain_input.lanes,
          .red_phase = run_->view.red_phase,
          .fixed_levels = run_->plain_input.sums == LaneSums::kShapes,
          .own_levels = run_->model.own_levels};
}

void BoardFit::UsePixels(int stride, bool of_spread) {
  run_->plain_input.stride = stride;
  run_->plain_input.lanes = of_spread ? 4 * pixels_.spread_corners() : KernelInput::kAllLanes;
}

int BoardFit::PixelsOfStep() const {
  int pixels = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    if (pixels_.Lane(corner) < run_->plain_input.lanes) pixels += pixels_.pixels(corner);
  return pixels;
}

void BoardFit::SumLanes() {
  AccumulateLanes(run_->plain_input, pixels_.lanes());
  work_.Add(WorkStep::kFitPixel, static_cast<std::uint64_t>(PixelsOfStep() / run_->plain_input.stride));
}

void BoardFit::SumPlain() {
  SumLanes();
  equations_.Assemble(PlainEquations());
}

bool BoardFit::Step(LaneSums sums) {
  SetLanes();
  run_->plain_input.sums = sums;
  SumPlain();
  run_->told.sums_gone = false;
  work_.Add(WorkStep::kFitStep);
  const SmallCholesky<BoardEquations::kUnknowns> solver(equations_.normal());
  if (!solver.positive()) return false;
  run_->step.moves = solver.Solve(equations_.gradient());
  run_->step.moved += run_->step.moves.head<BoardGeometry::kParameters>();
  run_->step.inks = {};
  if (!run_->step.moves.allFinite()) return false;
  run_->step.gain = run_->step.moves.dot(equations_.gradient());
  if (sums != LaneSums::kShapes) equations_.MoveLevels(run_->step.moves, run_->model.levels);
  constexpr int kBlurUnknown = BoardGeometry::kParameters;
  run_->model.geometry.MoveCoordinates(run_->step.moves.head<BoardGeometry::kParameters>());
  const double blur_px = run_->model.blur_px;
  MoveBlur(run_->step.moves[kBlurUnknown]);
  run_->step.corner_px = FarthestStepPx();
  MoveBlurShape(blur_px);
  return true;
}

double BoardFit::BlurAfter(double step_px) const {
  return std::clamp(run_->model.blur_px + step_px, std::max(kLeastBlur, 0.6 * run_->model.blur_px),
                    std::min(kMostBlur, 1.6 * run_->model.blur_px));
}

void BoardFit::MoveBlur(double step_px) {
  const double blur = BlurAfter(step_px);
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

bool BoardFit::LookFarther(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  const bool looked_farther = run_->terms.look_farther;
  run_->terms.look_farther = looked_farther || choice.may_look_farther;
  if (!run_->terms.look_farther) return true;
  if (!looked_farther && CellPx() > kLargeCellPx && !Recollect(reader, lens, start)) return false;
  LookBeside(reader, lens);
  return true;
}

bool BoardFit::LiesOffItsPixels() const {
  return !run_->terms.look_farther && !run_->terms.plain_only && AnyUnused() &&
         FarthestMove(run_->light.collected_for) > kOtherPixelsOfRestPx;
}

bool BoardFit::FollowsLongWay() const {
  return run_->terms.may_move && CellPx() > kLargeCellPx &&
         run_->model.blur_shape.way_px.norm() > kLongWayOfPlain * run_->model.blur_px;
}

bool BoardFit::NeedsTermsAfterAll(const Start& start) const {
  if (run_->terms.wide) return false;
  if (BlursWidely(BlurOfImage(start)) || FollowsLongWay()) return true;
  const bool moved = !run_->model.blur_shape.round() || SeemsMoved();
  return run_->terms.may_move && moved && run_->told.pixel_variance > kExplained;
}

bool BoardFit::Fit(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  if (!Prepare(reader, lens, start, choice)) return false;
  const bool looked_farther = run_->terms.look_farther;
  if (KnowsMotion(start)) FollowMotion(lens);
  if (!looked_farther && !ComeNear(reader, lens, start, choice)) return false;
  run_->terms.wide = looked_farther || BlursWidely(BlurOfImage(start)) || SeemsMoved();
  if (run_->terms.wide && !LookFarther(reader, lens, start, choice)) return false;
  // What asks for another fit, which may not be had now, is fitted to as many pixels as that would be.
  UsePixels(run_->terms.wide && !choice.may_look_farther ? StrideFor(kMostPixels) : 1);
  const bool noise_known = start.KnowsNoise() || choice.from;
  if (start.TellsGain()) PrepareGain(reader, lens);
  bool settled = run_->terms.look_farther ? SettleModel(reader, lens, start, noise_known, choice)
                                          : Settle(lens, start, noise_known);
  if (settled && LiesOffItsPixels()) settled = SettleAnew(reader, lens, start);
  if (settled && NeedsTermsAfterAll(start)) {
    run_->terms.wide = true;
    if (!LookFarther(reader, lens, start, choice)) return false;
    if (run_->terms.look_farther) settled = SettleModel(reader, lens, start, true, choice);
  }
  if (!settled && BeginsNear(start)) {
    // It was not near, after all.
    Start anew = start;
    anew.near = false;
    if (run_->step.corner_px < kRunawayPx) anew.geometry = run_->model.geometry;
    return Fit(reader, lens, anew, choice);
  }
  if (!settled && choice.terms.dot_gain == 0 && run_->model.dot_gain != 0) {
    // What a fit without a strong dot gain had is no start for one with it.
    Choice with_gain = choice;
    with_gain.terms.dot_gain = run_->model.dot_gain;
    return Fit(reader, lens, start, with_gain);
  }
  if (!settled) return false;
  FinishBent(reader, lens, start);
  return run_->result.determined();
}

bool BoardFit::FitAnew(const LightReader& reader, const Lens& lens, const Start& start) {
  // Another run may have set them.
  profiles_.Set(run_->model.edges);
  if (run_->terms.look_farther) {
    SetTerms();
    if (!HavePixels(reader, lens, start) || !SettleModelByAll(reader, lens, start)) return false;
  } else if (!SettleAnew(reader, lens, start)) {
    return false;
  }
  FinishBent(reader, lens, start);
  return run_->result.determined();
}

bool BoardFit::FitClosely(const LightReader& reader, const Lens& lens, const Start& start) {
  return run_->terms.rough ? FitAnew(reader, lens, start) : run_->result.determined();
}

void BoardFit::ExplainFew(const LightReader& reader, const Lens& lens, const Start& start) {
  const Explained by_all = run_->result.explained;
  if (run_->terms.look_farther || by_all.of_few || run_->model.geometry.CellSide() <= kLargeCellPx) return;
  before_ = *run_;
  profiles_.Set(run_->model.edges);
  run_->light.few = true;
  UsePixels(1);
  // What a step leaves, the next one's sums tell.
  if (Recollect(reader, lens, start) && StepFromThere(lens, LaneSums::kLevels, true, 0) &&
      StepFromThere(lens, LaneSums::kNoise, false, 0)) {
    SumPixels();
    before_.result.explained = run_->result.explained;
    before_.result.explained.unknowns = by_all.unknowns;
    before_.result.explained.contrast = by_all.contrast;
    before_.result.explained.of_few = true;
  }
  *run_ = before_;
  ++pixels_of_;  // they are none of this run's any more
}

bool BoardFit::FitBesideHidden(const LightReader& reader, const Lens& lens, const Start& start) {
  run_->light.beside_hidden = true;
  return FitAnew(reader, lens, start);
}

void BoardFit::FinishBent(const LightReader& reader, const Lens& lens, const Start& start) {
  Finish(lens);
  // The board that tells the image's traits has told its own.
  if (!start.TellsGain() && !run_->terms.look_farther && run_->told.unexplained_shifts > kShiftsOfOtherGain) {
    PrepareGain(reader, lens);
    if (TellGain()) {
      if (!Settle(lens, start, true, true)) return;
      Finish(lens);
    }
  }
  FitBent(reader, lens, start);
}

void BoardFit::FitBent(const LightReader& reader, const Lens& lens, const Start& start) {
  if (!run_->bend.found || run_->bend.taken_out) return;
  // Corners of pixels that are curved, and of a model of flat paper, lie a little elsewhere than they would.
  for (int pass = 0; pass < kMostBentPasses; ++pass) {
    before_ = *run_;
    if (!TakeOutBend(reader, lens, start)) {
      *run_ = before_;
      ++pixels_of_;  // they are none of this run's any more
      return;
    }
    if (run_->bend.found->DeviationsFrom(*run_->bend.taken_out) < kSettledBend) return;
  }
}

bool BoardFit::TakeOutBend(const LightReader& reader, const Lens& lens, const Start& start) {
  run_->bend.taken_out = run_->bend.found;
  run_->model.geometry = run_->bend.taken_out->middle();
  run_->step.corner_px = 0;
  if (run_->terms.look_farther ? !CollectAnew(reader, lens, start) : !Recollect(reader, lens, start)) return false;
  const bool settled = run_->terms.look_farther ? SettleModelByAll(reader, lens, start) : Settle(lens, start, true);
  if (settled) Finish(lens);
  // The covariance has a bend's uncertainty only where the bend is found.
  return settled && run_->bend.found;
}

}  // namespace chequer
