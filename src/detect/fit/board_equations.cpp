#include "detect/fit/board_equations.h"

#include <algorithm>
#include <memory>

#include "detect/fit/board_system.h"

namespace chequer {
namespace {

static_assert(BoardSystem::kColumns == BoardEquations::kUnknowns + 1);
static_assert(sizeof(BoardEquations::CornerShift) == 5 * sizeof(double));

/// Added to the diagonal of the levels, whose entries count pixels over their variance: cells that nothing has seen
/// stay where they are.
constexpr float kLeastInformation = 1e-3f;
/// Floats of a corner's derivatives when each is there for four phases.
constexpr int kRepeated = 2 * 4 * BoardGeometry::kParameters;

/// Each phase's own channel of a mosaic, or one for all.
PhaseShares SharesOf(int red_phase, float* phase_weight) {
  PhaseShares shares{{1, 1, 1, 1}, 1};
  std::fill_n(phase_weight, 4, 0.0f);
  if (red_phase < 0) {
    phase_weight[0] = 1;
    return shares;
  }
  // Green are the two phases beside the red one; they hold the same sums and count once.
  shares = {{0, 0, 0, 0}, 0};
  shares.opposite[red_phase ^ 1] = shares.opposite[red_phase ^ 2] = 1;
  phase_weight[red_phase] = phase_weight[3 - red_phase] = phase_weight[red_phase ^ 1] = 1;
  return shares;
}

}  // namespace

int LevelCount(MarkerSize size, bool own_levels) { return own_levels ? 4 * CornerCount(size) : size.rows * size.cols; }

void BoardEquations::Prepare(MarkerSize size, bool own_levels) {
  cells_ = LevelCount(size, own_levels);
  band_ = own_levels ? 3 : size.cols + 1;
  constexpr int kVector = 16;
  matrix_row_ = (4 * band_ + BoardSystem::kColumnTail + kVector - 1) / kVector * kVector;
  const std::size_t matrix = static_cast<std::size_t>(cells_ * matrix_row_),
                    right = static_cast<std::size_t>(cells_ * BoardSystem::kRightRow);
  floats_.resize(std::max(floats_.size(), matrix + right + kVector));
  void* start = floats_.data();
  std::size_t room = floats_.size() * sizeof(float);
  matrix_ = static_cast<float*>(std::align(kVector * sizeof(float), (matrix + right) * sizeof(float), start, room));
  right_ = matrix_ + matrix;
}

BoardSystem BoardEquations::System() const {
  BoardSystem system;
  system.cells = cells_;
  system.band = band_;
  system.matrix_row = matrix_row_;
  system.matrix = matrix_;
  system.right = right_;
  return system;
}

void BoardEquations::SetDerivatives(std::span<const CornerDerivative> derivatives) {
  derivatives_ = derivatives;
  repeated_.resize(derivatives.size() * kRepeated);
  float* to = repeated_.data();
  for (const CornerDerivative& by : derivatives)
    for (const BoardGeometry::Parameters* axis : {&by.x, &by.y})
      for (int k = 0; k < BoardGeometry::kParameters; ++k, to += 4)
        Eigen::Map<Eigen::Array4f>(to).setConstant(static_cast<float>((*axis)[k]));
}

int BoardEquations::DescribeCorners(const Input& input, CornerTerms* terms) const {
  const BoardPixels& pixels = *input.pixels;
  int count = 0;
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (input.hidden[static_cast<std::size_t>(corner)] != Hidden::kNot || pixels.Lane(corner) >= input.lanes) continue;
    const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
    const float* repeated = repeated_.data() + corner * kRepeated;
    const QuadrantLevels levels = LevelsAround(pixels.size(), corner, input.own_levels);
    terms[count++] = {.corner = corner,
                      .lane = pixels.Lane(corner),
                      .cell_of = {levels[0], levels[1], levels[2], levels[3]},
                      .by_x = by.x.data(),
                      .by_y = by.y.data(),
                      .repeated_x = repeated,
                      .repeated_y = repeated + kRepeated / 2};
  }
  return count;
}

void BoardEquations::Assemble(const Input& input) {
  const BoardPixels& pixels = *input.pixels;
  const MarkerSize size = pixels.size();
  if (!input.fixed_levels) Prepare(size, input.own_levels);
  BoardSystem system = System();
  system.fixed_levels = input.fixed_levels;
  const PhaseShares shares = SharesOf(input.red_phase, system.phase_weight);
  std::copy_n(system.phase_weight, 4, phase_weight_.begin());
  const LaneBlock& lanes = pixels.lanes();
  std::array<CornerTerms, kMaxCorners> corners;
  const int count = DescribeCorners(input, corners.data());
  lanes_ = lanes.padded();
  merged_.resize(static_cast<std::size_t>(kProductSums * lanes_));
  SolveBoard(corners.data(), count, {lanes.sum_data(0), lanes.padded()}, std::min(input.lanes, lanes.padded()), shares,
             kLeastInformation, merged_.data(), system);
  for (int a = 0; a < kUnknowns; ++a) {
    for (int b = a; b < kUnknowns; ++b) normal_(a, b) = normal_(b, a) = system.normal[a][b];
    gradient_[a] = system.normal[a][kUnknowns];
  }
  chi_square_ = system.normal[kUnknowns][kUnknowns];
}

void BoardEquations::MoveLevels(const Vector& step, std::span<PhaseValues> levels) {
  BoardSystem system = System();
  std::array<float, kUnknowns> unknowns;
  for (int i = 0; i < kUnknowns; ++i) unknowns[static_cast<std::size_t>(i)] = static_cast<float>(step[i]);
  SolveLevels(unknowns.data(), system);
  for (int cell = 0; cell < cells_; ++cell)
    for (std::size_t phase = 0; phase < 4; ++phase)
      levels[static_cast<std::size_t>(cell)][phase] += right_[cell * BoardSystem::kRightRow + static_cast<int>(phase)];
}

void BoardEquations::FindShifts(const Input& input, const Vector& step, std::span<CornerShift> shifts) const {
  std::array<CornerTerms, kMaxCorners> corners;
  const int count = DescribeCorners(input, corners.data());
  FindCornerShifts(corners.data(), count, {merged_.data(), lanes_}, right_, phase_weight_.data(), step.data(),
                   &shifts.data()->xx);
}

}  // namespace chequer
