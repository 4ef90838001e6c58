#include "chequer/detector.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "detect/anchor.h"
#include "detect/board_geometry.h"
#include "detect/corners.h"
#include "detect/crew.h"
#include "detect/fit.h"
#include "detect/grids.h"
#include "detect/identify.h"
#include "detect/light.h"
#include "detect/plane_pose.h"
#include "detect/second_look.h"
#include "detect/tracer.h"
#include "detect/twins.h"

namespace chequer {
namespace {

/// Warn of an ambiguous pose above this probability.
constexpr double kAmbiguous = 0.001;
/// Below this probability, the other pose adds nothing to the covariance.
constexpr double kNeverTheOther = 1e-6;
/// Least contrast of a board over the noise of a pixel.
constexpr double kLeastSignal = 2.5;

/// Share of the contrast of boards that were found that others have at least.
constexpr float kShareOfContrast = 0.4f;

/// Corners of boards lie where they should to 0.15 px even with 8 px of motion blur.
constexpr double kMostDeviationPx = 0.5;

/// Whether the middle of a board lies on another.
bool LiesOn(const AnchoredBoard& board, const AnchoredBoard& other) {
  const Eigen::Vector2d at = (other.plane_from_board.inverse() * board.plane_from_board.col(2)).hnormalized();
  return std::abs(at.x()) < 0.5 * other.size.cols && std::abs(at.y()) < 0.5 * other.size.rows;
}

/// Of a board's corners, those that were found.
std::ptrdiff_t Found(const AnchoredBoard& board) { return std::count(board.found.begin(), board.found.end(), true); }

std::vector<BorderPattern> PatternsOf(const DetectorOptions& options) {
  std::vector<BorderPattern> patterns;
  for (const MarkerFamily& family : options.families) {
    const MarkerSize size = family.code.size();
    if (std::none_of(patterns.begin(), patterns.end(), [&](const BorderPattern& p) { return p.size == size; }))
      patterns.emplace_back(size);
  }
  return patterns;
}

void Set(MarkerPose& marker, Warning warning) { marker.warnings |= static_cast<std::uint32_t>(warning); }

}  // namespace

std::string_view WarningName(Warning warning) {
  switch (warning) {
    case Warning::kIdUndecided: return "id_undecided";
    case Warning::kPoorIllumination: return "poor_illumination";
    case Warning::kPoorWhiteBalance: return "poor_white_balance";
    case Warning::kPartlyHidden: return "partly_hidden";
    case Warning::kAmbiguous: return "ambiguous_pose";
  }
  return "";
}

std::string DetectorOptions::Check() const {
  if (families.empty()) return "no marker family: at least one size, variant and side must be given";
  for (const MarkerFamily& family : families)
    if (camera && !(family.side_m > 0 && family.side_m < 100))
      return "marker side " + std::to_string(family.side_m) + " m: must be above 0 and below 100 m";
  if (!(max_luminance_overlap >= 0 && max_luminance_overlap <= 0.5))
    return "max_luminance_overlap: must be from 0 to 0.5";
  if (!(max_saturation_overlap >= 0 && max_saturation_overlap <= 0.5))
    return "max_saturation_overlap: must be from 0 to 0.5";
  if (threads < 1 || threads > 64) return "threads: must be from 1 to 64";
  return "";
}

struct Detector::Impl {
  explicit Impl(DetectorOptions given)
      : options(std::move(given)), finder(PatternsOf(options), options.color_space), crew(options.threads) {
    for (int worker = 0; worker < crew.workers(); ++worker) workers.emplace_back(options);
  }

  void Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace);
  void FindBoards(const LightReader& reader, const Lens& lens, Tracer& tracer);
  void LookAgain(const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// What a look has shown, another may show again, from what is left around it or more clearly: of boards from `known`
  /// on, those that are not new take the place of the others or are forgotten.
  void KeepBetter(std::size_t known, Tracer& tracer);
  /// Of boards that were found twice, by groups of corners that did not hang together, keeps the one that is known
  /// better.
  void RefuseTwins(Tracer& tracer);
  void FindMosaic(const ImageView& image, const Lens& lens, LightReader& reader) const;
  void Describe(const FittedBoard& fitted, const AnchoredBoard& board, const Identity& identity, const Lens& lens,
                MarkerPose& marker) const;
  void DescribePose(const std::array<PlanePose, 2>& poses, MarkerPose& marker) const;

  /// What one thread needs for itself.
  struct Worker {
    explicit Worker(const DetectorOptions& options) : identifier(options) {}
    PhotometricFit fit;
    Identifier identifier;
  };
  /// What became of a board.
  struct Outcome {
    bool accepted = false;
    ImageTraits image;
    MarkerPose marker;
  };
  Outcome Measure(const LightReader& reader, const Lens& lens, std::size_t index, const ImageTraits* image,
                  Worker& worker, Tracer& tracer) const;

  DetectorOptions options;
  DetectStats stats;
  Pyramid pyramid;
  std::vector<Corner> corners;
  GridLinker linker;
  Grids grids;
  BoardFinder finder;
  SecondLook second_look;
  std::vector<StrongPoint> strong;
  std::vector<PixelBox> found_in;
  std::vector<AnchoredBoard> boards;
  Crew crew;
  std::vector<Worker> workers;
  std::vector<Outcome> outcomes;
  std::vector<SeenBoard> seen;
  std::vector<std::size_t> twins;  ///< of them, those that were seen better elsewhere
  ToneCurve table_curve = ToneCurve::Srgb();
  std::array<float, 256> table = ToneCurve::Srgb().LinearTable();
};

void Detector::Impl::FindMosaic(const ImageView& image, const Lens& lens, LightReader& reader) const {
  // The boards' surroundings have the texture that tells.
  for (std::size_t i = 0; i < boards.size() && i < 3; ++i) {
    const Eigen::Vector2d center = (boards[i].plane_from_board * Eigen::Vector3d(0, 0, 1)).hnormalized();
    const Eigen::Vector2d pixel = lens.ToImage(center);
    const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
    if (const auto mosaic = FindInterpolatedMosaic(image, table, x - 16, y - 8, x + 15, y + 7)) {
      reader.SetMosaic(*mosaic);
      return;
    }
  }
}

void Detector::Impl::DescribePose(const std::array<PlanePose, 2>& poses, MarkerPose& marker) const {
  const auto& [pose, other] = poses;
  marker.has_pose = true;
  marker.camera_from_marker = CameraFromMarker(pose.camera_from_board);
  marker.camera_from_marker.rotation = Canonical(marker.camera_from_marker.rotation);
  marker.covariance = pose.covariance;
  // Both poses are as likely before the image is seen.
  marker.ambiguity = 1 / (1 + std::exp(std::min((other.chi_square - pose.chi_square) / 2, 100.0)));
  // Where both minima are one, nothing is ambiguous: the covariance tells the whole story.
  const double apart = (pose.camera_from_board.rotation.inverse() * other.camera_from_board.rotation)
                           .angularDistance(Eigen::Quaterniond::Identity());
  if (apart < 3 * std::sqrt(std::max(pose.covariance(3, 3), pose.covariance(4, 4)))) marker.ambiguity = 0;
  if (marker.ambiguity > kAmbiguous) Set(marker, Warning::kAmbiguous);
  if (marker.ambiguity < kNeverTheOther) return;
  // That it may be the other pose is a part of the error.
  Eigen::Matrix<double, 6, 1> to_other;
  to_other << other.camera_from_board.translation - pose.camera_from_board.translation,
      VectorFromRotation((other.camera_from_board.rotation * pose.camera_from_board.rotation.conjugate()).normalized());
  marker.covariance += marker.ambiguity * to_other * to_other.transpose();
}

void Detector::Impl::Describe(const FittedBoard& fitted, const AnchoredBoard& board, const Identity& identity,
                              const Lens& lens, MarkerPose& marker) const {
  marker = MarkerPose{};
  const MarkerFamily& family = options.families[static_cast<std::size_t>(identity.family)];
  marker.family = identity.family;
  marker.variant = family.code.variant();
  marker.size = board.size;
  marker.luminance_overlap = identity.luminance_overlap;
  marker.saturation_overlap = identity.saturation_overlap;
  if (identity.luminance_overlap > options.max_luminance_overlap) Set(marker, Warning::kPoorIllumination);
  if (identity.saturation_overlap > options.max_saturation_overlap) Set(marker, Warning::kPoorWhiteBalance);
  if (identity.id_decided) {
    marker.id = identity.decoded->id;
    marker.bits_corrected = identity.decoded->bits_corrected;
  } else {
    Set(marker, Warning::kIdUndecided);
  }
  marker.corners_used = fitted.corners_used;
  marker.reprojection_rms_px = fitted.reprojection_rms_px;
  if (identity.cells_hidden > 0 || fitted.corners_used < CornerCount(board.size)) Set(marker, Warning::kPartlyHidden);
  marker.corners.fill(Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
  for (int i = 0; i < CornerCount(board.size); ++i)
    if (fitted.corner_used[static_cast<std::size_t>(i)])
      marker.corners[static_cast<std::size_t>(i)] =
          lens.ToImage(fitted.geometry.ToPlane(
                           CornerOnBoard(board.size, i / (board.size.cols - 1), i % (board.size.cols - 1))))
              .cast<float>();
  marker.center_px = lens.ToImage(fitted.geometry.ToPlane({0, 0}));
}

void Detector::Impl::FindBoards(const LightReader& reader, const Lens& lens, Tracer& tracer) {
  finder.Start(corners.size(), boards);
  // The largest first: what is left over of them makes no boards of its own.
  std::sort(grids.grids.begin(), grids.grids.end(), [](const Grid& a, const Grid& b) { return a.count > b.count; });
  const auto ask_for_grid = [&](std::size_t i) {
    PixelBox box;
    if (i >= grids.grids.size()) return;
    for (const LatticeCorner& at : grids.Of(grids.grids[i])) {
      const Eigen::Vector2f& position = corners[static_cast<std::size_t>(at.corner)].position;
      box.Add(position.x(), position.y());
    }
    box.Widen(0.3f);
    reader.Prefetch(box);
  };
  ask_for_grid(0);
  for (std::size_t i = 0; i < grids.grids.size(); ++i) {
    ask_for_grid(i + 1);
    const Grid& grid = grids.grids[i];
    finder.Trace(tracer.StartGrid());
    const bool found = finder.Find(grid, grids.Of(grid), corners, &linker.search(), reader, lens, boards);
    stats.refused_border += !found;
    tracer.EndGrid(grids.Of(grid), found);
  }
  LookAgain(reader, lens, tracer);
  stats.boards = static_cast<int>(boards.size());
  tracer.Anchored(boards, lens, options.color_space);
}

void Detector::Impl::LookAgain(const LightReader& reader, const Lens& lens, Tracer& tracer) {
  // Among boards, what matters has some of their contrast.
  float least = kStrongContrast;
  found_in.clear();
  for (const AnchoredBoard& board : boards) found_in.push_back(board.box);
  if (!boards.empty()) least = std::max(least, kShareOfContrast * finder.ContrastOf(corners));
  strong.assign(pyramid.strong.begin(), pyramid.strong.end());
  for (const Corner& corner : corners)
    if (corner.contrast >= least) strong.push_back({corner.position, corner.contrast});
  second_look.Start(reader, strong, least, found_in);
  second_look.Trace(tracer.places());
  while (second_look.Next(pyramid, reader)) {
    tracer.StartLook(second_look, boards.size());
    finder.StartCorners(second_look.corners().size());
    for (const Grid& grid : second_look.grids().grids) {
      const std::size_t known = boards.size();
      const auto members = second_look.grids().Of(grid);
      finder.Trace(tracer.StartGrid());
      const bool found = finder.Find(grid, members, second_look.corners(), nullptr, reader, lens, boards);
      for (std::size_t i = known; i < boards.size(); ++i) boards[i].smeared = second_look.smeared();
      tracer.EndGrid(members, found);
      KeepBetter(known, tracer);
    }
    tracer.EndLook(boards.size());
  }
}

void Detector::Impl::KeepBetter(std::size_t known, Tracer& tracer) {
  for (std::size_t i = known; i < boards.size();) {
    std::size_t same = 0;
    while (same < known && !LiesOn(boards[i], boards[same])) ++same;
    if (same == known) {
      ++i;
      continue;
    }
    if (Found(boards[i]) > Found(boards[same])) {
      std::swap(boards[i], boards[same]);
      tracer.Replace(same);
    }
    boards.erase(boards.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void Detector::Impl::RefuseTwins(Tracer& tracer) {
  seen.clear();
  twins.clear();
  for (std::size_t i = 0; i < outcomes.size(); ++i)
    if (const MarkerPose& marker = outcomes[i].marker; outcomes[i].accepted)
      seen.push_back(
          {i, marker.center_px, boards[i].box, marker.id.has_value(), marker.corners_used, marker.reprojection_rms_px});
  TakeOutTwins(seen, twins);
  for (const std::size_t i : twins) {
    outcomes[i].accepted = false;
    tracer.Refuse(i, Refusal::kSeenTwice, 0, 0);
  }
}

void Detector::Impl::Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace) {
  Tracer tracer(trace);
  markers.clear();
  stats = DetectStats{};
  if (image.width() < 16 || image.height() < 16) return;
  if (!(image.tone_curve() == table_curve)) {
    table_curve = image.tone_curve();
    table = table_curve.LinearTable();
  }
  LightReader reader(image, table);
  const bool calibrated =
      options.camera && options.camera->width == image.width() && options.camera->height == image.height();
  const Lens lens = calibrated ? Lens(*options.camera) : Lens();

  stats.corner_candidates = FindCorners(image, pyramid, corners, tracer.refused_peaks());
  linker.Link(pyramid.base, corners, grids);
  stats.corners = static_cast<int>(corners.size());
  stats.grids = static_cast<int>(grids.grids.size());
  tracer.Linked(corners, linker, grids);

  FindBoards(reader, lens, tracer);
  FindMosaic(image, lens, reader);

  // The noise is the camera's, and mostly the blur: the first board that is one tells it for all.
  outcomes.resize(boards.size());
  std::size_t first = 0;
  for (bool known = false; first < boards.size() && !known; ++first) {
    outcomes[first] = Measure(reader, lens, first, nullptr, workers[0], tracer);
    known = outcomes[first].accepted;
  }
  const ImageTraits* traits = first > 0 ? &outcomes[first - 1].image : nullptr;
  const auto measure = [&](int item, int worker) {
    const std::size_t i = first + static_cast<std::size_t>(item), later = i + workers.size();
    if (later < boards.size()) reader.Prefetch(boards[later].box);
    outcomes[i] = Measure(reader, lens, i, traits, workers[static_cast<std::size_t>(worker)], tracer);
  };
  // By reference: a copy would be allocated.
  crew.Run(static_cast<int>(boards.size() - first), std::ref(measure));
  RefuseTwins(tracer);
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const Outcome& outcome = outcomes[i];
    if (!outcome.accepted) {
      ++stats.refused_fit;
      continue;
    }
    stats.undecided += !outcome.marker.id;
    tracer.Accept(i, static_cast<int>(markers.size()));
    markers.push_back(outcome.marker);
  }
}

Detector::Impl::Outcome Detector::Impl::Measure(const LightReader& reader, const Lens& lens, std::size_t index,
                                                const ImageTraits* image, Worker& worker, Tracer& tracer) const {
  const AnchoredBoard& board = boards[index];
  Outcome outcome;
  const auto refuse = [&](Refusal why, double measured = 0, double required = 0) {
    tracer.Refuse(index, why, measured, required);
    return outcome;
  };
  const FittedBoard* fitted = worker.fit.Fit(reader, lens,
                                             {.board = {.size = board.size,
                                                        .geometry = BoardGeometry(board.plane_from_board),
                                                        .blur_px = 0.8 * board.scale,
                                                        .light = board.light,
                                                        .saturated = board.saturated,
                                                        .covered = board.covered,
                                                        .found = board.found,
                                                        .image = image},
                                              .smeared = board.smeared,
                                              // One in an image: a swarm that moves has to be done in time.
                                              .may_be_smeared = index == 0});
  if (!fitted) return refuse(Refusal::kNoFit);
  if (fitted->signal_to_noise < kLeastSignal) return refuse(Refusal::kNoise, fitted->signal_to_noise, kLeastSignal);
  if (fitted->reprojection_rms_px > kMostDeviationPx)
    return refuse(Refusal::kCornersOff, fitted->reprojection_rms_px, kMostDeviationPx);
  const Identity identity = worker.identifier.Identify(*fitted, board.size, reader, lens);
  tracer.Read(index, *fitted, identity, worker.identifier, lens);
  if (!identity.plausible) return refuse(Refusal::kCellsHidden);
  std::optional<std::array<PlanePose, 2>> poses;
  const double side_m = options.families[static_cast<std::size_t>(identity.family)].side_m;
  const double cell_m = side_m / std::max(board.size.rows, board.size.cols);
  if (lens.calibrated()) {
    poses = PlanePoses({fitted->geometry, fitted->information}, cell_m, lens.focal());
    if (!poses) return refuse(Refusal::kNoPose);
  }
  outcome.accepted = true;
  outcome.image = fitted->image;
  Describe(*fitted, board, identity, lens, outcome.marker);
  if (!poses) return outcome;
  DescribePose(*poses, outcome.marker);
  outcome.marker.measurement = {fitted->geometry.plane_from_board(), fitted->information, lens.focal(), cell_m};
  return outcome;
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
  impl_->Detect(image, markers, nullptr);
  return markers;
}

void Detector::Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace) {
  impl_->Detect(image, markers, trace);
}

const DetectStats& Detector::stats() const { return impl_->stats; }
const DetectorOptions& Detector::options() const { return impl_->options; }

}  // namespace chequer
