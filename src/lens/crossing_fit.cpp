#include "lens/crossing_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <vector>

namespace chequer {
namespace {

/// x, y: pixels; the edges' angles, radians; mean level and half the contrast, grey levels; log of the blur's sigma,
/// pixels; slope of the light, a share a pixel.
enum Parameter { kX, kY, kFirst, kSecond, kLevel, kContrast, kLogBlur, kSlopeX, kSlopeY, kParameters };

/// A fit that goes farther than this share of its radius has found something else. A guess.
constexpr double kFarthest = 0.4;
/// Share of the radius that is fitted first: it shows the crossing alone, as far as it can. A guess.
constexpr double kNear = 0.6;
/// Of half the contrast; pixels that lie farther from the first fit show something else. A tone curve of gamma 2.2
/// makes residuals of up to 0.2.
constexpr double kExplained = 0.5;
/// Grey levels; with less contrast noise decides. A guess.
constexpr double kLeastHalfContrast = 5;
constexpr int kIterations = 30;
/// A start's blur, pixels; that of a sharp lens with square pixels.
constexpr double kUsualBlur = 0.8;

struct Pixel {
  double x, y, value;
};

/// Not what is not a number.
bool InImage(const BytePlane& plane, const Eigen::Vector2d& at) {
  return at.x() >= 0 && at.y() >= 0 && at.x() < plane.width() && at.y() < plane.height();
}

std::vector<Pixel> PixelsAbout(const BytePlane& plane, const Eigen::Vector2d& at, double radius) {
  std::vector<Pixel> pixels;
  const auto first = [&](double middle) { return std::max(0, static_cast<int>(std::ceil(middle - radius))); };
  const auto last = [&](double middle, int size) {
    return std::min(size - 1, static_cast<int>(std::floor(middle + radius)));
  };
  for (int y = first(at.y()); y <= last(at.y(), plane.height()); ++y)
    for (int x = first(at.x()); x <= last(at.x(), plane.width()); ++x)
      if ((Eigen::Vector2d(x, y) - at).squaredNorm() <= radius * radius)
        pixels.push_back({static_cast<double>(x), static_cast<double>(y), static_cast<double>(plane.row(y)[x])});
  return pixels;
}

/// An edge at a pixel: -1 to 1 across it, and how that changes with the distance from it.
struct Edge {
  double sine, cosine, across, along, side, slope;

  Edge(double angle, double blur, double dx, double dy)
      : sine(std::sin(angle)),
        cosine(std::cos(angle)),
        across(cosine * dy - sine * dx),
        along(cosine * dx + sine * dy),
        side(std::erf(across / blur / std::numbers::sqrt2)),
        slope(std::sqrt(2 / std::numbers::pi) / blur * std::exp(-0.5 * (across / blur) * (across / blur))) {}
};

class Residuals final : public cv::LMSolver::Callback {
 public:
  explicit Residuals(const std::vector<Pixel>& pixels) : pixels_(pixels) {}

  bool compute(cv::InputArray parameters, cv::OutputArray errors, cv::OutputArray derivatives) const override {
    const cv::Mat given = parameters.getMat();
    const double* p = given.ptr<double>();
    const int count = static_cast<int>(pixels_.size());
    errors.create(count, 1, CV_64F);
    cv::Mat error = errors.getMat(), derivative;
    if (derivatives.needed()) {
      derivatives.create(count, kParameters, CV_64F);
      derivative = derivatives.getMat();
    }
    const double blur = std::exp(p[kLogBlur]);
    for (int i = 0; i < count; ++i) {
      const Pixel& pixel = pixels_[static_cast<std::size_t>(i)];
      const double dx = pixel.x - p[kX], dy = pixel.y - p[kY];
      const Edge a(p[kFirst], blur, dx, dy), b(p[kSecond], blur, dx, dy);
      const double shape = a.side * b.side, print = p[kLevel] + p[kContrast] * shape;
      const double light = 1 + p[kSlopeX] * dx + p[kSlopeY] * dy;
      error.at<double>(i) = print * light - pixel.value;
      if (derivative.empty()) continue;
      const double by_a = light * p[kContrast] * a.slope * b.side, by_b = light * p[kContrast] * b.slope * a.side;
      const std::array<double, kParameters> row{by_a * a.sine + by_b * b.sine - print * p[kSlopeX],
                                                -by_a * a.cosine - by_b * b.cosine - print * p[kSlopeY],
                                                -by_a * a.along,
                                                -by_b * b.along,
                                                light,
                                                light * shape,
                                                -by_a * a.across - by_b * b.across,
                                                print * dx,
                                                print * dy};
      std::copy(row.begin(), row.end(), derivative.ptr<double>(i));
    }
    return true;
  }

  double Rms(const cv::Mat& parameters) const {
    cv::Mat error;
    compute(parameters, error, cv::noArray());
    return cv::norm(error) / std::sqrt(static_cast<double>(pixels_.size()));
  }

 private:
  const std::vector<Pixel>& pixels_;
};

cv::Mat StartOf(const CrossingStart& start, const std::vector<Pixel>& pixels) {
  const auto [darkest, lightest] = std::minmax_element(
      pixels.begin(), pixels.end(), [](const Pixel& a, const Pixel& b) { return a.value < b.value; });
  const double level = (darkest->value + lightest->value) / 2, half = (lightest->value - darkest->value) / 2;
  cv::Mat parameters = cv::Mat::zeros(kParameters, 1, CV_64F);
  double* p = parameters.ptr<double>();
  p[kX] = start.at.x();
  p[kY] = start.at.y();
  p[kFirst] = std::atan2(start.first_edge.y(), start.first_edge.x());
  p[kSecond] = std::atan2(start.second_edge.y(), start.second_edge.x());
  p[kLevel] = level;
  p[kLogBlur] = std::log(kUsualBlur);
  // Which of the quarters are light.
  double lighter = 0;
  for (const Pixel& pixel : pixels) {
    const Edge a(p[kFirst], kUsualBlur, pixel.x - p[kX], pixel.y - p[kY]),
        b(p[kSecond], kUsualBlur, pixel.x - p[kX], pixel.y - p[kY]);
    lighter += (pixel.value - level) * a.side * b.side;
  }
  p[kContrast] = std::copysign(half, lighter);
  return parameters;
}

bool Solve(const std::vector<Pixel>& pixels, cv::Mat& parameters) {
  return pixels.size() >= 2 * kParameters &&
         cv::LMSolver::create(cv::makePtr<Residuals>(pixels), kIterations)->run(parameters) >= 0;
}

/// Whether what was fitted is a crossing near its start. Written so that what is not a number is none.
bool Holds(const cv::Mat& parameters, const CrossingStart& start) {
  const double* p = parameters.ptr<double>();
  const Eigen::Vector2d at(p[kX], p[kY]);
  return (at - start.at).norm() <= kFarthest * start.radius_px && std::abs(p[kContrast]) >= kLeastHalfContrast &&
         std::exp(p[kLogBlur]) <= start.radius_px;
}

/// Leaves out the pixels that show something else: what lies beyond a narrow margin, a finger, a lamp's reflection.
std::vector<Pixel> Explained(std::vector<Pixel> pixels, const cv::Mat& parameters) {
  cv::Mat error;
  Residuals(pixels).compute(parameters, error, cv::noArray());
  const double most = kExplained * std::abs(parameters.at<double>(kContrast));
  std::vector<Pixel> explained;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (std::abs(error.at<double>(static_cast<int>(i))) <= most) explained.push_back(pixels[i]);
  return explained;
}

}  // namespace

std::optional<Crossing> FitCrossing(const BytePlane& plane, const CrossingStart& start) {
  if (!InImage(plane, start.at)) return std::nullopt;
  std::vector<Pixel> near = PixelsAbout(plane, start.at, kNear * start.radius_px);
  if (near.size() < 2 * kParameters) return std::nullopt;
  cv::Mat parameters = StartOf(start, near);
  if (!Solve(near, parameters) || !Holds(parameters, start)) return std::nullopt;
  const std::vector<Pixel> all = Explained(PixelsAbout(plane, start.at, start.radius_px), parameters);
  if (!Solve(all, parameters) || !Holds(parameters, start)) return std::nullopt;
  const double* p = parameters.ptr<double>();
  return Crossing{{p[kX], p[kY]}, Residuals(all).Rms(parameters) / std::abs(p[kContrast])};
}

}  // namespace chequer
