// Of BoardFit: the fit of the model with all its terms (model_kernel.h).
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/fit/board_fit.h"
#include "detect/fit/board_fit_limits.h"

namespace chequer {
namespace {

/// Blur, of a cell's shorter way across, from which on the cells beyond a corner's four count: the edges beyond are
/// half a cell away from a corner's farthest pixels.
constexpr double kWideBlur = 0.14;
/// Of a board's pixels: so many bring the fit near.
constexpr int kPixelsNear = 1000;
/// Passes by all pixels; of them, and of those by some, the ones that follow what is done to the light.
constexpr int kMostModelPasses = 14, kModelPassesOfLight = 4;
/// After a step that moves corners less, what is hidden is judged.
constexpr double kStillPx = 0.3;
/// A step that moves corners and blur less ends the fit; with less than the first, all pixels are looked at.
constexpr double kNearPx = 0.1, kModelSettledPx = 0.04, kModelSettledBlur = 0.04;
/// Nor does one that leaves more of the way than that to those after it, standard deviations, squared. The first step
/// by all pixels leads four or five from where some of them had the board, and leaves a twentieth of that. (Measured:
/// poses of knocked frames with and without memory differ by .093 .113 .147 deviations in three streams; with an eighth
/// of this by .084 .094 .115, in a ninth more work.)
constexpr double kModelSettledSquare = 0.15;
/// Where others of the image tell the motion, the first step by some pixels leads near enough for all, if it moves
/// corners, blur and terms by no more (measured: with as much as without them, 4 % more work and the same poses).
constexpr double kNearMovedPx = 0.75, kNearMovedBlur = 0.25, kNearMovedTerms = 25;
/// In the first step, corners of a board that moved may go as much farther: they were seen in its stripes.
constexpr double kRunawayMovedPx = 6;
/// Where corners lie as much farther off than was thought, or the blur with its motion is another by such a share,
/// other pixels are the board's (measured: with 0.15 px, poses of knocked frames with and without memory differ by
/// 0.126 instead of 0.120 deviations, in 1 % less work).
constexpr double kCollectAnewPx = 0.05, kCollectAnewBlur = 0.05;
/// Steps of terms may be so many times what no longer counts where the fit is near enough for all pixels.
constexpr double kNearTerms = 10;
/// So is one whose step lets Σ w r² fall by no greater share: what models are compared by is what it was before the
/// step. (Of boards with a lamp's image, one in seventy seemed to fit worse with it.)
constexpr double kNearFall = 0.4;
/// Where corners stay as still as that, terms may be so many times as far off: each step halves what is left at least,
/// and the corners have followed. Measured on shadows' edges under wide blur, which come to rest slowly.
constexpr double kQuietPx = 0.02, kQuietTerms = 4;
/// Pixels that leave less of the noise that another board has told tell that there is less (a guess; in one knocked
/// frame, it was an eighth).
constexpr double kLeastOfNoise = 0.5;
/// Blur, cells and px, from which on it may be motion.
constexpr double kMovedBlur = 0.12, kMovedBlurPx = 1.2;
/// The same over the blur of others of the image, after a step (measured, of ways of .36 cells: 1.16 to 1.38).
constexpr double kWiderThanImage = 1.1;
/// Standard deviations by which the blur along one direction must differ from that across it to be motion: measured, 33
/// and more of ways of half a cell, up to 3 of wide blurs.
constexpr double kLeastUneven = 8;
/// With as many, it is one, whatever else there may be.
constexpr double kSureUneven = 30;
/// The least dot gain that is looked for with it, cells: it makes edges uneven, too.
constexpr double kLeastFirstGain = 0.03;

}  // namespace

bool BoardFit::BlursWidely(double image_blur_px) const {
  // To levels as they were sampled, edges seem sharper than they are: what other boards of the image show holds.
  double blur_px = std::max(run_->model.blur_px, image_blur_px);
  // Along a way, a blur is wider than the mean over all directions. (Measured: where that did not count, plain fits
  // with ways of .45 to .6 cells ended as they were, up to .7 deviations off; poses of knocked frames with and without
  // memory differed by .113 instead of .094 deviations in one of three streams.)
  if (run_->terms.may_move) blur_px = std::sqrt(blur_px * blur_px + run_->model.blur_shape.way_px.squaredNorm() / 24);
  const double wide = kWideBlur * FreeOfGain();
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    const Eigen::Matrix2d& pixel_by_board = pixels_.place(corner).pixel_by_board;
    const double across =
        pixel_by_board.determinant() / std::max(pixel_by_board.col(0).norm(), pixel_by_board.col(1).norm());
    if (blur_px > wide * across) return true;
  }
  return false;
}

bool BoardFit::SolveModel(int stride) {
  SetModelInput(stride);
  SetModelLanes();
  AccumulateModel(run_->model_input, pixels_.lanes(), model_lanes_);
  work_.Add(WorkStep::kModelCorner, static_cast<std::uint64_t>(pixels_.corners()));
  const int looked_at = pixels_.pixels() / stride;
  work_.Add(WorkStep::kModelPixel, static_cast<std::uint64_t>(looked_at));
  work_.Add(WorkStep::kModelTap,
            static_cast<std::uint64_t>(looked_at) * static_cast<std::uint64_t>(run_->model_input.taps));
  return model_equations_.Solve(EquationsOfModel());
}

ModelEquations::Input BoardFit::EquationsOfModel() const {
  ModelEquations::Input equations;
  equations.pixels = &pixels_;
  equations.lanes = &model_lanes_;
  equations.columns = ModelColumns(run_->model_input.terms);
  equations.hidden = run_->visibility.corners();
  equations.levels = run_->around.levels;
  equations.channel_of_phase = run_->view.channel_of_phase;
  equations.level_count = LevelCount(run_->view.size, run_->model.own_levels);
  equations.band = run_->model.own_levels ? 3 : 3 * run_->view.size.cols + 3;
  equations.prior_information.setZero(equations.columns.shared);
  equations.prior_pull.setZero(equations.columns.shared);
  Terms::ForEach([&]<class Term>() {
    const Term& term = run_->model;
    if constexpr (requires(ModelEquations::Shared & of) { term.AddPrior(of.segment<1>(0), of.segment<1>(0)); })
      if (run_->model_input.terms.on<Term>())
        term.AddPrior(equations.prior_information.segment<Term::kColumns>(equations.columns.of<Term>()),
                      equations.prior_pull.segment<Term::kColumns>(equations.columns.of<Term>()));
  });
  return equations;
}

void BoardFit::MoveTerms() {
  const ModelColumns columns(run_->model_input.terms);
  const ModelEquations::Shared information = model_equations_.information().diagonal();
  Terms::States& terms = run_->model;
  const Terms::States before = terms;
  ModelEquations::Shared made;
  // Terms and the blur do not move by more than they may; the others, and the levels, must not move as if they had.
  for (int round = 0; round <= Terms::kCount; ++round) {
    terms = before;
    made = model_equations_.step();
    made[columns.blur] = BlurAfter(made[columns.blur]) - run_->model.blur_px;
    run_->step.terms = 0;
    Terms::ForEach([&]<class Term>() {
      if (!run_->model_input.terms.on<Term>()) return;
      const int own = columns.of<Term>();
      const double counts = static_cast<Term&>(terms).Move(
          {made.data() + own, information.data() + own, run_->model.blur_px, BoardByPixel()});
      run_->step.terms = std::max(run_->step.terms, counts);
    });
    if (!model_equations_.Follow(made)) return;
  }
}

bool BoardFit::StepModel(int stride, bool first) {
  if (!SolveModel(stride)) return false;
  run_->told.sums_gone = false;
  MoveTerms();
  const ModelColumns columns(run_->model_input.terms);
  const ModelEquations::Shared& step = model_equations_.step();
  run_->step.moves.head<BoardGeometry::kParameters>() = step.head<BoardGeometry::kParameters>();
  run_->step.inks = {};
  run_->model.geometry.MoveCoordinates(step.head<BoardGeometry::kParameters>());
  MoveBlur(step[columns.blur]);
  for (std::size_t level = 0; level < run_->model.levels.size(); ++level)
    for (std::size_t phase = 0; phase < 4; ++phase)
      run_->model.levels[level][phase] +=
          static_cast<float>(model_equations_.LevelStep(static_cast<int>(level), run_->view.channel_of_phase[phase]));
  run_->step.corner_px = FarthestStepPx();
  return run_->step.corner_px <= (first && run_->model_input.terms.on<MotionTerm>() ? kRunawayMovedPx : kRunawayPx);
}

void BoardFit::StartGain(double step, double start_blur_px) {
  run_->model.DotGainTerm::Start(step);
  run_->model.blur_px = std::min(run_->model.blur_px, start_blur_px);
}

bool BoardFit::FindTerms(int stride, const Start& start) {
  const ModelTerms terms = run_->model_input.terms;
  run_->model_input.terms = terms.With<UnevenBlurTerm, DotGainTerm>();
  const bool solved = SolveModel(stride);
  const ModelColumns columns(run_->model_input.terms);
  run_->model_input.terms = terms;
  if (!solved) return false;
  const ModelEquations::Shared& step = model_equations_.step();
  const Eigen::Vector2d uneven = step.segment<2>(columns.of<UnevenBlurTerm>());
  const double gain = step[columns.of<DotGainTerm>()];
  const double by_motion = uneven.dot(model_equations_.InformationOn<2>(columns.of<UnevenBlurTerm>()) * uneven),
               by_gain = gain * gain * model_equations_.InformationOn<1>(columns.of<DotGainTerm>())(0, 0);
  const bool spread = !terms.on<DotGainTerm>() && by_gain > by_motion && std::abs(gain) > kLeastFirstGain;
  if (!spread && !(by_motion > kLeastUneven * kLeastUneven)) return false;
  if (spread) {
    StartGain(gain, start.blur_px);
  } else {
    MotionTerm& motion = run_->model;
    motion.Start(uneven, run_->model.blur_px);
    run_->terms.sure_of_motion = by_motion > kSureUneven * kSureUneven;
    if (start.image && motion.StartLike(start.image->motion_px)) run_->model.blur_px = start.image->blur_px;
  }
  run_->model_input.terms = ModelTerms::Of(run_->model);
  return true;
}

bool BoardFit::MayBeMotion(double blur_px, double cell_px) {
  return blur_px > std::max(kMovedBlur * cell_px, kMovedBlurPx);
}

bool BoardFit::SeemsMoved() const {
  return run_->terms.may_move && run_->model.motion_px.isZero() &&
         MayBeMotion(run_->model.blur_px / FreeOfGain(), CellPx());
}

bool BoardFit::MayHaveMoved(const Start& start) const {
  if (!run_->terms.may_move || !run_->model.motion_px.isZero()) return false;
  // This model's blur is round where motion is none of its terms. Who begins with it, as a dot gain is known, has had
  // no other, and is blurred more than others of the image.
  const double image_px = run_->model.DotGainTerm::on() ? BlurOfImage(start) : 0;
  const bool wider = image_px > 0 && run_->model.blur_px > kWiderThanImage * image_px;
  return wider || !run_->model.blur_shape.round() || SeemsMoved();
}

int BoardFit::StrideFor(int pixels) const { return std::max(1, (pixels_.pixels() + pixels - 1) / pixels); }

void BoardFit::SetTerms() {
  run_->model_input.terms = ModelTerms::Of(run_->model);
  MapLevels();
}

void BoardFit::FollowCorners(const Lens& lens) {
  // What a pixel is on the board at each corner tells how the way lies there, too: of a way of a cell, what is .03 px
  // off moves the board by half a standard deviation (measured).
  if (run_->step.corner_px > 0) pixels_.PlaceCorners(lens, run_->model.geometry);
}

bool BoardFit::Still() const { return run_->step.terms <= 1 && run_->step.corner_px < kStillPx; }

bool BoardFit::Near() const {
  return run_->step.corner_px < kNearPx && run_->step.blur_share < kNearPx && run_->step.terms <= kNearTerms &&
         model_equations_.fall() <= kNearFall;
}

bool BoardFit::Settled(const BoardRun::Step& before) const {
  const BoardRun::Step& step = run_->step;
  const auto left = [](double now, double then) { return 2 * now < then ? now * now / (then - now) : now; };
  if (left(step.corner_px, before.corner_px) < kQuietPx &&
      left(step.blur_share, before.blur_share) < kModelSettledBlur && left(step.terms, before.terms) <= 1)
    return true;
  if (step.corner_px >= kModelSettledPx || step.blur_share >= kModelSettledBlur) return false;
  return step.terms <= 1 || (step.terms <= kQuietTerms && step.corner_px < kQuietPx);
}

void BoardFit::FollowLight(const Start& start, bool light_follows) {
  if (light_follows) {
    run_->visibility.ShowCellsByAllCorners();
    EvenOutShading(start, LevelsFrom::kFirstSteps);
  }
  TellNoise(start);
}

BoardFit::StepSize BoardFit::SizeOfModelStep() const {
  const BoardGeometry::Parameters moves = run_->step.moves.head<BoardGeometry::kParameters>();
  const double variances = LeftByModel();
  return {moves.dot(InformationOnMoves() * moves) / variances, variances};
}

double BoardFit::LeftByModel() const { return model_equations_.chi_square() / std::max(WeightUsed(), 1.0); }

void BoardFit::TellNoise(const Start& start) {
  // It is the camera's, and the image's first board has told it: another one's pixels would only tell it less well, and
  // each fit of them otherwise. Unless that board was fitted badly.
  if (start.TellsNoise() || LeftByModel() < kLeastOfNoise) ReadNoise();
}

bool BoardFit::ComeNearModel(const Lens& lens, const Start& start, bool noise_known, int most_steps) {
  const int stride = StrideFor(kPixelsNear);
  int judgements = 0;
  const bool motion_known = KnowsMotion(start);
  bool still = false, asked = false;
  for (int pass = 0; pass < most_steps; ++pass) {
    FollowCorners(lens);
    run_->model_input.robust_limit = noise_known ? kRobustLimit : 1e9f;
    // Without a plain fit before it, the first step tells how wide the blur is.
    if (pass <= 1 && !asked && MayHaveMoved(start)) asked = true, FindTerms(stride, start);
    if (!StepModel(stride, pass == 0)) return false;
    if (MayBeOutOfRegister()) MoveInks(start);
    // Where another board has told blur, noise and dot gain, the first step only finds the place: it errs by its
    // square.
    const bool all_known = start.image && noise_known && run_->model.DotGainTerm::on() && run_->model.LitEvenly() &&
                           run_->model.motion_px.isZero();
    const bool placed =
        all_known && run_->step.corner_px < kStillPx && run_->step.blur_share < kNearPx && run_->step.terms <= 1;
    // Where others have told the motion too, a step that is not long leaves little.
    const bool placed_moving = motion_known && run_->step.corner_px < kNearMovedPx &&
                               run_->step.blur_share < kNearMovedBlur && run_->step.terms <= kNearMovedTerms;
    if (pass == 0 && (placed || placed_moving)) {
      run_->visibility.ShowCellsByAllCorners();
      EvenOutShading(start, LevelsFrom::kFirstSteps);
      break;
    }
    // What was not fitted yet says nothing of what is occluded, or of the noise.
    const bool fitted = pass > 0, judged = fitted && (Still() || still || pass >= kModelPassesOfLight);
    still = Still();
    const bool changed = judged && FindOccludedCorners(judgements++ < kModelPassesOfLight);
    // Quadrants' levels are but where a shadow's edge starts, which asks the corners that are used.
    const bool near = fitted && (!changed || run_->model.own_levels) && Near();
    if (work_.units() > start.most_units) return near;
    if (fitted) FollowLight(start, pass < kModelPassesOfLight);
    noise_known = noise_known || fitted;
    if (near) break;
  }
  return true;
}

bool BoardFit::SettleModelByAll(const LightReader& reader, const Lens& lens, const Start& start) {
  // Pixels chosen for corners that were far off, or before the way was known, reach into what lies beside the rim.
  const double blur_px = run_->model.blur_px + MotionReachPx(), was_px = run_->light.collected_for_blur_px;
  const bool elsewhere = FarthestMove(run_->light.collected_for) > kCollectAnewPx ||
                         std::abs(blur_px - was_px) > kCollectAnewBlur * was_px;
  if (elsewhere && !CollectAnew(reader, lens, start)) return false;
  run_->terms.rough = false;
  run_->light.fades = true;
  run_->model_input.robust_limit = kRobustLimit;
  const int stride = StrideFor(kMostPixels);
  bool still = true;
  BoardRun::Step before;  // by the same pixels; none yet
  StepSize size_before;
  for (int pass = 1, judgements = 0; pass < kMostModelPasses; ++pass) {
    FollowCorners(lens);
    if (!StepModel(stride, false)) return false;
    if (MayBeOutOfRegister()) MoveInks(start);
    const bool judged = Still() || still || pass >= kModelPassesOfLight;
    still = Still();
    const bool changed = judged && FindOccludedCorners(judgements++ < kModelPassesOfLight), near = !changed && Near();
    if (work_.units() > start.most_units) return near;
    const StepSize size = SizeOfModelStep();
    const bool nothing_left = !WhatIsLeftCounts(size, size_before, kModelSettledSquare);
    size_before = changed ? StepSize{} : size;
    run_->told.settled = judged && near && Settled(before) && nothing_left &&
                         (pass + 1 == kMostModelPasses || ShadingHolds(start, LeftByModel()));
    if (run_->told.settled) {
      TellNoise(start);
      if (!start.TellsGain() || !TellGainOfModel(lens)) break;
      run_->told.settled = false;
      // Levels have told a shading that may have been the dot gain.
      TakeBackFromPixels(lens);
      return SettleModelByAll(reader, lens, start);
    }
    before = changed ? BoardRun::Step{} : run_->step;
    FollowLight(start, pass < kModelPassesOfLight);
  }
  return true;
}

bool BoardFit::SettleModel(const LightReader& reader, const Lens& lens, const Start& start, bool noise_known,
                           const Choice& choice) {
  SetTerms();
  if (!ComeNearModel(lens, start, noise_known, choice.most_steps_near)) return false;
  run_->terms.rough = choice.roughly;
  return choice.roughly || work_.units() > start.most_units || SettleModelByAll(reader, lens, start);
}

bool BoardFit::HavePixels(const LightReader& reader, const Lens& lens, const Start& start) {
  if (run_->number == pixels_of_) return true;
  run_->number = ++pixels_of_;
  run_->light.fades = false;
  run_->light.window_blur_px = run_->model.blur_px;
  profiles_.Set(run_->model.edges);
  return CollectAnew(reader, lens, start);
}

bool BoardFit::CollectAnew(const LightReader& reader, const Lens& lens, const Start& start) {
  if (!Recollect(reader, lens, start)) return false;
  LookBeside(reader, lens);
  return true;
}

}  // namespace chequer
