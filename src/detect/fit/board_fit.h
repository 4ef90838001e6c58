#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "detect/common/board_geometry.h"
#include "detect/common/light.h"
#include "detect/common/scratch.h"
#include "detect/common/work_meter.h"
#include "detect/fit/bent_paper.h"
#include "detect/fit/board_equations.h"
#include "detect/fit/board_pixels.h"
#include "detect/fit/board_run.h"
#include "detect/fit/edge_noise.h"
#include "detect/fit/edge_spread.h"
#include "detect/fit/fitted_board.h"
#include "detect/fit/learnt_levels.h"
#include "detect/fit/model_equations.h"
#include "detect/fit/model_kernel.h"
#include "detect/fit/shading.h"
#include "detect/fit/shadow_edge.h"

namespace chequer {

/// One joint fit of geometry, cell levels (free for every cell and channel), blur and noise of a board to its pixels,
/// by Gauss-Newton on the model of photometric_kernel.h (which Krüger and Yang have corner by corner). What to make of
/// its result, and which other fits to try, is PhotometricFit's. Keeps its memory.
class BoardFit {
 public:
  struct Start {
    MarkerSize size;
    double cell_ratio = 1;  ///< of a cell as printed, height over width
    BoardGeometry geometry;
    double blur_px = 0.8;
    /// Light (R, G, B) and saturation of each cell as far as known before the fit, row by row.
    std::span<const Eigen::Vector3f> light;
    std::span<const std::uint8_t> saturated;
    /// Corners that are hidden in it are left out, and those of hidden cells.
    Visibility visibility{};
    /// Corners that were found; the geometry may have others pixels off.
    CornerFlags found{};
    /// The geometry is a prediction's, off by a part of a pixel or several, not that of corners that were found, which
    /// is right to about 0.1 px.
    bool predicted = false;
    /// The last frame's prediction was off by little more than its own errors: so, it is thought, is this one.
    bool near = false;
    /// How far the blue ink may lie off the black one, along the board's axes, cells: standard deviations. Where they
    /// are not zero, that is fitted too.
    Eigen::Vector2d register_cells = Eigen::Vector2d::Zero();
    /// It may turn while a rolling shutter reads its rows, which bends its edges: whether its paper bends is not asked.
    bool turns_over_rows = false;
    /// Of the board's blur in the last frame, if it was known then.
    BlurShape blur_shape{};
    double own_blur_px = 0;      ///< in the last frame; 0: not known
    LightLevels light_levels{};  ///< in the last frame, if it was overexposed then
    /// What was told of the image, if anything was: saves a pass, and most of the first step.
    const ImageTraits* image = nullptr;
    /// By whom: another board of this image, another fit of this board, or a board of an earlier image.
    enum class TraitsFrom { kOtherBoard, kThisBoard, kEarlierImage } image_from = TraitsFrom::kOtherBoard;
    double dot_gain = 0;     ///< of prints, as they or earlier images have told, cells
    EdgeTally edge_tally{};  ///< of the boards of earlier images
    /// A fit with all terms that is not near its end once so many units (work_meter.h) were spent on the board fails.
    std::uint64_t most_units = ~0ull;

    /// Whether the board's pixels tell the noise anew, or dot gain.
    bool TellsNoise() const { return !image || image_from != TraitsFrom::kOtherBoard; }
    bool TellsGain() const { return !image || image_from == TraitsFrom::kThisBoard; }
    /// Whether this image's noise is known before.
    bool KnowsNoise() const { return image && image_from != TraitsFrom::kEarlierImage; }
  };
  /// Which model a fit has.
  struct Choice {
    /// Levels for each corner's quadrants, not the cells'.
    bool own_levels = false;
    /// Those that are on are fitted too, from here; none where quadrants have levels.
    Terms::States terms;
    /// Whether motion is tried if the board's blur seems to be a motion's.
    bool may_move = true;
    /// Whether the model with all its terms may be fitted where the four cells around a corner do not suffice.
    bool may_look_farther = true;
    /// Begins where that fit ended, not from what was sampled: few passes then do.
    const BoardRun* from = nullptr;
    /// The model with all its terms is fitted to some of the pixels only, which suffices to compare models.
    bool roughly = false;
    /// Steps that bring that model near.
    int most_steps_near = 8;
  };

  /// False if the board lies outside the image for the most part, does not look like the model, or the fit runs away;
  /// the result then means nothing, nor does what is told of corners.
  bool Fit(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice);
  /// Goes on from where a fit has ended: a plain one with the pixels that are chosen there, one with terms by all of
  /// its pixels. As Fit(). @pre run() is that of a fit that began with `start`.
  bool FitAnew(const LightReader& reader, const Lens& lens, const Start& start);
  /// Another step of the plain model, by pixels chosen anew. @pre !looks_farther().
  bool StepOn(const LightReader& reader, const Lens& lens, const Start& start);
  /// The same without the pixels beside hidden corners that may show what hides these.
  bool FitBesideHidden(const LightReader& reader, const Lens& lens, const Start& start);
  /// The same if the fit is rough.
  bool FitClosely(const LightReader& reader, const Lens& lens, const Start& start);
  /// Tells what the result explains by the pixels that the model with all its terms looks at, to compare them. Of large
  /// cells, these are fewer, most of them along edges: there, demosaicing, sharpening and JPEG leave more than in
  /// the middle of cells, and a fit by all pixels seems to explain a board better. The result is as it was else.
  void ExplainFew(const LightReader& reader, const Lens& lens, const Start& start);
  /// Whether the result is by some of the pixels.
  bool rough() const { return run_->terms.rough; }
  /// The first step to a dot gain, if one says that there is some. The fit is then no more what it was.
  /// @pre the last fit has a result.
  std::optional<double> FindDotGain(const LightReader& reader, const Lens& lens, const Start& start);

  /// Makes the result better by what earlier frames have shown of the board's levels, and adds what this one shows:
  /// where all of the board is in plain view, without terms, else `learnt` stays as it is. Whether the result rests on
  /// them. @param learnt empty at first. @pre the last fit has a result, and no other has begun.
  bool UseLearntLevels(LearntBoard& learnt);

  /// Whether a blur, px, of cells of so many px, is so wide that it may be a motion's.
  static bool MayBeMotion(double blur_px, double cell_px);

  const FittedBoard& result() const { return run_->result; }
  /// All that the last fit tells.
  const BoardRun& run() const { return *run_; }
  /// Tells what an earlier fit told.
  void Restore(const BoardRun& run) { *run_ = run; }
  /// Tells of the cells what an earlier fit told.
  void RestoreCells(const FittedBoard& earlier) {
    run_->result.levels = earlier.levels;
    run_->result.lit = earlier.lit;
    run_->result.visibility.TakeCellsOf(earlier.visibility);
  }

  int corners() const { return pixels_.corners(); }
  /// Neither outside the image, nor covered, nor left out.
  bool usable(int corner) const { return run_->MayUse(corner); }
  /// Usable, and not found occluded.
  bool used(int corner) const { return run_->visibility.ShowsCorner(corner); }
  /// Whether the plain model's last step was so long that it left more than it does where it has to end close.
  bool EndsRoughly() const;
  bool AnyUnused() const { return !run_->visibility.ShowsAllCorners(); }
  /// Whether a corner that is used lies beside one in the image that is not.
  bool AnyBesideHidden() const;
  /// The corners that were found occluded.
  CornerFlags Occluded() const;
  /// Of the corners that are used, those beside one that is not which fit worse than others: what hides that may lie on
  /// a part of their cells, too, and takes their edges along.
  CornerFlags Pulled() const;
  /// Sets FittedBoard::doubtful.
  void TellDoubt();
  /// Of a cell in the board's middle, along its side.
  double cell_px() const { return run_->told.cell_px; }
  /// Of a corner's pixels, variances; far off where it has none.
  double misfit(int corner) const { return run_->told.misfit[static_cast<std::size_t>(corner)]; }
  /// Of the usable corners after the last step, the most over the least.
  double misfit_spread() const { return run_->told.misfit_spread; }
  /// How much farther corners lie off the plane than the pixels' noise explains: their χ² over that of the pixels.
  double unexplained_shifts() const { return run_->told.unexplained_shifts; }
  /// Of the board's light cells, the parts around the corners that are used. @pre own levels were fitted.
  std::span<const LitPart> LitParts(std::span<const std::uint8_t> saturated);
  /// By the levels of cells that are not hidden, as they were fitted without one.
  std::optional<HighlightTerm> FindHighlight(std::span<const std::uint8_t> saturated,
                                             std::span<const Hidden> hidden) const;
  /// As it was fitted.
  const std::optional<ShadowEdge>& shadow() const { return run_->model.shadow; }
  /// Whether the four cells around a corner did not suffice (see model_kernel.h).
  bool looks_farther() const { return run_->terms.look_farther; }
  /// Whether they may not suffice.
  bool may_look_farther() const { return run_->terms.wide; }
  /// Forgets the work that was counted.
  void StartWork() { work_ = {}; }
  /// What the fits since then took.
  const WorkMeter& work() const { return work_; }
  /// Whether the motion explains so much that nothing else can.
  bool sure_of_motion() const { return run_->terms.sure_of_motion; }
  /// The way of a point during the exposure, image pixels; zero if that was not fitted.
  const Eigen::Vector2d& motion_px() const { return run_->model.motion_px; }
  /// Dot gain, cells, if that was fitted.
  double dot_gain() const { return run_->model.dot_gain; }

 private:
  bool Prepare(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice);
  /// The lens's blur, px, as others of the image show it, if this board's may be the same; else 0.
  double BlurOfImage(const Start& start) const;
  /// How much farther a motion reaches beyond a board's rim than its blur.
  double MotionReachPx() const;
  /// The pixels of the board as it lies by now. False if too few corners have some.
  /// @param may_reuse those there are, if they are the board's and nearly as good.
  bool Collect(const LightReader& reader, const Lens& lens, bool may_reuse = false);
  /// The same, once there are places and derivatives. What was evened out of the light is evened out anew.
  bool Recollect(const LightReader& reader, const Lens& lens, const Start& start);
  /// The first step of boards in plain view, until it has the pixels that are the board's. False if it runs away.
  bool ComeNear(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice);
  /// Whether there is no first step by some of the pixels: the first one by all is likely to be the last.
  bool BeginsNear(const Start& start) const;
  /// From where a board was predicted to where it lies, with the pixels that are chosen there. False if it runs away.
  bool LeavePrediction(const LightReader& reader, const Lens& lens, const Start& start, LaneSums sums);
  /// Where the first step runs away: by the pixels around the corners that were found alone, until those lie right,
  /// then by all. False if they run away too, or none are left out.
  bool ComeNearByFound(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice);
  void SetDerivatives();
  /// What the kernel is told of the corners' places, and of what changes with every step.
  void SetPlaces();
  /// Which neighbours of a corner along an axis lie in the image and are not used.
  struct HiddenNeighbours {
    bool before = false, after = false;
    bool any() const { return before || after; }
  };
  HiddenNeighbours HiddenBeside(int corner, int axis) const;
  bool LiesBesideHidden(int corner) const { return HiddenBeside(corner, 0).any() || HiddenBeside(corner, 1).any(); }
  /// Where the pixels of a corner end along an axis.
  WindowEnds EndsOf(int corner, int axis) const;
  /// Tells the plain kernel.
  void SetWindows();
  void SetLanes();
  /// Which the next steps are by: one in `stride` of all pixels, or of those of the corners spread over the board.
  void UsePixels(int stride, bool of_spread = false);
  /// Whether these are enough, and all are used.
  bool SpreadCornersSuffice() const;
  int PixelsOfStep() const;
  /// The kernel's sums of the pixels that are used. @pre lanes are set.
  void SumLanes();
  /// These, and the equations from them.
  void SumPlain();
  /// A step of Gauss-Newton by these sums of the kernel; by shapes alone, the cells' levels stay as they are.
  bool Step(LaneSums sums);
  /// The blur after a step, within what one may change.
  double BlurAfter(double step_px) const;
  void MoveBlur(double step_px);
  /// By what the last step's sums say of it. @param blur_px that they are of.
  void MoveBlurShape(double blur_px);
  /// The step only has to come near: it is by some of the pixels.
  bool ComesNear() const;
  /// What the last step's sums say of the blur at those that are used. @param blur_px that they are of.
  CornerBlurSums<CornerFour::Values> SumBlur(const CornerFour& four, float blur_px) const;
  /// Of that shape, with the corners as they were placed.
  BlurShapeFit FitOfShape(const BlurShape& shape) const;
  /// Of all corners in the image, by the last step.
  double FarthestStepPx() const;
  /// How far the last step moved the geometry: in standard deviations, squared, by the residuals that it leaves. The
  /// noise that is known so far may be a hundred times what they are.
  struct StepSize {
    double square = 0;
    double variances = 1;  ///< of the residuals, in units of that noise
  };
  /// How far moves lead, square of the deviations that pixels' noise gives the last step.
  double SquareOf(const BoardGeometry::Parameters& moves) const;
  StepSize SizeOfStep() const;
  /// The same of the model with all its terms.
  StepSize SizeOfModelStep() const;
  /// What the last step of the plain model leaves of a pixel's residual, squared, in units of the noise; 1 where
  /// that is not known.
  double LeftVariances() const;
  /// Square of the way, standard deviations, that the steps after the last one would lead. @param before the step
  /// before the last one; of no length: there was none.
  double SquareLeft(const StepSize& step, const StepSize& before) const;
  /// Whether the steps after the last one would move the pose by what counts against its standard deviations.
  /// @param most square, that does not.
  bool WhatIsLeftCounts(const StepSize& step, const StepSize& before, double most) const;
  /// Whether it goes on until next to nothing is left.
  bool FollowsClosely() const;
  /// A step of the plain model from the places where the last one has moved the corners. False if it runs away.
  /// @param shape_left the lanes follow the blur's shape where it has explained as much, variances.
  bool StepFromThere(const Lens& lens, LaneSums sums, bool first, double shape_left);
  /// Steps until nothing moves any more.
  /// @param anew it had settled before, by other pixels.
  bool Settle(const Lens& lens, const Start& start, bool noise_known, bool anew = false);
  /// Takes the dot gain of least squares, where that counts, with all else as it follows. Whether it is another than
  /// before. Changes the sums of the last step. PrepareGain() goes before.
  bool TellGain();
  /// Looks up what SolveGain() needs of what lies beside the board, if TellGain() will ask it.
  void PrepareGain(const LightReader& reader, const Lens& lens);
  /// The same by a step of the model with all terms, if that has none yet.
  bool TellGainOfModel(const Lens& lens);
  struct ToldGain {
    double cells = 0, information = 0;
  };
  /// Where a step of the model with all terms leads, which is not made. @pre around.beside is set.
  std::optional<ToldGain> SolveGain(int pixels);
  /// By what the plain model leaves with more and with less of it.
  std::optional<ToldGain> TryGains();
  /// Whether TryGains() is worth while. @pre the board is fitted without a gain.
  bool MayHaveGrown();
  /// On the dot gain, if the model's last step had one.
  double InformationOnGain() const;
  /// What counts of a gain by what it explains: nothing of one that noise may be, all of one that it is not.
  double GainThatCounts(double gain, double information) const;
  /// The dot gain, if the fit had none by chance.
  double GainForOthers() const;
  /// Σ w r² that a step of the plain model leaves with that dot gain, by some of the pixels.
  std::optional<double> LeftWithGain(double gain);
  /// The same with all else as it is.
  double LeftAtAGlance(double gain);
  /// What lanes are given for these.
  void SetLanesWithGain(double gain);
  /// Of a pixel's residual, where it tells the gain.
  double VarianceOfGain() const;
  /// Goes on with the pixels of the board as it lies by now.
  bool SettleAnew(const LightReader& reader, const Lens& lens, const Start& start);
  void Finish(const Lens& lens);
  /// Finishes, and fits on if the paper is bent.
  void FinishBent(const LightReader& reader, const Lens& lens, const Start& start);
  /// If the paper was found to be bent, fits on until the bend is found again as it was taken out.
  void FitBent(const LightReader& reader, const Lens& lens, const Start& start);
  /// Fits on by the pixels that show the board as it was found to be bent. False if it is not found to be so again.
  bool TakeOutBend(const LightReader& reader, const Lens& lens, const Start& start);
  /// Whether the corners' places can tell of a bend of the paper.
  bool TellsOfBend(const Lens& lens) const;
  /// The cells' levels follow where edges lie and hide a part of it: what share of a shift corners show, with the
  /// levels held as they are, in the mean.
  double ShareOfShiftsSeen() const;
  /// The corners' shifts as they are without that, for the result.
  void TellBendCorners(double pixel_variance);
  /// The bend of the paper if that explains where the corners lie.
  std::optional<BentPaper> FindBend(const Lens& lens) const;
  /// Σ of the robust weights at corners that are used, after the last step.
  double WeightUsed() const { return SumOfUsed(kWeight); }
  /// Any of the lanes' sums at these.
  double SumOfUsed(int which) const;
  /// What the pixels say of these groups of edges.
  EdgeTally TallyOf(std::array<AlikeEdges, 2>& edges, AlikePlaces* places);
  /// After the last step.
  void TellEdgeTally();
  /// What the covariance of the moves has beside the pixels' noise, for each unit of EdgeTally::MoreOf.
  BoardGeometry::Information CovarianceOf(const BoardGeometry::Information& in_pixels, const EdgeGroups& groups) const;
  /// Information on moves with that, as far as this board's edges and those of earlier images show such errors.
  BoardGeometry::Information CountAlongEdges(const BoardGeometry::Information& in_pixels,
                                             const BoardGeometry::Information& of_moves);
  /// The same with what corners share that lie alike and whose edges follow the pixels: a fit follows most of it.
  BoardGeometry::Information CountSharedByCorners(const BoardGeometry::Information& in_pixels,
                                                  const BoardGeometry::Information& of_moves) const;
  /// The same of other corners that lie alike, as far as this board's pixels show errors that all share.
  BoardGeometry::Information CountAlikeCorners(const BoardGeometry::Information& in_pixels,
                                               const BoardGeometry::Information& of_moves);
  /// After the last step. Tells the result what the pixels around each corner show, and how far those that fit lie from
  /// the model.
  void SumPixels();
  /// Of the corners that tell of shifts of their own.
  struct ShiftSums {
    double square_px = 0, chi_square = 0, contrast = 0;
  };
  ShiftSums TellShifts();
  /// Of the result's geometry, which a bend puts right. @param in_pixels on moves of the geometry. @param variance of
  /// what the corners' pixels are worth.
  void TellInformation(const BoardGeometry::Information& in_pixels, double variance);
  /// In the board's middle. @{
  double CellPx() const { return pixels_.middle().CellPx(); }
  const Eigen::Matrix2d& BoardByPixel() const { return pixels_.middle().board_by_pixel; }
  /// @}
  /// Of a cell, the share that others do not grow into from both sides.
  double FreeOfGain() const { return 1 - 2 * std::abs(run_->model.dot_gain); }
  double MisfitOf(int corner) const;
  /// Information on moves of the geometry, all else following, in units of what pixels are worth.
  BoardGeometry::Information InformationOnMoves() const;
  BoardEquations::Input PlainEquations() const;
  /// By the last step, as ShiftOf() tells them, where the plain model is fitted.
  void FindPlainShifts();
  /// What a corner's pixels say of a shift of its own beyond the last step.
  ModelEquations::CornerShift ShiftOf(int corner) const;
  /// Where it is seen.
  SeenCorner SeenAt(const ShiftedCorner& corner) const;
  /// The noise that the last step's sums show.
  void ReadNoise();
  /// Whether the image's edges are no Gaussian's: from here on, they are fitted as they are.
  bool TellEdges();
  /// What an image's first board may still tell of it: a dot gain, so often, and its edges.
  struct TraitsToTell {
    int gains = 0;
    bool edges = false;
  };
  /// Finishes, and takes the next of these where the board shows it. Whether one was taken, with which the fit goes on.
  bool TellTraits(const Lens& lens, const Start& start, TraitsToTell& untold);
  /// Of the last step, in board coordinates.
  Eigen::Vector2d MoveOf(int corner) const;
  /// Of a corner, since the geometry was that one, px.
  double FarthestMove(const BoardGeometry& from) const;

  // Levels: board_fit_levels.cpp.
  QuadrantLevels LevelsOf(int corner) const { return LevelsAround(run_->view.size, corner, run_->model.own_levels); }
  /// Gives sampled levels the contrast that the motion took.
  void SharpenLevels();
  /// Whether a predicted board begins with the motion that others of the image have told.
  bool KnowsMotion(const Start& start) const { return start.predicted && start.image && run_->model.MotionTerm::on(); }
  /// Steps of the plain model towards a predicted board whose motion is known, which is as a blur to it: they take a
  /// third of those of the model with all terms.
  void FollowMotion(const Lens& lens);
  void StartLevels(const LightReader& reader, const Start& start);
  /// Levels above full scale, as the last frame had them.
  void StartLightLevels(const Start& start);
  /// Whether light cells begin at full scale, as nothing is known of what lies above it.
  bool BeginsAtFullScale(const Start& start) const { return run_->view.overexposed && !start.light_levels.known(); }
  /// Goes on with all terms, if it may.
  bool LookFarther(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice);
  /// Whether a plain fit ended so far from where its pixels were chosen that others are the board's.
  bool LiesOffItsPixels() const;
  /// Whether a plain fit of large cells has a way that is long for its lens.
  bool FollowsLongWay() const;
  /// Whether a plain fit that has settled, or followed a long way, shows a motion, or so wide a blur, that it did not
  /// show at first.
  bool NeedsTermsAfterAll(const Start& start) const;
  /// Starts from another fit of the board.
  void StartFrom(const BoardRun& run);
  /// Sums of two quadrants' levels each, in the channel that tells light from dark cells best, has most pixels, and
  /// where yellow is nearly white.
  struct QuadrantLight {
    double light, dark;
  };
  QuadrantLight LightAround(int corner) const;
  /// Between the light and the dark cells around a corner.
  double Contrast(int corner) const;
  /// By corner: the light of its light quadrants, over the mean of the corners that are used; 0 for others.
  using CornerLights = std::array<double, kMaxCorners>;
  CornerLights LightOnCorners() const;
  /// Of own levels, those of the cells and the light that falls on them.
  void EvenOutLevels();
  void TellLevels();
  /// Of a channel that most pixels have and in which yellow is nearly white.
  int TellingPhase() const { return run_->view.red_phase < 0 ? 0 : run_->view.red_phase ^ 1; }
  LightThere LightOn(int cell) const;

  // Corners that something hides: board_fit_occluded.cpp.
  /// The corners that are used and disagree with the model so many times more than the median one of them.
  CornerFlags OffBy(double ratio) const;
  /// By what was known of the board, and by which corners have pixels.
  void BeginVisibility(const Visibility& known);
  /// @param may_return corners that were found occluded may be found to be in view again. Whether anything changed.
  bool FindOccludedCorners(bool may_return = true);

  // Inks out of register: board_fit_inks.cpp.
  bool MayBeOutOfRegister() const { return !run_->inks.register_cells.isZero(); }
  /// Which of the corners' edges are the blue ink's, by the levels.
  void ShareInks(const Start& start);
  /// How far pixels beside yellow cells may be off: that ink lies elsewhere, too, but leaves gaps or none, which no
  /// offset of a corner is.
  void WeighYellow(const Start& start);
  InkRegister RegisterOfCorners() const;
  /// After a step, moves the blue ink where the corners have it, and the geometry as it follows.
  void MoveInks(const Start& start);
  /// A corner's own shift by that.
  Eigen::Vector2d ShiftByInks(int corner) const;
  /// Where a corner is thought to lie, board coordinates.
  Eigen::Vector2d Printed(int corner) const;
  /// Adds to the result what is not known of the inks. @param of_moves the information while there is no offset;
  /// returns what is left of it. @param variance of what the corners' pixels are worth.
  BoardGeometry::Information TellRegister(const BoardGeometry::Information& of_moves, double variance);

  // What frames of a stream have learnt: board_fit_learnt.cpp.
  /// Whether the last fit tells of all of the board's levels, without terms.
  bool ShowsLevels() const;
  /// By the sums of either model's last step; the upper triangle.
  LevelProducts SumPlainProducts(const LearntBoard& learnt);
  LevelProducts SumModelProducts(const LearntBoard& learnt) const;

  // What is done to the pixels' light before they are fitted: board_fit_light.cpp.
  /// What cells' levels tell of a shading beside what was taken out before, if that counts; tells of the veil over it.
  std::optional<Shading> ShadingOfLevels(const Start& start, LevelsFrom from);
  /// Takes that out of the pixels, and leaves the veil in. Where terms of the light are on, ShadingTerm and VeilTerm
  /// have them. Returns what was taken out now.
  std::optional<Shading> EvenOutShading(const Start& start, LevelsFrom from = LevelsFrom::kFit);
  /// Whether what was taken out of the pixels is the shading that the levels tell by now; if not, it is from here on.
  /// @param variances that pixels leave.
  bool ShadingHolds(const Start& start, double variances, LevelsFrom from = LevelsFrom::kFit);
  /// Of the plain fit: takes back the one that was told from cells which turn out to be occluded, and evens out what
  /// the others tell.
  void FollowShading(const Lens& lens, const Start& start);
  /// Levels as the image has them, for pixels as the image has them. Whether anything had been evened out.
  bool TakeBackShading();
  /// The same for the plain fit's pixels.
  bool TakeBackFromPixels(const Lens& lens);
  /// How far shading moves the light of pixels: the move is a covariance, plane units², times the gradient of log
  /// light. Blur counts where it blurs what is already shaded. The image does not show whether it does in two cases,
  /// of which half counts each, and that half is the uncertainty:
  /// - motion: it counts if the camera moved, but not if a robot drove through light that stands still;
  /// - across the rows: the lens counts if the scene is shaded, but not if lamps flicker over a rolling shutter, whose
  ///   rows are brighter or darker by what light they are exposed to.
  struct SpreadOfLight {
    Eigen::Matrix2d of_pixels = Eigen::Matrix2d::Zero();
    std::array<Eigen::Matrix2d, 2> uncertain = {Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  };
  SpreadOfLight HowLightSpreads() const;
  /// Each column is a way by which what is not known of that may have moved the board; one standard deviation.
  Eigen::Matrix<double, BoardGeometry::kParameters, 2> MovedByShading() const;
  /// The same of a shadow's edge that the motion may have blurred or not. @param in_pixels on moves of the geometry.
  BoardGeometry::Parameters MovedByShadow(const BoardGeometry::Information& in_pixels) const;
  /// As the lens blurs what is already shaded, more light comes to a pixel from its lighter side: it shows what lies
  /// σ² ∇log(light) away, by the blur and the motion as they are known by now.
  void MovePixelsByLight();
  /// Takes a bent shading out of each pixel.
  void EvenOutPixels(const Shading& shading);
  double LightAt(int corner) const;

  // The model with all its terms: board_fit_model.cpp, and what it is given: board_fit_model_lanes.cpp.
  /// Whether the lens blurs light of more than the four cells around a corner into its pixels.
  /// @param image_blur_px BlurOfImage().
  bool BlursWidely(double image_blur_px) const;
  /// The light around the board's rim.
  void LookBeside(const LightReader& reader, const Lens& lens);
  void MapLevels();
  void SetModelInput(int stride);
  void SetModelLanes();
  /// @param shading how far shading moves the light of pixels (SpreadOfLight::of_pixels).
  void SetLanesOfTerms(int corner, const Eigen::Matrix2d& shading);
  /// A value that the four phases of a corner share.
  void SetModelLane(int corner, int which, double value);
  /// @param lens,blur the lens's share of the covariance of the blur, and all of it, board coordinates.
  void SetLanesOfBlur(int corner, const Eigen::Matrix2d& lens, const Eigen::Matrix2d& blur);
  void SetLanesOfLevels(int corner);
  ModelEquations::Input EquationsOfModel() const;
  /// A step of Gauss-Newton that is not made yet.
  bool SolveModel(int stride);
  bool StepModel(int stride, bool first);
  /// Moves the terms, by as much as they may.
  void MoveTerms();
  /// Whether its blur is so wide that it may have moved.
  bool SeemsMoved() const;
  /// The same, or the plain model has found a motion's shape, or the blur is wider than that of others of the image.
  bool MayHaveMoved(const Start& start) const;
  /// Starts the fit of a motion where the blur is wider along one direction than across it, or of dot gain, where one
  /// of them explains more than noise can; of both, the one that explains more. A dot gain that is on stays as it is.
  /// Whether one does.
  bool FindTerms(int stride, const Start& start);
  /// Starts the fit of dot gain by the first step to it, which levels and blur had taken up a part of.
  void StartGain(double step, double start_blur_px);
  /// Every how many pixels to use about so many of them.
  int StrideFor(int pixels) const;
  /// Of the board, in all channels.
  bool SettleModel(const LightReader& reader, const Lens& lens, const Start& start, bool noise_known,
                   const Choice& choice);
  /// The pixels may be those of a run that was not gone back to. False if there are too few.
  bool HavePixels(const LightReader& reader, const Lens& lens, const Start& start);
  void SetTerms();
  /// Places them where the last step has moved the board.
  void FollowCorners(const Lens& lens);
  /// By some of the pixels, until the model is near.
  bool ComeNearModel(const Lens& lens, const Start& start, bool noise_known, int most_steps);
  /// By all.
  bool SettleModelByAll(const LightReader& reader, const Lens& lens, const Start& start);
  /// Whether the last step was so short that what does not fit is occluded, that it is near, that it is the last.
  bool Still() const;
  bool Near() const;
  /// @param before the step before, by the same pixels, if there was one: where steps shrink fast, both tell what is
  /// left.
  bool Settled(const BoardRun::Step& before) const;
  /// What follows a step that did not end the fit.
  void FollowLight(const Start& start, bool light_follows);
  /// Of pixels, before the last step, variances.
  double LeftByModel() const;
  /// By what the last step leaves.
  void TellNoise(const Start& start);
  /// The pixels of the board as it lies by now, and the light beside it.
  bool CollectAnew(const LightReader& reader, const Lens& lens, const Start& start);

  Scratch<BoardRun> run_;
  // Memory: what these hold is made anew whenever pixels are collected, and with every step.
  BoardPixels pixels_;
  std::array<CornerDerivative, kMaxCorners> derivatives_;
  BoardEquations equations_;
  std::array<BoardEquations::CornerShift, kMaxCorners> plain_shifts_;
  std::vector<ShiftedCorner> shifted_;
  BoardRun before_;  ///< a copy, before a fit goes on with a bend or by other pixels
  ModelLanes model_lanes_;
  ModelEquations model_equations_;
  EdgeProfiles profiles_;        ///< of the last shape of edges: the same shape has the same
  std::uint64_t pixels_of_ = 0;  ///< the run whose pixels these are
  // Of the board, over all its fits.
  WorkMeter work_;
};

}  // namespace chequer
