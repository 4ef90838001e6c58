#include "lens/lens_start.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/median.h"
#include "core/rotations.h"
#include "detect/toolbox.h"

namespace chequer {
namespace {

/// Focal lengths that are tried, widths of the image: fisheyes that see 180 degrees have 0.3, telephoto lenses 4 and
/// more; the bundle finds its way from a guess that is off by a third.
constexpr std::array kFocalLengths{0.32, 0.45, 0.65, 0.9, 1.3, 1.9, 2.8, 4.2};
/// Views that a guess is judged by: enough to tell, few enough to be quick.
constexpr std::size_t kTrialViews = 10;
constexpr std::size_t kFewestOfView = 6;

/// A point as it would be seen on the plane z = 1.
struct NormalizedPoint {
  int board = 0;
  Eigen::Vector2d on_board_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();
};
using NormalizedView = std::vector<NormalizedPoint>;

NormalizedView Normalize(const LensView& view, const CameraModel& camera) {
  NormalizedView points;
  for (const SeenPoint& point : view.points)
    if (const auto normalized = camera.Undistort(point.pixel))
      points.push_back({point.board, point.on_board_m, *normalized});
  return points;
}

/// Boards as far as their places are known.
using Places = std::vector<std::optional<BoardPlace>>;

std::optional<Eigen::Matrix3d> HomographyOf(const NormalizedView& view, const Places& places) {
  std::vector<PointPair> pairs;
  for (const NormalizedPoint& point : view)
    if (const auto& place = places[static_cast<std::size_t>(point.board)])
      pairs.push_back({*place * point.on_board_m, point.normalized});
  if (pairs.size() < kFewestOfView) return std::nullopt;
  return FitHomography(pairs);
}

/// The turn and shift that take points of a board to where they lie on the sheet, by least squares.
BoardPlace PlaceFromPairs(const std::vector<PointPair>& pairs) {
  Eigen::Vector2d from_mean(0, 0), to_mean(0, 0);
  for (const PointPair& pair : pairs) {
    from_mean += pair.from / static_cast<double>(pairs.size());
    to_mean += pair.to / static_cast<double>(pairs.size());
  }
  double sine = 0, cosine = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d from = pair.from - from_mean, to = pair.to - to_mean;
    sine += from.x() * to.y() - from.y() * to.x();
    cosine += from.dot(to);
  }
  BoardPlace place;
  place.heading_rad = std::atan2(sine, cosine);
  place.position_m = to_mean - Eigen::Rotation2Dd(place.heading_rad) * from_mean;
  return place;
}

/// Where several views put one board.
struct Candidate {
  int board = 0;
  BoardPlace place;
  double spread_m = 0;  ///< of the views, grown where they are few
};

Candidate Agree(int board, const std::vector<BoardPlace>& guesses) {
  std::vector<double> x, y, turn, off;
  for (const BoardPlace& guess : guesses) {
    x.push_back(guess.position_m.x());
    y.push_back(guess.position_m.y());
    turn.push_back(std::remainder(guess.heading_rad - guesses[0].heading_rad, 2 * M_PI));
  }
  Candidate candidate{board, {{Median(x), Median(y)}, guesses[0].heading_rad + Median(turn)}, 0};
  for (const BoardPlace& guess : guesses) off.push_back((guess.position_m - candidate.place.position_m).norm());
  // One view alone shows no spread and is to be trusted least.
  candidate.spread_m = guesses.size() < 2 ? 1e3 : Median(off) / static_cast<double>(guesses.size());
  return candidate;
}

/// One round of laying out: what the views say of boards that are not yet placed.
std::vector<Candidate> Candidates(const std::vector<NormalizedView>& views, const Places& places) {
  std::vector<std::vector<BoardPlace>> guesses(places.size());
  for (const NormalizedView& view : views) {
    const auto image_from_sheet = HomographyOf(view, places);
    if (!image_from_sheet || std::abs(image_from_sheet->determinant()) < 1e-12) continue;
    const Eigen::Matrix3d sheet_from_image = image_from_sheet->inverse();
    std::vector<std::vector<PointPair>> pairs(places.size());
    for (const NormalizedPoint& point : view)
      if (!places[static_cast<std::size_t>(point.board)])
        pairs[static_cast<std::size_t>(point.board)].push_back(
            {point.on_board_m, (sheet_from_image * point.normalized.homogeneous()).hnormalized()});
    for (std::size_t board = 0; board < pairs.size(); ++board)
      if (pairs[board].size() >= kFewestOfView) guesses[board].push_back(PlaceFromPairs(pairs[board]));
  }
  std::vector<Candidate> candidates;
  for (std::size_t board = 0; board < guesses.size(); ++board)
    if (!guesses[board].empty()) candidates.push_back(Agree(static_cast<int>(board), guesses[board]));
  return candidates;
}

/// Places board after board, in each round the half that the views agree on best: they are the near ones.
Places LayOut(const std::vector<NormalizedView>& views, std::size_t boards) {
  Places places(boards);
  places[0] = BoardPlace();
  for (;;) {
    std::vector<Candidate> candidates = Candidates(views, places);
    if (candidates.empty()) return places;
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.spread_m < b.spread_m; });
    candidates.resize((candidates.size() + 1) / 2);
    for (const Candidate& candidate : candidates) places[static_cast<std::size_t>(candidate.board)] = candidate.place;
  }
}

std::optional<RigidTransform> PoseOfHomography(Eigen::Matrix3d image_from_sheet) {
  // The sheet lies in front of the camera, so its origin's depth is positive.
  const double scale = (image_from_sheet.col(0).norm() + image_from_sheet.col(1).norm()) / 2;
  if (!(scale > 0) || !image_from_sheet.allFinite()) return std::nullopt;
  image_from_sheet /= image_from_sheet(2, 2) < 0 ? -scale : scale;
  Eigen::Matrix3d axes;
  axes << image_from_sheet.col(0), image_from_sheet.col(1), image_from_sheet.col(0).cross(image_from_sheet.col(1));
  if (!(axes.determinant() > 0)) return std::nullopt;
  return RigidTransform{Eigen::Quaterniond(FindNearestRotation(axes).rotation), image_from_sheet.col(2)};
}

Places Placed(std::span<const BoardPlace> boards) { return {boards.begin(), boards.end()}; }

/// Views that show most, spread over all.
std::vector<std::size_t> PickTrials(std::span<const LensView> views) {
  std::vector<std::size_t> order(views.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return views[a].points.size() > views[b].points.size(); });
  // Of the better half, every n-th: neighbours in a recording look alike.
  std::vector<std::size_t> better(
      order.begin(),
      order.begin() + static_cast<std::ptrdiff_t>(std::max(order.size() / 2, std::min(order.size(), kTrialViews))));
  std::sort(better.begin(), better.end());
  std::vector<std::size_t> picked;
  const std::size_t count = std::min(better.size(), kTrialViews);
  for (std::size_t i = 0; i < count; ++i) picked.push_back(better[i * better.size() / count]);
  return picked;
}

CameraModel CameraAt(double focal_px, int width, int height, CameraModel::Kind kind) {
  CameraModel camera{.width = width, .height = height};
  camera.fx = camera.fy = focal_px;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  camera.kind = kind;
  return camera;
}

double MedianDistance(std::span<const LensView> views, const Bundle& bundle) {
  std::vector<double> distances;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const SeenPoint& point : views[v].points) {
      const auto pixel = PredictPixel(bundle, v, point);
      distances.push_back(pixel ? (*pixel - point.pixel).norm() : 1e6);
    }
  return distances.empty() ? 1e9 : Median(distances);
}

/// A bundle of some views, fitted from one focal length.
struct Trial {
  Bundle bundle;
  double distance_px = 1e9;
};

/// Views without the points of boards whose place is not known.
std::vector<LensView> Only(std::span<const LensView> views, const std::vector<bool>& placed) {
  std::vector<LensView> kept(views.begin(), views.end());
  for (LensView& view : kept)
    std::erase_if(view.points, [&](const SeenPoint& point) { return !placed[static_cast<std::size_t>(point.board)]; });
  return kept;
}

/// Every third point: a trial is judged as well by them.
LensView Thinned(const LensView& view) {
  LensView thinned;
  const std::size_t step = view.points.size() < 60 ? 1 : 3;
  for (std::size_t i = 0; i < view.points.size(); i += step) thinned.points.push_back(view.points[i]);
  return thinned;
}

Trial Try(std::span<const LensView> views, const std::vector<std::size_t>& picked, const CameraModel& camera,
          const Places& places) {
  Trial trial;
  trial.bundle.camera = camera;
  std::vector<bool> placed;
  for (const auto& place : places) {
    placed.push_back(place.has_value());
    trial.bundle.boards.push_back(place.value_or(BoardPlace()));
  }
  const std::vector<LensView> known = Only(views, placed);
  std::vector<LensView> used;
  for (const std::size_t i : picked) {
    const auto pose = PoseOfSheet(known[i], camera, trial.bundle.boards);
    if (!pose) continue;
    used.push_back(Thinned(known[i]));
    trial.bundle.camera_from_sheet.push_back(*pose);
  }
  if (used.empty()) return trial;
  // A guess that is wrong by a third is off by many pixels at the rim: far residuals must not rule.
  FitBundle(used, {.max_passes = 20, .robust_px = 0.01 * camera.width}, trial.bundle);
  trial.distance_px = MedianDistance(used, trial.bundle);
  return trial;
}

std::size_t BoardCount(std::span<const LensView> views) {
  int most = 0;
  for (const LensView& view : views)
    for (const SeenPoint& point : view.points) most = std::max(most, point.board);
  return static_cast<std::size_t>(most) + 1;
}

}  // namespace

std::optional<RigidTransform> PoseOfSheet(const LensView& view, const CameraModel& camera,
                                          std::span<const BoardPlace> boards) {
  const auto homography = HomographyOf(Normalize(view, camera), Placed(boards));
  return homography ? PoseOfHomography(*homography) : std::nullopt;
}

std::optional<LensStart> StartBundle(std::span<const LensView> views, int width, int height, CameraModel::Kind kind) {
  const std::vector<std::size_t> picked = PickTrials(views);
  Trial best;
  std::optional<CameraModel> best_camera;
  for (const double focal_length : kFocalLengths) {
    const CameraModel camera = CameraAt(focal_length * width, width, height, kind);
    std::vector<NormalizedView> normalized;
    for (const std::size_t i : picked) normalized.push_back(Normalize(views[i], camera));
    Trial trial = Try(views, picked, camera, LayOut(normalized, BoardCount(views)));
    if (trial.distance_px < best.distance_px) {
      best_camera = trial.bundle.camera;
      best = std::move(trial);
    }
  }
  // A guess that is this far off explains nothing.
  if (!best_camera || best.distance_px > 0.02 * width) return std::nullopt;
  LensStart start;
  std::vector<NormalizedView> all;
  for (const LensView& view : views) all.push_back(Normalize(view, *best_camera));
  const Places places = LayOut(all, BoardCount(views));
  start.bundle.camera = *best_camera;
  for (const auto& place : places) {
    start.placed.push_back(place.has_value());
    start.bundle.boards.push_back(place.value_or(BoardPlace()));
  }
  const std::vector<LensView> known = Only(views, start.placed);
  RigidTransform ahead;
  ahead.translation = {0, 0, 1};
  for (const LensView& view : known)
    start.bundle.camera_from_sheet.push_back(PoseOfSheet(view, *best_camera, start.bundle.boards).value_or(ahead));
  return start;
}

}  // namespace chequer
