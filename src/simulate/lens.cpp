#include "simulate/lens.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "chequer/check.h"
#include "simulate/coverage.h"

namespace chequer {
namespace {

/// Pixels along a tile: large enough that its rim is a small part, small enough that its parts stay in the cache.
constexpr int kTile = 32;

struct Box {
  int x0, y0, x1, y1;  ///< x1 and y1 are beyond the last
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};

/// The pixels of a tile that receive light from a layer.
Box Touched(const Layer& layer, int reach, const Box& tile) {
  const auto pixel = [](double x) { return static_cast<int>(std::floor(std::clamp(x, -1e8, 1e8) + 0.5)); };
  return {std::max(tile.x0, pixel(layer.low.x()) - reach), std::max(tile.y0, pixel(layer.low.y()) - reach),
          std::min(tile.x1, pixel(layer.high.x()) + reach + 1), std::min(tile.y1, pixel(layer.high.y()) + reach + 1)};
}

/// Renders boxes of pixels with each pixel divided into parts. Keeps its memory from box to box.
class FineRenderer {
 public:
  FineRenderer(const LinearImage& background, int rim, const PointSpread& spread, const CastShadow& shadow)
      : background_(background), rim_(rim), spread_(spread), shadow_(shadow) {}

  void Render(const std::vector<const Layer*>& layers, const Box& box, LinearImage& out) {
    box_ = box;
    width_ = (box.x1 - box.x0 + 2 * spread_.reach()) * spread_.parts();
    height_ = (box.y1 - box.y0 + 2 * spread_.reach()) * spread_.parts();
    over_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), Eigen::Array4f::Zero());
    for (const Layer* layer : layers) Lay(*layer);
    LayOverBackground();
    SumUp(out);
  }

 private:
  /// Puts a layer over what is there. Both cover parts of a pixel; parts are taken to be disjoint as far as that is
  /// possible (two boards that touch leave no seam), and where it is not, the upper one hides the lower.
  void Lay(const Layer& layer) {
    const double scale = spread_.parts();
    const Eigen::Vector2d origin(box_.x0 - spread_.reach() - 0.5, box_.y0 - spread_.reach() - 0.5);
    raster_.Reset(width_, height_);
    for (const OutlineEdge& edge : layer.edges) raster_.Add(edge, origin, scale);
    const auto first = static_cast<int>(std::clamp((layer.low.y() - origin.y()) * scale, 0.0, double(height_)));
    const auto last = static_cast<int>(std::clamp((layer.high.y() - origin.y()) * scale + 1, 0.0, double(height_)));
    for (int y = first; y < last; ++y) {
      const auto row = raster_.IntegrateRow(y);
      Eigen::Array4f* over = &over_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_)];
      const double fall_y = layer.fall_offset + layer.fall_direction.y() * (origin.y() + (y + 0.5) / scale) +
                            layer.fall_direction.x() * origin.x();
      for (int x = 0; x < width_; ++x) {
        Eigen::Array4f top = row[static_cast<std::size_t>(x)];
        // Below this is what rounding leaves of sums that cancel.
        if (!(top[3] > 1e-5f)) continue;
        if (layer.glow) top.head<3>() += top[3] * layer.glow->At(origin + Eigen::Vector2d(x + 0.5, y + 0.5) / scale);
        if (layer.fall > 0) {
          const double fallen = std::clamp(fall_y + layer.fall_direction.x() * (x + 0.5) / scale, 0.0, 1.0);
          top.head<3>() *= static_cast<float>(1 - layer.fall * fallen);
        }
        if (shadow_.takes > 0)
          top.head<3>() *=
              static_cast<float>(shadow_.LightAt(origin.x() + (x + 0.5) / scale, origin.y() + (y + 0.5) / scale));
        const float left = std::max(0.0f, 1 - top[3]);
        if (over[x][3] > left) over[x] *= left / over[x][3];
        over[x] += top;
      }
    }
  }

  void LayOverBackground() {
    const int parts = spread_.parts();
    const int dx = box_.x0 + rim_ - spread_.reach(), dy = box_.y0 + rim_ - spread_.reach();
    for (int y = 0; y < height_; ++y) {
      Eigen::Array4f* over = &over_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_)];
      for (int px = 0; px < width_ / parts; ++px) {
        const float* below = background_.Pixel(px + dx, y / parts + dy);
        const Eigen::Array4f colour(below[0], below[1], below[2], 1);
        for (int part = 0; part < parts; ++part, ++over) *over += std::max(0.0f, 1 - (*over)[3]) * colour;
      }
    }
  }

  /// The lens: columns first, where whole rows are added up, then the rest along the rows.
  void SumUp(LinearImage& out) {
    const int parts = spread_.parts();
    const std::vector<float>& weights = spread_.fine();
    row_.resize(static_cast<std::size_t>(width_));
    for (int y = box_.y0; y < box_.y1; ++y) {
      std::fill(row_.begin(), row_.end(), Eigen::Array4f::Zero());
      for (std::size_t k = 0; k < weights.size(); ++k) {
        const Eigen::Array4f* fine =
            &over_[(static_cast<std::size_t>((y - box_.y0) * parts) + k) * static_cast<std::size_t>(width_)];
        for (std::size_t x = 0; x < row_.size(); ++x) row_[x] += weights[k] * fine[x];
      }
      for (int x = box_.x0; x < box_.x1; ++x) {
        Eigen::Array4f sum = Eigen::Array4f::Zero();
        const Eigen::Array4f* fine = &row_[static_cast<std::size_t>((x - box_.x0) * parts)];
        for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * fine[k];
        float* pixel = out.Pixel(x, y);
        for (int c = 0; c < 3; ++c) pixel[c] = sum[c];
      }
    }
  }

  const LinearImage& background_;
  int rim_;
  const PointSpread& spread_;
  const CastShadow& shadow_;
  Box box_{};
  int width_ = 0;
  int height_ = 0;
  CoverageRaster raster_;
  std::vector<Eigen::Array4f> over_;  ///< what the layers show, times coverage; coverage
  std::vector<Eigen::Array4f> row_;
};

}  // namespace

PointSpread::PointSpread(double sigma_px) {
  CHEQUER_CHECK(sigma_px >= 0 && sigma_px <= 50, "sigma_px must be from 0 to 50");
  if (sigma_px == 0) {
    fine_ = coarse_ = {1.0f};
    return;
  }
  // Parts are boxes of h = 1/parts pixel. What they alias of a sharp edge is, at the worst phase and direction, 0.019
  // (h / sigma)² of its contrast (measured; lens_test.cpp holds it below 1e-3). Below sigma = 0.37 the box of the pixel
  // itself hides what 12 parts leave.
  parts_ = std::clamp(static_cast<int>(std::ceil(4.4 / sigma_px)), 1, 12);
  reach_ = static_cast<int>(std::ceil(4.0 * sigma_px + 0.5));
  const int count = (2 * reach_ + 1) * parts_;
  std::vector<double> weights(static_cast<std::size_t>(count));
  double sum = 0;
  for (int k = 0; k < count; ++k) {
    const double middle = (k + 0.5) / parts_ - reach_ - 0.5;
    // The share of the pixel's own parts that a part reaches: Gaussian sampled from part to part, box over the pixel.
    double weight = 0;
    for (int part = 0; part < parts_; ++part) {
      const double own = (part + 0.5) / parts_ - 0.5;
      weight += std::exp(-0.5 * (middle - own) * (middle - own) / (sigma_px * sigma_px));
    }
    weights[static_cast<std::size_t>(k)] = weight;
    sum += weight;
  }
  coarse_.assign(static_cast<std::size_t>(2 * reach_ + 1), 0.0f);
  for (int k = 0; k < count; ++k) {
    const auto weight = static_cast<float>(weights[static_cast<std::size_t>(k)] / sum);
    fine_.push_back(weight);
    coarse_[static_cast<std::size_t>(k / parts_)] += weight;
  }
}

LinearImage BlurBackground(const LinearImage& background, int rim, const PointSpread& spread) {
  CHEQUER_CHECK(rim >= spread.reach(), "the background's rim is smaller than the lens' reach");
  LinearImage out(background.width - 2 * rim, background.height - 2 * rim);
  const cv::Mat in(background.height, background.width, CV_32FC3, const_cast<float*>(background.rgb.data()));
  // A header over the inner part: filters then read the true pixels of the rim.
  const cv::Mat inner = in(cv::Rect(rim, rim, out.width, out.height));
  cv::Mat result(out.height, out.width, CV_32FC3, out.rgb.data());
  if (spread.reach() == 0)
    inner.copyTo(result);
  else
    cv::sepFilter2D(inner, result, CV_32F, spread.coarse(), spread.coarse());
  return out;
}

LinearImage SeeThroughLens(const LinearImage& background, int rim, const std::vector<Layer>& layers,
                           const PointSpread& spread, const CastShadow& shadow) {
  LinearImage out = BlurBackground(background, rim, spread);
  DrawLayers(background, rim, layers, spread, shadow, out);
  return out;
}

void DrawLayers(const LinearImage& background, int rim, const std::vector<Layer>& layers, const PointSpread& spread,
                const CastShadow& shadow, LinearImage& out) {
  FineRenderer renderer(background, rim, spread, shadow);
  std::vector<const Layer*> here;
  for (int y = 0; y < out.height; y += kTile)
    for (int x = 0; x < out.width; x += kTile) {
      const Box tile{x, y, std::min(x + kTile, out.width), std::min(y + kTile, out.height)};
      Box touched{tile.x1, tile.y1, tile.x0, tile.y0};
      here.clear();
      for (const Layer& layer : layers) {
        const Box box = Touched(layer, spread.reach(), tile);
        if (box.empty()) continue;
        here.push_back(&layer);
        touched = {std::min(touched.x0, box.x0), std::min(touched.y0, box.y0), std::max(touched.x1, box.x1),
                   std::max(touched.y1, box.y1)};
      }
      if (!here.empty()) renderer.Render(here, touched, out);
    }
}

LinearImage Smear(const LinearImage& image, double length_px, double angle_rad) {
  const int reach = static_cast<int>(std::ceil(0.5 * length_px)) + 1;
  cv::Mat kernel = cv::Mat::zeros(2 * reach + 1, 2 * reach + 1, CV_32F);
  // Many instants of the exposure, each spread over the four pixels about its place so that the mean place is exact.
  const int instants = std::max(64, static_cast<int>(16 * length_px));
  for (int i = 0; i < instants; ++i) {
    const double along = length_px * ((i + 0.5) / instants - 0.5);
    const double x = reach + along * std::cos(angle_rad), y = reach + along * std::sin(angle_rad);
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const double fx = x - column, fy = y - row;
    const auto add = [&](int r, int c, double w) { kernel.at<float>(r, c) += static_cast<float>(w / instants); };
    add(row, column, (1 - fx) * (1 - fy));
    add(row, column + 1, fx * (1 - fy));
    add(row + 1, column, (1 - fx) * fy);
    add(row + 1, column + 1, fx * fy);
  }
  LinearImage out(image.width, image.height);
  const cv::Mat in(image.height, image.width, CV_32FC3, const_cast<float*>(image.rgb.data()));
  cv::Mat result(image.height, image.width, CV_32FC3, out.rgb.data());
  cv::filter2D(in, result, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  return out;
}

}  // namespace chequer
