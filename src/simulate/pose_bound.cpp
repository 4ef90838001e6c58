#include "simulate/pose_bound.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/small_cholesky.h"
#include "simulate/linear_image.h"

namespace chequer {
namespace {

/// Steps of the differences: so far that the renderer's own errors (1e-3 of the contrast) vanish in them, so near that
/// their curvature does.
constexpr double kStepPx = 0.2, kBlurStep = 0.05;
/// Pixels around the board that are rendered.
constexpr int kRimPx = 8;
constexpr int kPose = 6, kBlur = 6, kShared = 7;
using SharedVector = Eigen::Matrix<double, kShared, 1>;

/// The board with one more ring of cells, each a copy of its neighbour, so that the board's own rim is no edge.
SceneMarker WithoutRim(SceneMarker marker) {
  const Board board = marker.board;
  marker.board.rows += 2;
  marker.board.cols += 2;
  marker.board.uncounted_rim = 1;
  marker.board.cells.clear();
  for (int row = -1; row <= board.rows; ++row)
    for (int col = -1; col <= board.cols; ++col)
      marker.board.cells += board.cells[static_cast<std::size_t>(std::clamp(row, 0, board.rows - 1) * board.cols +
                                                                 std::clamp(col, 0, board.cols - 1))];
  marker.margin_cells = 0;
  return marker;
}

SceneMarker Moved(SceneMarker marker, int parameter, double step) {
  RigidTransform& pose = marker.camera_from_marker;
  if (parameter < 3)
    pose.translation[parameter] += step;
  else
    pose.rotation = RotationFromVector(step * Eigen::Vector3d::Unit(parameter - 3)) * pose.rotation;
  return marker;
}

/// The part of a frame around one marker.
class Window {
 public:
  Window(const SceneMarker& marker, const RenderOptions& options) : options_(options) {
    const CameraModel& camera = options.camera;
    Eigen::Vector2d least(camera.width, camera.height), most(0, 0);
    for (const Eigen::Vector2d& corner : Corners(marker)) {
      least = least.cwiseMin(corner);
      most = most.cwiseMax(corner);
    }
    // An even place keeps the mosaic's phase.
    const int x = (static_cast<int>(least.x()) - kRimPx) & ~1, y = (static_cast<int>(least.y()) - kRimPx) & ~1;
    options_.camera.width = static_cast<int>(most.x()) + kRimPx - x;
    options_.camera.height = static_cast<int>(most.y()) + kRimPx - y;
    options_.camera.cx -= x;
    options_.camera.cy -= y;
  }

  const CameraModel& camera() const { return options_.camera; }
  LinearImage Light(const SceneMarker& marker, double blur_step = 0) const {
    RenderOptions options = options_;
    options.blur_sigma_px += blur_step;
    return RenderLight(Scene{{marker}, {}}, options);
  }

  /// How far the board's corners move at most, pixels.
  double Displacement(const SceneMarker& a, const SceneMarker& b) const {
    double most = 0;
    const auto from = Corners(a), to = Corners(b);
    for (std::size_t i = 0; i < 4; ++i) most = std::max(most, (from[i] - to[i]).norm());
    return most;
  }

  /// Whether a pixel's centre lies on the board.
  bool OnBoard(const SceneMarker& marker, int x, int y) const {
    const auto ray = camera().Undistort({x, y});
    if (!ray) return false;
    const RigidTransform marker_from_camera = marker.camera_from_marker.Inverse();
    const Eigen::Vector3d from = marker_from_camera.translation;
    const Eigen::Vector3d along = marker_from_camera.rotation * Eigen::Vector3d(ray->x(), ray->y(), 1);
    const Eigen::Vector3d at = (from - from.z() / along.z() * along) / marker.CellSize();
    return std::abs(at.x()) < 0.5 * marker.board.cols - marker.board.uncounted_rim &&
           std::abs(at.y()) < 0.5 * marker.board.rows - marker.board.uncounted_rim;
  }

 private:
  std::array<Eigen::Vector2d, 4> Corners(const SceneMarker& marker) const {
    const int cols = marker.board.cols, rows = marker.board.rows;
    std::array<Eigen::Vector2d, 4> corners;
    constexpr std::array<int, 4> kRight{0, 1, 1, 0}, kDown{0, 0, 1, 1};
    for (std::size_t i = 0; i < 4; ++i)
      corners[i] = camera().Project(marker.camera_from_marker * marker.PointAt(kRight[i] * cols, kDown[i] * rows));
    return corners;
  }

  RenderOptions options_;
};

/// The share of each cell's light in each pixel (the first channel of each image), cells of the inner board row by row.
std::vector<LinearImage> CellShares(const Window& window, SceneMarker marker) {
  const Board full = marker.board;
  marker.inks =
      InkSet{Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones(), Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones()};
  marker.board.cells.assign(full.cells.size(), 'K');
  const LinearImage dark = window.Light(marker);
  const int rows = full.rows - 2, cols = full.cols - 2;
  std::vector<LinearImage> shares;
  for (int cell = 0; cell < rows * cols; ++cell) {
    for (int row = 0; row < full.rows; ++row)
      for (int col = 0; col < full.cols; ++col) {
        const bool lit =
            std::clamp(row - 1, 0, rows - 1) == cell / cols && std::clamp(col - 1, 0, cols - 1) == cell % cols;
        marker.board.cells[static_cast<std::size_t>(row * full.cols + col)] = lit ? 'W' : 'K';
      }
    shares.push_back(window.Light(marker));
    for (std::size_t i = 0; i < dark.rgb.size(); ++i) shares.back().rgb[i] -= dark.rgb[i];
  }
  return shares;
}

/// Derivatives of the light by pose and blur, by central differences.
std::array<LinearImage, kShared> Slopes(const Window& window, const SceneMarker& marker, double blur_px) {
  std::array<LinearImage, kShared> slopes;
  for (int p = 0; p < kShared; ++p) {
    LinearImage up, down;
    double step = kBlurStep * std::max(blur_px, 0.2);
    if (p == kBlur) {
      up = window.Light(marker, step);
      down = window.Light(marker, -step);
    } else {
      constexpr double kTry = 1e-4;
      step = kTry * kStepPx / window.Displacement(marker, Moved(marker, p, kTry));
      up = window.Light(Moved(marker, p, step));
      down = window.Light(Moved(marker, p, -step));
    }
    for (std::size_t i = 0; i < up.rgb.size(); ++i)
      up.rgb[i] = static_cast<float>((up.rgb[i] - down.rgb[i]) / (2 * step));
    slopes[static_cast<std::size_t>(p)] = std::move(up);
  }
  return slopes;
}

/// Of a sample, in parts of full scale: photons, read-out, rounding to the 8-bit code.
double Variance(double light, const SensorOptions& sensor, const ToneCurve& curve) {
  const double well = sensor.full_well_electrons, read = sensor.read_noise_electrons;
  const double shot = std::isinf(well) ? 0 : std::max(light, 0.0) / well + read * read / (well * well);
  const double code = std::clamp(curve.FromLinear(std::clamp(light, 0.0, 1.0)), 0.5 / 255, 254.5 / 255);
  const double rounding = curve.ToLinear(code + 0.5 / 255) - curve.ToLinear(code - 0.5 / 255);
  return shot + rounding * rounding / 12;
}

/// Channels that a pixel of the sensor measures.
std::vector<int> ChannelsAt(const SensorOptions& sensor, int x, int y) {
  if (sensor.kind == SensorKind::kPerfect) return {0, 1, 2};
  const int phase = (x & 1) + 2 * (y & 1);
  const int red = sensor.bayer == PixelFormat::kBayerRg8   ? 0
                  : sensor.bayer == PixelFormat::kBayerGr8 ? 1
                  : sensor.bayer == PixelFormat::kBayerGb8 ? 2
                                                           : 3;
  if (phase == red) return {0};
  return {phase == 3 - red ? 2 : 1};
}

}  // namespace

Matrix6d PoseBound(const SceneMarker& marker, const RenderOptions& options) {
  return PoseBoundsOf(marker, options).alone;
}

PoseBounds PoseBoundsOf(const SceneMarker& given, const RenderOptions& options) {
  const SceneMarker marker = WithoutRim(given);
  const Window window(marker, options);
  const LinearImage light = window.Light(marker);
  const auto slopes = Slopes(window, marker, options.blur_sigma_px);
  const std::vector<LinearImage> shares = CellShares(window, marker);
  const auto cells = static_cast<Eigen::Index>(shares.size());
  Eigen::Matrix<double, kShared, kShared> shared = Eigen::Matrix<double, kShared, kShared>::Zero();
  std::array<Eigen::MatrixXd, 3> mixed, levels;
  for (std::size_t c = 0; c < 3; ++c) {
    mixed[c] = Eigen::MatrixXd::Zero(kShared, cells);
    levels[c] = Eigen::MatrixXd::Zero(cells, cells);
  }
  Eigen::VectorXd share(cells);
  for (int y = 0; y < light.height; ++y)
    for (int x = 0; x < light.width; ++x) {
      if (!window.OnBoard(marker, x, y)) continue;
      for (const int channel : ChannelsAt(options.sensor, x, y)) {
        const auto c = static_cast<std::size_t>(channel);
        const double gain = options.sensor.exposure * options.sensor.white_balance[c];
        const double value = gain * light.Pixel(x, y)[c];
        if (value >= 1) continue;  // saturated: tells nothing
        SharedVector slope;
        for (std::size_t p = 0; p < kShared; ++p) slope[static_cast<Eigen::Index>(p)] = gain * slopes[p].Pixel(x, y)[c];
        for (std::size_t i = 0; i < shares.size(); ++i)
          share[static_cast<Eigen::Index>(i)] = gain * shares[i].Pixel(x, y)[0];
        const double weight = 1 / Variance(value, options.sensor, options.tone_curve);
        shared += weight * slope * slope.transpose();
        mixed[c] += weight * slope * share.transpose();
        levels[c].selfadjointView<Eigen::Lower>().rankUpdate(share, weight);
      }
    }
  const Matrix6d levels_known = SmallCholesky<kPose>(shared.topLeftCorner<kPose, kPose>()).Inverse();
  for (std::size_t c = 0; c < 3; ++c) {
    const Eigen::MatrixXd full = levels[c].selfadjointView<Eigen::Lower>();
    if (full.trace() > 0) shared -= mixed[c] * full.ldlt().solve(mixed[c].transpose());
  }
  return {SmallCholesky<kShared>(shared).Inverse().topLeftCorner<kPose, kPose>(), levels_known};
}

}  // namespace chequer
