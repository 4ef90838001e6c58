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
/// Correlation of the blur along both edges of a cell: from here on it is taken to a higher order. Below, what that
/// adds to the light is less than .3 % of the contrast (.5 × .3² × the square of the largest bend, .24). Above, fits
/// without it come to rest beside their minimum: at a slant of 65 degrees (.7) up to 20 deviations off.
constexpr double kSkewed = 0.3;
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
/// Where corners lie as much farther off than was thought, other pixels are the board's (measured: with 0.15 px, poses
/// of knocked frames with and without memory differ by 0.126 instead of 0.120 deviations, in 1 % less work).
constexpr double kCollectAnewPx = 0.05, kCollectAnewMotionPx = 3;
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
/// How far beyond the rim the light beside the board is looked up, cells, and half the width of the window: in the
/// middle of the margin of one cell that prints should have. (Farther out, a way brings what lies beyond it: measured,
/// with ways of .7 cells and such a margin, depths were off by 1.4 to 2 times as much, at 2.0 to 2.5 squares of their
/// covariances.)
constexpr double kBeside = 0.5, kBesideHalf = 0.15;
/// More pixels tell no more of it.
constexpr double kMostBesidePx = 4;

/// Of the 4 × 4 cells around a corner: the one of its four that is as dark or light, and near.
std::size_t QuadrantOfColour(int row, int col) {
  const int near_row = std::clamp(row, 1, 2), near_col = std::clamp(col, 1, 2);
  const bool same = (row + col + near_row + near_col) % 2 == 0;
  return static_cast<std::size_t>(2 * (near_row - 1) + (same ? near_col - 1 : 2 - near_col));
}

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

void BoardFit::LookBeside(const LightReader& reader, const Lens& lens) {
  const int rows = run_->view.size.rows + 2, cols = run_->view.size.cols + 2;
  run_->around.beside.resize(static_cast<std::size_t>(rows * cols));
  // At least beyond what the board sends there during the exposure.
  const Eigen::Vector2d half_way = (BoardByPixel() * run_->model.motion_px).cwiseAbs() / 2,
                        reach = (half_way + Eigen::Vector2d::Constant(kBesideHalf)).cwiseMax(kBeside);
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      if (row > 0 && col > 0 && row < rows - 1 && col < cols - 1) continue;
      const auto along = [](int i, int count, double beyond) {
        const double middle = i + 0.5 - 0.5 * count, rim = 0.5 * count - 1;
        return i == 0 ? -rim - beyond : i == count - 1 ? rim + beyond : middle;
      };
      const Eigen::Vector2d board(along(col, cols, reach.x()), along(row, rows, reach.y()));
      Eigen::Matrix2d pixel_by_plane;
      const Eigen::Vector2d pixel = lens.ToImage(run_->model.geometry.ToPlane(board), &pixel_by_plane);
      const double cell_px =
                       std::sqrt(std::abs((pixel_by_plane * run_->model.geometry.PlaneByBoard(board)).determinant())),
                   half_px = std::min(kBesideHalf * cell_px, kMostBesidePx);
      const LightThere lit = run_->model.LightAt(board);
      const Eigen::Vector3f light =
          reader.Rgb(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(half_px));
      for (std::size_t phase = 0; phase < 4; ++phase)
        run_->around.beside[static_cast<std::size_t>(row * cols + col)][phase] = lit.Of(
            run_->view.channels == 3 ? light[run_->view.channel_of_phase[phase]] : RedAndGreen::Of(light[0], light[1]),
            phase);
    }
}

void BoardFit::MapLevels() {
  const int corners = pixels_.corners();
  run_->around.levels.resize(static_cast<std::size_t>(corners));
  for (int corner = 0; corner < corners; ++corner) {
    const int row = corner / (run_->view.size.cols - 1), col = corner % (run_->view.size.cols - 1);
    const QuadrantLevels quadrants = LevelsOf(corner);
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) {
        const int cell_row = row + r - 1, cell_col = col + c - 1;
        const bool on_board =
            cell_row >= 0 && cell_row < run_->view.size.rows && cell_col >= 0 && cell_col < run_->view.size.cols;
        int level = on_board ? cell_row * run_->view.size.cols + cell_col : ModelEquations::kNoLevel;
        if (on_board && run_->model.own_levels) level = quadrants[QuadrantOfColour(r, c)];
        run_->around.levels[static_cast<std::size_t>(corner)][static_cast<std::size_t>(4 * r + c)] = level;
      }
  }
}

void BoardFit::SetModelInput(int stride) {
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(run_->model.geometry);
  for (int i = 0; i < 9; ++i)
    run_->model_input.board_from_plane[i] = static_cast<float>(board_from_plane(i / 3, i % 3));
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  run_->model_input.edge_x = profiles_.Across(board_by_pixel.row(0));
  run_->model_input.edge_y = profiles_.Across(board_by_pixel.row(1));
  Terms::ForEach([&]<class Term>() {
    typename Term::Input& input = run_->model_input;
    input = {};
    if constexpr (requires { run_->model.Term::SetInput(run_->model.blur_px, stride > 1, input); })
      if (run_->model_input.terms.on<Term>()) run_->model.Term::SetInput(run_->model.blur_px, stride > 1, input);
  });
  run_->model_input.stride = stride;
}

void BoardFit::SetModelLanes() {
  model_lanes_.Reset(pixels_.lanes().padded(), ModelColumns(run_->model_input.terms).products());
  const Eigen::Matrix2d shading = HowLightSpreads().of_pixels;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    SetLanesOfTerms(corner, shading);
    SetLanesOfLevels(corner);
  }
}

void BoardFit::SetLanesOfTerms(int corner, const Eigen::Matrix2d& shading) {
  const CornerPlace& place = pixels_.place(corner);
  const int lane = pixels_.Lane(corner);
  const auto set = [&](int which, double value) {
    std::fill_n(model_lanes_.parameter_data(which) + lane, 4, static_cast<float>(value));
  };
  const Eigen::Matrix2d& by_pixel = place.board_by_pixel;
  const Eigen::Matrix2d lens = run_->model.blur_px * run_->model.blur_px * by_pixel * by_pixel.transpose();
  const Eigen::Vector2d way = by_pixel * run_->model.motion_px;
  TermCorner of_terms{.by_pixel = by_pixel,
                      .lens = lens,
                      .way = way * way.transpose() / 12,
                      .blur = lens,
                      .shading = by_pixel * shading * by_pixel.transpose(),
                      .size = run_->view.size,
                      .row = corner / (run_->view.size.cols - 1),
                      .col = corner % (run_->view.size.cols - 1)};
  Terms::ForEach([&]<class Term>() {
    const auto set_own = [&](int which, const auto& value) {
      if constexpr (std::is_same_v<decltype(value), const PhaseValues&>)
        std::copy_n(value.data(), 4, model_lanes_.parameter_data(ModelLanes::Of<Term>(which)) + lane);
      else
        set(ModelLanes::Of<Term>(which), value);
    };
    if constexpr (Term::kLanes > 0)
      if (run_->model_input.terms.on<Term>()) run_->model.Term::SetLanes(run_->model_input, of_terms, set_own);
  });
  const Eigen::Matrix2d& blur = of_terms.blur;
  for (int axis = 0; axis < 2; ++axis) {
    const double variance = blur(axis, axis);
    set(ModelLanes::kScaleX + axis, 1 / std::sqrt(variance));
    set(ModelLanes::kBlurX + axis, lens(axis, axis) / variance / run_->model.blur_px);
  }
  const Eigen::Vector2d printed = Printed(corner);
  set(ModelLanes::kCornerX, printed.x());
  set(ModelLanes::kCornerY, printed.y());
  set(ModelLanes::kCovariance, blur(0, 1));
  const bool skewed = lens(0, 1) * lens(0, 1) > kSkewed * kSkewed * lens(0, 0) * lens(1, 1);
  set(ModelLanes::kSkew, skewed ? blur(0, 1) : 0);
  set(ModelLanes::kSkewByBlur, skewed ? 2 * lens(0, 1) / run_->model.blur_px : 0);
  set(ModelLanes::kByPixelXx, by_pixel(0, 0));
  set(ModelLanes::kByPixelXy, by_pixel(0, 1));
  set(ModelLanes::kByPixelYx, by_pixel(1, 0));
  set(ModelLanes::kByPixelYy, by_pixel(1, 1));
  for (int axis = 0; axis < 2; ++axis) {
    const WindowEnds ends = run_->light.fades ? EndsOf(corner, axis) : WindowEnds{};
    set(ModelLanes::kFadeX + axis, ends.slope);
    set(ModelLanes::kMiddleX + axis, ends.middle());
    set(ModelLanes::kPeakX + axis, ends.peak());
  }
}

void BoardFit::SetLanesOfLevels(int corner) {
  const int lane = pixels_.Lane(corner), cols = run_->view.size.cols + 2;
  const int row = corner / (run_->view.size.cols - 1), col = corner % (run_->view.size.cols - 1);
  const bool by_yellow = MayBeOutOfRegister() && run_->inks.beside_yellow[static_cast<std::size_t>(corner)];
  for (std::size_t phase = 0; phase < 4; ++phase) {
    const std::size_t channel = static_cast<std::size_t>(run_->view.channel_of_phase[phase]);
    const auto set = [&](int which, float value) {
      model_lanes_.parameter_data(which)[lane + static_cast<int>(phase)] = value;
    };
    set(ModelLanes::kNoiseFloor,
        run_->model.noise.floor[channel] + (by_yellow ? run_->inks.yellow_variance[phase] : 0));
    set(ModelLanes::kNoiseSlope, run_->model.noise.slope[channel]);
    for (int i = 0; i < ModelColumns::kLevels; ++i) {
      const int level = run_->around.levels[static_cast<std::size_t>(corner)][static_cast<std::size_t>(i)];
      set(ModelLanes::kLevel00 + i,
          level != ModelEquations::kNoLevel
              ? run_->model.levels[static_cast<std::size_t>(level)][phase]
              : run_->around.beside[static_cast<std::size_t>((row + i / 4) * cols + col + i % 4)][phase]);
    }
  }
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

bool BoardFit::StepModel(int stride, bool first) {
  if (!SolveModel(stride)) return false;
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
  run_->step.terms = 0;
  const ModelEquations::Shared information = model_equations_.information().diagonal();
  Terms::ForEach([&]<class Term>() {
    if (!run_->model_input.terms.on<Term>()) return;
    const int own = columns.of<Term>();
    const double counts =
        run_->model.Term::Move({step.data() + own, information.data() + own, run_->model.blur_px, BoardByPixel()});
    run_->step.terms = std::max(run_->step.terms, counts);
  });
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
    EvenOutShading(start);
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
    if (pass == 0 && all_known && run_->step.corner_px < kStillPx && run_->step.blur_share < kNearPx &&
        run_->step.terms <= 1) {
      run_->visibility.ShowCellsByAllCorners();
      EvenOutShading(start);
      break;
    }
    // Where others have told the motion too, a step that is not long leaves little.
    if (pass == 0 && motion_known && run_->step.corner_px < kNearMovedPx && run_->step.blur_share < kNearMovedBlur &&
        run_->step.terms <= kNearMovedTerms)
      break;
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
  const bool elsewhere = FarthestMove(run_->light.collected_for) > kCollectAnewPx ||
                         (run_->model.motion_px - run_->light.collected_for_motion).norm() > kCollectAnewMotionPx;
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
      if (!start.TellsNoise() || !TellGainOfModel(lens)) break;
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
