#include "detect/common/cell_unmixer.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/common/normal_integral.h"

namespace chequer {
namespace {

/// Where the prior has the cells' codes: grey.
constexpr float kPriorCode = 128;
/// Weight of the prior against a sample: noise of 10 codes (JPEG's of chroma) against cells' spread of 40. From 0.005
/// to 0.2 it makes no difference of 1 % in what is read.
constexpr float kPriorWeight = 0.06f;
/// Shares below that are left out (a guess).
constexpr float kLeastShare = 0.003f;
/// Windows keep so many standard deviations of the blur away from the edges of a cell. There, an edge leaves 12 % of
/// its step, Φ(−1.2) (a guess).
constexpr double kBlurReach = 1.2;
/// Least blur: that of a pixel, 1/√12.
constexpr float kLeastBlurPx = 0.3f;

}  // namespace

bool CellUnmixer::WindowsAreClear(const LightReader& reader, double short_side_px, double blur_px) {
  const LightReader::Sharing shared = reader.chroma_sharing();
  const int footprint = std::max(shared.cols, shared.rows);
  // Wherever the samples lie, one fits into twice its width.
  return footprint == 1 || 0.5 * short_side_px - kBlurReach * blur_px >= footprint;
}

std::optional<CellUnmixer::View> CellUnmixer::ViewOf(const LightReader& reader, const CellMesh& mesh) const {
  const auto to_image = [&](double col, double row) -> Eigen::Vector3d {
    return mesh.image_from_cells * Eigen::Vector3d(col, row, 1);
  };
  const Eigen::Vector3d middle = to_image(0.5 * mesh.cols, 0.5 * mesh.rows);
  PixelBox box;
  for (const double row : {0.5, mesh.rows - 0.5})
    for (const double col : {0.5, mesh.cols - 0.5}) {
      const Eigen::Vector3d at = to_image(col, row);
      if (!(at.z() * middle.z() > 0)) return std::nullopt;
      box.Add(static_cast<float>(at.x() / at.z()), static_cast<float>(at.y() / at.z()));
    }
  const LightReader::Sharing shared = reader.chroma_sharing();
  const auto first = [](float at, int step) { return static_cast<int>(std::max(at, 0.0f)) / step * step; };
  const auto last = [](float at, int size) { return static_cast<int>(std::min(at, static_cast<float>(size))); };
  View view;
  view.x0 = first(box.left, shared.cols), view.y0 = first(box.top, shared.rows);
  view.x1 = last(box.right, reader.width() - shared.cols), view.y1 = last(box.bottom, reader.height() - shared.rows);
  const Eigen::Matrix3d cells_from_image = mesh.image_from_cells.inverse() * middle.z();
  view.cells_from_image = cells_from_image.cast<float>();
  const auto sharpness = [&](int axis, double at_middle) {
    const Eigen::RowVector3d by_px = cells_from_image.row(axis) - at_middle * cells_from_image.row(2);
    return static_cast<float>(1 / (std::max(mesh.blur_px, kLeastBlurPx) * by_px.head<2>().norm()));
  };
  // The middle's third coordinate is 1, so that no division is left of the derivative.
  view.sharp_col = sharpness(0, 0.5 * mesh.cols);
  view.sharp_row = sharpness(1, 0.5 * mesh.rows);
  return view;
}

std::optional<CellUnmixer::Pixel> CellUnmixer::PixelAt(int x, int y, const View& view) const {
  const NormalTable& normal = NormalTable::Get();
  const auto share_out = [&](float at, float sharp, int cells, std::array<float, 3>& share) {
    const int from = std::clamp(static_cast<int>(at) - 1, 0, cells - 3);
    share[0] = 1 - normal((at - static_cast<float>(from + 1)) * sharp);
    share[2] = normal((at - static_cast<float>(from + 2)) * sharp);
    share[1] = std::max(1 - share[0] - share[2], 0.0f);
    return from;
  };
  const Eigen::Vector3f at = view.cells_from_image * Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), 1);
  const float col = at.x() / at.z(), row = at.y() / at.z();
  if (!(col >= 0.5f && row >= 0.5f && col <= static_cast<float>(cols_) - 0.5f &&
        row <= static_cast<float>(rows_) - 0.5f))
    return std::nullopt;
  Pixel pixel;
  pixel.first_col = share_out(col, view.sharp_col, cols_, pixel.col);
  pixel.first_row = share_out(row, view.sharp_row, rows_, pixel.row);
  return pixel;
}

void CellUnmixer::Collect(const LightReader& reader, const View& view) {
  const LightReader::Sharing shared = reader.chroma_sharing();
  pixels_.clear();
  for (int y = view.y0; y <= view.y1; y += shared.rows)
    for (int x = view.x0; x <= view.x1; x += shared.cols) {
      // A sample counts with all its pixels or not at all.
      const std::size_t before = pixels_.size();
      for (int k = 0; k < shared.cols * shared.rows; ++k) {
        const int at_x = x + k % shared.cols, at_y = y + k / shared.cols;
        auto pixel = PixelAt(at_x, at_y, view);
        if (!pixel) {
          pixels_.resize(before);
          break;
        }
        pixel->codes = reader.CodesAt(at_x, at_y);
        pixel->left = pixel->codes - kPriorCode;
        pixels_.push_back(*pixel);
      }
    }
}

std::size_t CellUnmixer::SharesOf(std::span<const Pixel> pixels) {
  constexpr int kSide = 6;  // of the patch of cells that the pixels see
  int first_col = pixels[0].first_col, first_row = pixels[0].first_row;
  for (const Pixel& pixel : pixels) {
    first_col = std::min(first_col, pixel.first_col);
    first_row = std::min(first_row, pixel.first_row);
  }
  std::array<float, kSide * kSide> patch{};
  const float part = 1 / static_cast<float>(pixels.size());
  for (const Pixel& pixel : pixels) {
    const int col = pixel.first_col - first_col, row = pixel.first_row - first_row;
    if (col > kSide - 3 || row > kSide - 3) return 0;  // cells of half a pixel tell nothing
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        patch[static_cast<std::size_t>((row + r) * kSide + col + c)] +=
            part * pixel.row[static_cast<std::size_t>(r)] * pixel.col[static_cast<std::size_t>(c)];
  }
  std::size_t count = 0;
  for (int k = 0; k < kSide * kSide; ++k) {
    const float share = patch[static_cast<std::size_t>(k)];
    if (share < kLeastShare) continue;
    shares_[count++] = {static_cast<std::size_t>((first_row + k / kSide) * cols_ + first_col + k % kSide), share};
  }
  return count;
}

void CellUnmixer::SetUp(Equations& equations) {
  const std::size_t n = static_cast<std::size_t>(rows_ * cols_);
  equations.factor.assign(n * n, 0.0f);
  equations.band = 0;
  for (std::size_t cell = 0; cell < n; ++cell) equations.factor[cell * n + cell] = kPriorWeight;
  for (std::size_t at = 0; at < pixels_.size(); at += equations.footprint) {
    const std::size_t count = SharesOf(std::span(pixels_).subspan(at, equations.footprint));
    if (count == 0) continue;
    for (std::size_t a = 0; a < count; ++a) {
      float* row = &equations.factor[shares_[a].cell * n];
      for (std::size_t b = 0; b <= a; ++b) row[shares_[b].cell] += shares_[a].share * shares_[b].share;
    }
    equations.band = std::max(equations.band, shares_[count - 1].cell - shares_[0].cell);
  }
  Factorize(equations);
}

void CellUnmixer::Factorize(Equations& equations) const {
  const std::size_t n = static_cast<std::size_t>(rows_ * cols_), band = equations.band;
  for (std::size_t i = 0; i < n; ++i) {
    float* row = &equations.factor[i * n];
    const std::size_t from = i > band ? i - band : 0;
    for (std::size_t j = from; j < i; ++j) {
      const float* other = &equations.factor[j * n];
      float value = row[j];
      for (std::size_t k = from; k < j; ++k) value -= row[k] * other[k];
      row[j] = value;  // L D
    }
    float pivot = row[i];
    for (std::size_t j = from; j < i; ++j) {
      const float scaled = row[j] * equations.factor[j * n + j];
      pivot -= scaled * row[j];
      row[j] = scaled;
    }
    row[i] = 1 / std::max(pivot, 0.01f * kPriorWeight);
  }
}

void CellUnmixer::Improve(const Equations& equations) {
  const std::size_t n = static_cast<std::size_t>(rows_ * cols_), band = equations.band;
  right_side_.assign(n, LightReader::Codes::Zero());
  for (std::size_t at = 0; at < pixels_.size(); at += equations.footprint) {
    const auto pixels = std::span(pixels_).subspan(at, equations.footprint);
    const std::size_t count = SharesOf(pixels);
    LightReader::Codes mean = LightReader::Codes::Zero();
    for (const Pixel& pixel : pixels) mean += pixel.left / static_cast<float>(pixels.size());
    for (std::size_t a = 0; a < count; ++a) right_side_[shares_[a].cell] += shares_[a].share * mean;
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i > band ? i - band : 0; j < i; ++j)
      right_side_[i] -= equations.factor[i * n + j] * right_side_[j];
  for (std::size_t i = n; i-- > 0;) {
    right_side_[i] *= equations.factor[i * n + i];
    for (std::size_t j = i + 1; j < std::min(n, i + band + 1); ++j)
      right_side_[i] -= equations.factor[j * n + i] * right_side_[j];
  }
  for (std::size_t cell = 0; cell < n; ++cell)
    for (int channel = equations.first; channel < equations.last; ++channel)
      codes_[cell][channel] += right_side_[cell][channel];
}

void CellUnmixer::Predict(const LightReader& reader) {
  light_.resize(codes_.size());
  for (std::size_t cell = 0; cell < codes_.size(); ++cell) light_[cell] = reader.LightOf(codes_[cell]);
  for (Pixel& pixel : pixels_) {
    Eigen::Vector3f light = Eigen::Vector3f::Zero();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        light += pixel.row[static_cast<std::size_t>(r)] * pixel.col[static_cast<std::size_t>(c)] *
                 light_[static_cast<std::size_t>((pixel.first_row + r) * cols_ + pixel.first_col + c)];
    pixel.left = pixel.codes - reader.CodesOf(light);
  }
}

bool CellUnmixer::Solve(const LightReader& reader, const CellMesh& mesh, std::span<Eigen::Vector3f> light) {
  rows_ = mesh.rows, cols_ = mesh.cols;
  pixels_.clear();
  const auto view = ViewOf(reader, mesh);
  if (!view) return false;
  Collect(reader, *view);
  if (pixels_.size() < light.size()) return false;
  const LightReader::Sharing shared = reader.chroma_sharing();
  const bool shares = shared.cols * shared.rows > 1;
  fine_.last = shares ? 1 : 3;
  SetUp(fine_);
  if (shares) {
    coarse_.footprint = static_cast<std::size_t>(shared.cols * shared.rows);
    coarse_.first = 1;
    SetUp(coarse_);
  }
  codes_.assign(light.size(), LightReader::Codes::Constant(kPriorCode));
  for (const bool again : {false, true}) {
    if (again) Predict(reader);
    Improve(fine_);
    if (shares) Improve(coarse_);
  }
  for (std::size_t cell = 0; cell < light.size(); ++cell) light[cell] = reader.LightOf(codes_[cell]);
  return true;
}

}  // namespace chequer
