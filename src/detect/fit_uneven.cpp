// Of PhotometricFit: boards that shadows cross.
#include <algorithm>

#include "detect/fit.h"

namespace chequer {
namespace {

/// A corner that fits so much worse than the median one may be crossed by the edge of a shadow.
constexpr double kUnevenMisfit = 3;
/// Levels of their own for each corner's quadrants leave a board that a shadow crosses as clear as it was, where most
/// of the edge was found hidden, or make it clearer.
constexpr double kAsClearByOwn = 0.95;
/// Of the lights on a board where no cell is crossed by used corners' account: the most over the least of a shadow.
/// Light that falls off by less is told better by the cells' levels.
constexpr float kShadow = 1.6f;
/// Of the board's mean: less light tells no colours.
constexpr double kLeastLit = 0.02;

}  // namespace

bool PhotometricFit::MayBeUnevenlyLit() const {
  if (!smear_px_.isZero() || misfit_spread_ <= kUnevenMisfit) return false;
  if (std::find(left_out_.begin(), left_out_.end(), true) != left_out_.end()) return true;
  std::array<double, kMaxCorners> misfits;
  std::size_t count = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    if (used_[static_cast<std::size_t>(corner)]) misfits[count++] = Misfit(corner);
  const auto past = misfits.begin() + static_cast<std::ptrdiff_t>(count),
             middle = misfits.begin() + static_cast<std::ptrdiff_t>(count / 2);
  if (count == 0) return false;
  const double most = *std::max_element(misfits.begin(), past);
  std::nth_element(misfits.begin(), middle, past);
  return most > kUnevenMisfit * *middle;
}

void PhotometricFit::FitUnevenlyLit(const LightReader& reader, const Lens& lens, const Start& start) {
  evenly_lit_ = result_;
  const std::array<bool, kMaxCorners> left_out_before = left_out_;
  left_out_.fill(false);
  own_levels_ = true;
  if (FitAnew(reader, lens, start) && !take_out_) {
    LeaveOutHidden(reader, lens, start);
    const double clearer = result_.signal_to_noise / evenly_lit_.signal_to_noise;
    if (clearer > kAsClearByOwn && InShadow()) return;
  }
  own_levels_ = false;
  left_out_ = left_out_before;
  result_ = evenly_lit_;
}

bool PhotometricFit::InShadow() const {
  CellLight board;
  for (const CellLight& lit : result_.lit) {
    if (lit.crossed()) return true;
    if (lit.most == 0) continue;
    board = {board.most == 0 ? lit.least : std::min(board.least, lit.least), std::max(board.most, lit.most)};
  }
  return board.most > kShadow * board.least;
}

PhotometricFit::CornerLights PhotometricFit::LightOnCorners() const {
  CornerLights lights{};
  double sum = 0;
  int count = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!used_[static_cast<std::size_t>(corner)]) continue;
    double& here = lights[static_cast<std::size_t>(corner)];
    here = std::max(LightAround(corner).light, 0.0);
    sum += here;
    ++count;
  }
  const double mean = std::max(sum / std::max(count, 1), 1e-6);
  for (double& light : lights)
    if (light > 0) light = std::max(light / mean, kLeastLit);
  return lights;
}

void PhotometricFit::EvenOutLevels() {
  const CornerLights lights = LightOnCorners();
  const std::size_t cells = static_cast<std::size_t>(size_.rows * size_.cols);
  result_.lit.assign(cells, {});
  cell_levels_.assign(cells, PhaseValues{});
  std::array<float, kMaxCells> weight{};
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const float here = static_cast<float>(lights[static_cast<std::size_t>(corner)]);
    if (here == 0) continue;
    const QuadrantLevels own = LevelsOf(corner), around = LevelsAround(size_, corner, false);
    for (std::size_t i = 0; i < around.size(); ++i) {
      const std::size_t cell = static_cast<std::size_t>(around[i]);
      CellLight& lit = result_.lit[cell];
      lit.least = lit.most == 0 ? here : std::min(lit.least, here);
      lit.most = std::max(lit.most, here);
      // Where there is more light, less of the level is noise.
      weight[cell] += here;
      for (std::size_t p = 0; p < 4; ++p) cell_levels_[cell][p] += levels_[static_cast<std::size_t>(own[i])][p];
    }
  }
  for (std::size_t cell = 0; cell < cells; ++cell)
    if (weight[cell] > 0)
      for (float& level : cell_levels_[cell]) level /= weight[cell];
}

}  // namespace chequer
