#include "chequer/detector.h"

#include <Eigen/Core>
#include <array>
#include <stdexcept>

#include "chequer/check.h"
#include "chequer/tone_curve.h"
#include "detect/board_fits.h"
#include "detect/board_poses.h"
#include "detect/board_search.h"
#include "detect/boards/boards.h"
#include "detect/expectations.h"
#include "detect/image_state.h"
#include "detect/pose/plane_pose.h"
#include "detect/region_choice.h"

namespace chequer {
namespace {

DetectorOptions WithUsualCalibration(DetectorOptions options) {
  if (options.camera && options.print_tolerance.any() && options.camera->covariance.isZero(0))
    options.camera->covariance = UsualLensCovariance(*options.camera);
  return options;
}

/// The table of the tone curve that was asked for last. It is kept from image to image, as a camera hardly ever changes
/// its curve, and depends on nothing but the curve.
class ToneTable {
 public:
  /// Light (0..1) of each 8-bit value. Valid until another curve is asked for.
  const std::array<float, 256>& Of(const ToneCurve& curve) {
    if (!(curve == curve_)) {
      table_ = curve.LinearTable();
      curve_ = curve;
    }
    return table_;
  }

 private:
  ToneCurve curve_ = ToneCurve::Srgb();
  std::array<float, 256> table_ = ToneCurve::Srgb().LinearTable();
};

}  // namespace

struct Detector::Impl {
  explicit Impl(DetectorOptions given)
      : options(WithUsualCalibration(std::move(given))),
        expected_boards(options),
        search(options),
        fits(options),
        budget(options.budget) {}

  /// @param stream null: an image for itself.
  void Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace, const StreamImage* stream);
  /// The steps: what a memory expects, what a search finds, what fits make of both.
  void FindBoards(const ImageJob& job, const StreamImage* stream);
  void SearchGivenUp(const ImageJob& job);
  /// What the camera measured of an image whose colours were interpolated.
  static void FindMosaic(const ImageJob& job);
  /// Of boards that were found twice, by groups of corners that did not hang together, keeps the one that is known
  /// better.
  void RefuseTwins(const ImageJob& job);
  /// Hands over the boards that are accepted.
  void WriteMarkers(const ImageJob& job, std::vector<MarkerPose>& markers) const;

  // The same for all images.
  const DetectorOptions options;
  // Begun anew with every image: a result depends on its image and the options alone.
  Scratch<ImageState> frame;
  ExpectedBoards expected_boards;
  BoardSearch search;
  BoardFits fits;
  Scratch<std::vector<SeenBoard>> seen;
  Scratch<std::vector<std::size_t>> twins;  ///< of them, those that were seen better elsewhere
  // Kept from one image to the next.
  Undone undone;             ///< with a budget
  ToneTable tone;            ///< the same curve has the same table
  std::uint64_t budget = 0;  ///< set from outside, for the images to come
};

void Detector::Impl::FindMosaic(const ImageJob& job) {
  // The boards' surroundings have the texture that tells.
  for (std::size_t i = 0; i < job.frame.boards.size() && i < 3; ++i) {
    const Eigen::Vector2d center = job.frame.boards[i].plane_from_board.col(2).hnormalized();
    const Eigen::Vector2d pixel = job.lens.ToImage(center);
    const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
    if (const auto mosaic = FindInterpolatedMosaic(job.image, job.table, x - 16, y - 8, x + 15, y + 7)) {
      job.measured.SetMosaic(*mosaic);
      return;
    }
  }
}

void Detector::Impl::RefuseTwins(const ImageJob& job) {
  seen.Start();
  twins.Start();
  for (std::size_t i = 0; i < frame->outcomes.size(); ++i)
    if (const MarkerPose& marker = frame->outcomes[i].marker; frame->outcomes[i].accepted)
      seen->push_back({i, marker.center_px, frame->boards[i].box, frame->boards[i].size,
                       frame->outcomes[i].plane_from_board, marker.id.has_value(), marker.corners_used,
                       marker.reprojection_rms_px});
  TakeOutTwins(*seen, *twins);
  for (const std::size_t i : *twins) {
    frame->outcomes[i].accepted = false;
    job.tracer.Refuse(i, Refusal::kSeenTwice);
  }
}

void Detector::Impl::WriteMarkers(const ImageJob& job, std::vector<MarkerPose>& markers) const {
  DetectStats& stats = job.frame.stats;
  stats.boards = static_cast<int>(frame->boards.size());
  for (std::size_t i = 0; i < frame->outcomes.size(); ++i) {
    const BoardOutcome& outcome = frame->outcomes[i];
    stats.refused_fit += !outcome.accepted && !outcome.deferred;
    if (!outcome.accepted) continue;
    stats.undecided += !outcome.marker.id;
    job.tracer.Accept(i, static_cast<int>(markers.size()));
    markers.push_back(outcome.marker);
  }
}

void Detector::Impl::SearchGivenUp(const ImageJob& job) {
  if (!ChooseGivenUp(job)) return;
  const std::size_t known = frame->boards.size();
  for (const SearchRegion& region : frame->given_up.regions()) search.Search(job, region);
  fits.FitFrom(job, known);
  fits.Refine(job);
}

void Detector::Impl::FindBoards(const ImageJob& job, const StreamImage* stream) {
  if (stream) {
    ExpectBoards(job, *stream);
    // It may have forgotten what it knew.
    frame->dot_gain = stream->memory.dot_gain;
    frame->edge_tally = stream->memory.edge_tally;
    if (!frame->stream.IsKnocked()) frame->known_traits = stream->memory.TraitsAhead(frame->stream.frames_on);
  }
  const std::size_t expected = frame->expected.size();
  if (expected > 0) {
    job.tracer.Anchored(frame->boards, job.lens, options.color_space);
    FindMosaic(job);
    fits.FitFrom(job, 0);
    JudgeExpected(job, *stream);
  }
  frame->plan.StartSearch(frame->work.units());
  ChooseRegions(job, stream ? &stream->memory : nullptr);
  for (const SearchRegion& region : frame->regions.regions()) search.Search(job, region);
  if (expected == 0) FindMosaic(job);
  fits.FitFrom(job, expected);
  fits.FitPostponed(job);
  if (frame->plan.limited()) {
    fits.Refine(job);
    SearchGivenUp(job);
  }
  job.tracer.EndSearch();
  if (stream) DecideExpected(job, *stream);
  RefuseTwins(job);
  DescribePoses(*frame);
}

void Detector::Impl::Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace,
                            const StreamImage* stream) {
  Tracer tracer(trace);
  markers.clear();
  frame.Start().plan = WorkPlan(budget);
  if (image.width() < kLeastSide || image.height() < kLeastSide) return;
  search.Start();
  fits.Start();
  if (!frame->plan.limited()) undone = {};
  frame->work.Add(WorkStep::kFrame);
  frame->regions.Start(image.width(), image.height());
  frame->known.Start(image.width(), image.height());
  const bool knows_curve = options.camera && options.camera->tone_curve;
  const std::array<float, 256>& table = tone.Of(knows_curve ? *options.camera->tone_curve : image.tone_curve());
  const LightReader reader(image, table);
  LightReader measured(image, table);
  const bool calibrated =
      options.camera && options.camera->width == image.width() && options.camera->height == image.height();
  const Lens lens = calibrated ? Lens(*options.camera) : Lens();
  const ImageJob job{options, image, table, reader, measured, lens, tracer, *frame, undone, expected_boards};

  FindBoards(job, stream);
  WriteMarkers(job, markers);
  if (stream) {
    TraceExpectations(job, *stream);
    Remember(job, *stream);
  }
  undone.grids.EndImage();
  undone.boards.EndImage();
  frame->stats.work = frame->work.units();
}

Detector::Detector(DetectorOptions options) {
  if (const std::string error = options.Check(); !error.empty()) throw std::runtime_error(error);
  impl_ = std::make_unique<Impl>(std::move(options));
}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<MarkerPose> Detector::Detect(const ImageView& image) {
  std::vector<MarkerPose> markers;
  impl_->Detect(image, markers, nullptr, nullptr);
  return markers;
}

void Detector::Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace) {
  impl_->Detect(image, markers, trace, nullptr);
}

void Detector::Detect(const ImageView& image, std::chrono::nanoseconds captured, DetectorMemory& memory,
                      std::vector<MarkerPose>& markers, DetectTrace* trace) {
  const StreamImage stream{captured, memory.state()};
  impl_->Detect(image, markers, trace, &stream);
}

void Detector::set_budget(std::uint64_t units) {
  CHEQUER_CHECK(units == 0 || units >= kLeastBudget, "the budget is too small for any image");
  impl_->budget = units;
}

const DetectStats& Detector::stats() const { return impl_->frame->stats; }
const DetectorOptions& Detector::options() const { return impl_->options; }

}  // namespace chequer
