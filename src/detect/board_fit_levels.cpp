// Of BoardFit: the cells' levels, or those of each corner's quadrants, and what they tell of the light.
#include <algorithm>

#include "detect/board_fit.h"

namespace chequer {
namespace {

/// Of the board's mean: less light tells no colours.
constexpr double kLeastLit = 0.02;

/// Where a phase's samples lie in the light (R, G, B) of a cell.
float LightOf(const Eigen::Vector3f& light, int channels, int channel) {
  return channels == 3 ? light[channel] : RedAndGreen::Of(light[0], light[1]);
}

}  // namespace

void BoardFit::StartLevels(const LightReader& reader, const Start& start) {
  levels_.resize(start.light.size());
  float lightest = 0;
  for (std::size_t cell = 0; cell < levels_.size(); ++cell)
    for (std::size_t phase = 0; phase < 4; ++phase) {
      levels_[cell][phase] = LightOf(start.light[cell], reader.channels(), channel_of_phase_[phase]);
      lightest = std::max(lightest, levels_[cell][phase]);
    }
  noise_ = start.image ? start.image->noise : UnknownNoise(lightest);
  if (shadow_) {
    for (int cell = 0; cell < size_.rows * size_.cols; ++cell)
      for (float& level : levels_[static_cast<std::size_t>(cell)]) level /= static_cast<float>(LightOn(cell));
    return;
  }
  if (!own_levels_) return;
  cell_levels_ = levels_;
  levels_.resize(static_cast<std::size_t>(LevelCount(size_, true)));
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const QuadrantLevels own = LevelsOf(corner), cells = CellsAround(size_, corner);
    for (std::size_t i = 0; i < own.size(); ++i)
      levels_[static_cast<std::size_t>(own[i])] = cell_levels_[static_cast<std::size_t>(cells[i])];
  }
}

BoardFit::QuadrantLight BoardFit::LightAround(int corner) const {
  const std::size_t phase = static_cast<std::size_t>(TellingPhase());
  const int cell = pixels_.Cell(corner);
  const QuadrantLevels quadrants = LevelsOf(corner);
  const auto level = [&](std::size_t i) { return double{levels_[static_cast<std::size_t>(quadrants[i])][phase]}; };
  const double along = level(0) + level(3), across = level(1) + level(2);
  return IsDark(cell / size_.cols, cell % size_.cols) ? QuadrantLight{across, along} : QuadrantLight{along, across};
}

double BoardFit::Contrast(int corner) const {
  const QuadrantLight around = LightAround(corner);
  return (around.light - around.dark) / 2;
}

BoardFit::CornerLights BoardFit::LightOnCorners() const {
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

void BoardFit::EvenOutLevels() {
  const CornerLights lights = LightOnCorners();
  const std::size_t cells = static_cast<std::size_t>(size_.rows * size_.cols);
  result_.lit.assign(cells, {});
  cell_levels_.assign(cells, PhaseValues{});
  std::array<float, kMaxCells> weight{};
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const float here = static_cast<float>(lights[static_cast<std::size_t>(corner)]);
    if (here == 0) continue;
    const QuadrantLevels own = LevelsOf(corner), around = CellsAround(size_, corner);
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

std::span<const LitPart> BoardFit::LitParts(std::span<const std::uint8_t> saturated) {
  const std::size_t phase = static_cast<std::size_t>(TellingPhase());
  lit_parts_.clear();
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!used_[static_cast<std::size_t>(corner)]) continue;
    const CornerPlace& place = pixels_.place(corner);
    const QuadrantLevels own = LevelsOf(corner), cells = CellsAround(size_, corner);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (IsDark(cells[i] / size_.cols, cells[i] % size_.cols)) continue;
      // Of a corner's pixels, half of a cell on each side or, at the rim, more.
      const auto middle_of = [](double middle, bool far_side) {
        return far_side ? std::max(0.25, middle + 0.25) : std::min(-0.25, middle - 0.25);
      };
      lit_parts_.push_back({place.board + Eigen::Vector2d(middle_of(place.middle.x(), i % 2 == 1),
                                                          middle_of(place.middle.y(), i / 2 == 1)),
                            levels_[static_cast<std::size_t>(own[i])][phase],
                            saturated[static_cast<std::size_t>(cells[i])] != 0});
    }
  }
  return lit_parts_;
}

double BoardFit::LightOn(int cell) const { return shadow_->At(MiddleOfCell(size_, cell)); }

void BoardFit::TellLevels() {
  result_.lit.clear();
  if (shadow_)
    for (int cell = 0; cell < size_.rows * size_.cols; ++cell) {
      const float light = static_cast<float>(LightOn(cell));
      result_.lit.push_back({light, light});
    }
  if (own_levels_) EvenOutLevels();
  const std::vector<PhaseValues>& levels = own_levels_ ? cell_levels_ : levels_;
  result_.levels.resize(levels.size());
  for (std::size_t cell = 0; cell < levels.size(); ++cell) {
    result_.levels[cell].setZero();
    for (std::size_t phase = 0; phase < 4; ++phase)
      result_.levels[cell][channel_of_phase_[phase]] = levels[cell][phase];
  }
}

}  // namespace chequer
