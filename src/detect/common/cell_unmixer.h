#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "detect/common/light.h"

namespace chequer {

/// Cells in an image: cell (row, col) covers [col, col + 1] × [row, row + 1] of the cells' plane. The outermost ones
/// are a rim: they take up what samples get from beside the board.
struct CellMesh {
  Eigen::Matrix3d image_from_cells = Eigen::Matrix3d::Identity();
  int rows = 0, cols = 0;  ///< with the rim, at least 3 each
  /// Standard deviation of the image's PSF, the pixels' area included; the default is usual before a fit tells it.
  float blur_px = 0.8f;
};

/// Reads cells that are too small for windows within them. Each sample of the image is the mean of the cells under its
/// footprint (the pixels that share it, and the blur): the cells' codes are the least-squares solution of that, one
/// system for all channels with the same footprint. Full colour has footprints of one pixel, subsampled chroma of
/// 2 × 1 or 2 × 2; what a mosaic's interpolation blurs is a part of the mesh's blur. As light mixes and codes do not, a
/// second step solves for what the first leaves of the samples when its cells are mixed as light. Every run begins anew;
/// only memory is kept.
class CellUnmixer {
 public:
  /// Whether windows within cells of that width hold whole samples of every channel that neighbours do not reach: then
  /// nothing needs to be unmixed.
  static bool WindowsAreClear(const LightReader& reader, double short_side_px, double blur_px);

  /// Writes the light (R, G, B) of each cell, row by row, the rim's too. False, and nothing is written, where too few of
  /// the cells' samples lie in the image.
  /// @pre light.size() = rows × cols.
  bool Solve(const LightReader& reader, const CellMesh& mesh, std::span<Eigen::Vector3f> light);
  /// How many the last Solve() looked at.
  std::size_t pixels() const { return pixels_.size(); }

 private:
  struct Pixel {
    int first_col = 0, first_row = 0;   ///< of the 3 × 3 cells that it sees
    std::array<float, 3> col{}, row{};  ///< the shares of their columns and rows
    LightReader::Codes codes = LightReader::Codes::Zero();  ///< what is seen
    LightReader::Codes left = LightReader::Codes::Zero();   ///< residual: codes less what the cells explain so far
  };
  struct Share {
    std::size_t cell = 0;
    float share = 0;
  };
  /// Normal equations of channels with one footprint: L D Lᵀ, with L below the diagonal and 1 / D on it.
  struct Equations {
    std::size_t footprint = 1;  ///< pixels
    int first = 0, last = 3;    ///< channels
    std::size_t band = 0;       ///< of L
    std::vector<float> factor;
  };
  /// Where the mesh lies in the image.
  struct View {
    Eigen::Matrix3f cells_from_image = Eigen::Matrix3f::Identity();
    float sharp_col = 1, sharp_row = 1;  ///< standard deviations of the blur in a cell
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
  };

  std::optional<View> ViewOf(const LightReader& reader, const CellMesh& mesh) const;
  std::optional<Pixel> PixelAt(int x, int y, const View& view) const;
  void Collect(const LightReader& reader, const View& view);
  /// The shares of cells in the mean of some pixels, into shares_ by growing cell. Returns how many.
  std::size_t SharesOf(std::span<const Pixel> pixels);
  void SetUp(Equations& equations);
  void Factorize(Equations& equations) const;
  /// Adds to the cells' codes what explains most of what is left.
  void Improve(const Equations& equations);
  /// What the cells leave of the samples.
  void Predict(const LightReader& reader);

  int rows_ = 0, cols_ = 0;
  std::vector<Pixel> pixels_;  ///< those of a sample follow each other
  std::array<Share, 36> shares_;
  Equations fine_, coarse_;  ///< of what each pixel has, and of what pixels share
  std::vector<LightReader::Codes> codes_, right_side_;
  std::vector<Eigen::Vector3f> light_;
};

}  // namespace chequer
