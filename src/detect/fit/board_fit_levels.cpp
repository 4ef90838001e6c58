// Of BoardFit: the cells' levels, or those of each corner's quadrants, and what they tell of the light.
#include <algorithm>

#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// Of the board's mean: less light tells no colours.
constexpr double kLeastLit = 0.02;
/// In smaller cells, levels do not tell a lamp's image (a guess).
constexpr double kLeastHighlitCellPx = 4;

/// Where a phase's samples lie in the light (R, G, B) of a cell.
float LightOf(const Eigen::Vector3f& light, int channels, int channel) {
  return channels == 3 ? light[channel] : RedAndGreen::Of(light[0], light[1]);
}

/// The least contrast that is taken to be left: with less, little says what it was.
constexpr double kLeastKept = 0.3;

/// What a motion leaves of the contrast between cells as sampled. @param way cells. @param half width of the window.
double ContrastKept(const Eigen::Vector2d& way, double half) {
  constexpr int kPoints = 8;
  const auto light = [&](double at) {
    const double off = std::abs(at - 2 * std::round(at / 2));
    return std::clamp((0.5 - off) / half, -1.0, 1.0);
  };
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector2d at = ((i + 0.5) / kPoints - 0.5) * way;
    sum += light(at.x()) * light(at.y());
  }
  return std::max(sum / kPoints, kLeastKept);
}

}  // namespace

void BoardFit::SharpenLevels() {
  const double kept = ContrastKept(BoardByPixel() * run_->model.motion_px, SampledHalfPx(CellPx()) / CellPx());
  std::array<PhaseValues, 2> mean{};
  const auto colour = [&](std::size_t cell) {
    const int i = static_cast<int>(cell);
    return IsDark(i / run_->view.size.cols, i % run_->view.size.cols) ? std::size_t{0} : std::size_t{1};
  };
  std::array<float, 2> count{};
  for (std::size_t cell = 0; cell < run_->model.levels.size(); ++cell) {
    count[colour(cell)] += 1;
    for (std::size_t phase = 0; phase < 4; ++phase) mean[colour(cell)][phase] += run_->model.levels[cell][phase];
  }
  for (std::size_t cell = 0; cell < run_->model.levels.size(); ++cell)
    for (std::size_t phase = 0; phase < 4; ++phase) {
      const float half = 0.5f * (mean[1][phase] / count[1] - mean[0][phase] / count[0]);
      run_->model.levels[cell][phase] += (colour(cell) ? half : -half) * static_cast<float>(1 / kept - 1);
    }
}

void BoardFit::StartLevels(const LightReader& reader, const Start& start) {
  run_->model.levels.resize(start.light.size());
  float lightest = 0;
  for (std::size_t cell = 0; cell < run_->model.levels.size(); ++cell)
    for (std::size_t phase = 0; phase < 4; ++phase) {
      run_->model.levels[cell][phase] =
          LightOf(start.light[cell], reader.channels(), run_->view.channel_of_phase[phase]);
      lightest = std::max(lightest, run_->model.levels[cell][phase]);
    }
  if (run_->view.overexposed && start.light_levels.known()) StartLightLevels(start);
  if (run_->model.MotionTerm::on()) SharpenLevels();
  run_->model.noise = start.image ? start.image->noise : UnknownNoise(lightest);
  if (run_->model.LightVaries()) {
    for (int cell = 0; cell < run_->view.size.rows * run_->view.size.cols; ++cell) {
      const LightThere light = LightOn(cell);
      PhaseValues& levels = run_->model.levels[static_cast<std::size_t>(cell)];
      for (std::size_t phase = 0; phase < 4; ++phase) levels[phase] = light.Of(levels[phase], phase);
    }
    return;
  }
  if (!run_->model.own_levels) return;
  run_->told.cell_levels = run_->model.levels;
  run_->model.levels.resize(static_cast<std::size_t>(LevelCount(run_->view.size, true)));
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const QuadrantLevels own = LevelsOf(corner), cells = CellsAround(run_->view.size, corner);
    for (std::size_t i = 0; i < own.size(); ++i)
      run_->model.levels[static_cast<std::size_t>(own[i])] = run_->told.cell_levels[static_cast<std::size_t>(cells[i])];
  }
}

void BoardFit::StartLightLevels(const Start& start) {
  ForCells(run_->view.size, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col)) return;
    const Eigen::Vector3f& known = start.light_levels.of_ink[start.saturated[cell] != 0];
    for (std::size_t phase = 0; phase < 4; ++phase) {
      float& level = run_->model.levels[cell][phase];
      if (level >= LightLevels::kOverexposed) level = std::max(level, known[run_->view.channel_of_phase[phase]]);
    }
  });
}

void BoardFit::StartFrom(const BoardRun& run) {
  BoardModel& model = run_->model;
  model.noise = run.model.noise;
  // Dot gain that was not known has looked like blur.
  const bool less_blur = model.DotGainTerm::on() && !run.model.DotGainTerm::on();
  model.blur_px = less_blur ? std::min(model.blur_px, run.model.blur_px) : run.model.blur_px;
  // The plain model's blur has that of a short motion in it.
  if (model.MotionTerm::on() && !run.terms.look_farther) model.TakeOutOf(model.blur_px);
  model.blur_shape = run.model.blur_shape;
  model.edges = run.model.edges;
  if (model.LightVaries() != run.model.LightVaries()) return;
  if (model.own_levels != run.model.own_levels) return;
  model.levels = run.model.levels;
  // Its pixels were evened out, these are not.
  Shade(model.levels, run.light.shading, run.light.veil);
}

BoardFit::QuadrantLight BoardFit::LightAround(int corner) const {
  const std::size_t phase = static_cast<std::size_t>(TellingPhase());
  const int row = corner / (run_->view.size.cols - 1),
            col = corner % (run_->view.size.cols - 1);  // the first cell's too
  const QuadrantLevels quadrants = LevelsOf(corner);
  const auto level = [&](std::size_t i) {
    return double{run_->model.levels[static_cast<std::size_t>(quadrants[i])][phase]};
  };
  const double along = level(0) + level(3), across = level(1) + level(2);
  return IsDark(row, col) ? QuadrantLight{across, along} : QuadrantLight{along, across};
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
    if (!used(corner)) continue;
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
  const std::size_t cells = static_cast<std::size_t>(run_->view.size.rows * run_->view.size.cols);
  run_->result.lit.assign(cells, {});
  run_->told.cell_levels.assign(cells, PhaseValues{});
  std::array<float, kMaxCells> weight{};
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const float here = static_cast<float>(lights[static_cast<std::size_t>(corner)]);
    if (here == 0) continue;
    const QuadrantLevels own = LevelsOf(corner), around = CellsAround(run_->view.size, corner);
    for (std::size_t i = 0; i < around.size(); ++i) {
      const std::size_t cell = static_cast<std::size_t>(around[i]);
      CellLight& lit = run_->result.lit[cell];
      lit.least = lit.most == 0 ? here : std::min(lit.least, here);
      lit.most = std::max(lit.most, here);
      // Where there is more light, less of the level is noise.
      weight[cell] += here;
      for (std::size_t p = 0; p < 4; ++p)
        run_->told.cell_levels[cell][p] += run_->model.levels[static_cast<std::size_t>(own[i])][p];
    }
  }
  for (std::size_t cell = 0; cell < cells; ++cell)
    if (weight[cell] > 0)
      for (float& level : run_->told.cell_levels[cell]) level /= weight[cell];
}

std::span<const LitPart> BoardFit::LitParts(std::span<const std::uint8_t> saturated) {
  const std::size_t phase = static_cast<std::size_t>(TellingPhase());
  run_->told.lit_parts.clear();
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!used(corner)) continue;
    const CornerPlace& place = pixels_.place(corner);
    const QuadrantLevels own = LevelsOf(corner), cells = CellsAround(run_->view.size, corner);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (IsDark(cells[i] / run_->view.size.cols, cells[i] % run_->view.size.cols)) continue;
      // Of a corner's pixels, half of a cell on each side or, at the rim, more.
      const auto middle_of = [](double middle, bool far_side) {
        return far_side ? std::max(0.25, middle + 0.25) : std::min(-0.25, middle - 0.25);
      };
      run_->told.lit_parts.push_back({place.board + Eigen::Vector2d(middle_of(place.middle.x(), i % 2 == 1),
                                                                    middle_of(place.middle.y(), i / 2 == 1)),
                                      run_->model.levels[static_cast<std::size_t>(own[i])][phase],
                                      saturated[static_cast<std::size_t>(cells[i])] != 0});
    }
  }
  return run_->told.lit_parts;
}

std::optional<HighlightTerm> BoardFit::FindHighlight(std::span<const std::uint8_t> saturated,
                                                     std::span<const Hidden> hidden) const {
  if (!run_->model.LitEvenly() || CellPx() < kLeastHighlitCellPx) return std::nullopt;
  return HighlightTerm::Find(
      {run_->view.size, run_->model.levels, saturated, hidden, static_cast<std::size_t>(TellingPhase())});
}

LightThere BoardFit::LightOn(int cell) const { return run_->model.LightAt(MiddleOfCell(run_->view.size, cell)); }

void BoardFit::TellLevels() {
  run_->result.lit.clear();
  if (run_->model.shadow)
    for (int cell = 0; cell < run_->view.size.rows * run_->view.size.cols; ++cell) {
      const float light = static_cast<float>(LightOn(cell).share);
      run_->result.lit.push_back({light, light});
    }
  if (run_->model.own_levels) EvenOutLevels();
  const std::vector<PhaseValues>& levels = run_->model.own_levels ? run_->told.cell_levels : run_->model.levels;
  run_->result.levels.resize(levels.size());
  for (std::size_t cell = 0; cell < levels.size(); ++cell) {
    run_->result.levels[cell].setZero();
    for (std::size_t phase = 0; phase < 4; ++phase)
      run_->result.levels[cell][run_->view.channel_of_phase[phase]] = levels[cell][phase];
  }
}

}  // namespace chequer
