#include "detect/fit/ink_register.h"

#include <Eigen/LU>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

Eigen::Matrix2d PriorOf(const Eigen::Vector2d& deviation) {
  return deviation.cwiseProduct(deviation).cwiseInverse().asDiagonal();
}

}  // namespace

void InkRegister::Add(const Corner& corner) {
  BoardGeometry::Derivative by_moves;
  by_moves.row(0) = corner.by->x;
  by_moves.row(1) = corner.by->y;
  // What lies farther along than the pattern has it, is where the pattern has what lies less far along.
  const Eigen::Matrix2d by_offset = (-corner.share).asDiagonal();
  const BoardGeometry::Derivative weighted = corner.information * by_moves;
  moves_.noalias() += by_moves.transpose() * weighted;
  common_.noalias() += weighted.transpose() * by_offset;
  offset_ += by_offset * corner.information * by_offset;
  moves_gradient_.noalias() += by_moves.transpose() * corner.gradient;
  offset_gradient_ += by_offset * corner.gradient;
}

void InkRegister::Scale(double factor) {
  moves_ *= factor;
  common_ *= factor;
  offset_ *= factor;
  moves_gradient_ *= factor;
  offset_gradient_ *= factor;
}

RegisterColumns InkRegister::Pulled() const {
  return -SmallCholesky<BoardGeometry::kParameters>(moves_).SolveEach(common_);
}

InkRegister::Step InkRegister::Solve(const Eigen::Vector2d& offset, const Eigen::Vector2d& deviation) const {
  const SmallCholesky<BoardGeometry::kParameters> factor(moves_);
  if (!factor.positive()) return {};
  const Eigen::Matrix2d prior = PriorOf(deviation);
  // The geometry follows the offset (Schur complement).
  const RegisterColumns pulled = -factor.SolveEach(common_);
  const BoardGeometry::Parameters alone = factor.Solve(moves_gradient_);
  const Eigen::Matrix2d left = offset_ + common_.transpose() * pulled + prior;
  const Eigen::Vector2d pull = offset_gradient_ - common_.transpose() * alone - prior * offset;
  Step step;
  step.offset = left.inverse() * pull;
  step.moves = alone + pulled * step.offset;
  if (!step.offset.allFinite() || !step.moves.allFinite()) return {};
  return step;
}

InkRegister::Known InkRegister::After(const BoardGeometry::Information& information,
                                      const Eigen::Vector2d& deviation) const {
  const RegisterColumns pulled = Pulled();
  const Eigen::Matrix2d by_corners = offset_ + common_.transpose() * pulled;
  const Eigen::Matrix2d covariance = (by_corners + PriorOf(deviation)).inverse();
  // Of the offset's covariance, a part is the corners' noise, and the rest what the prior keeps of the offset.
  const Eigen::Matrix2d by_noise = covariance * by_corners * covariance;
  Known known;
  known.by_prior = pulled * covariance * deviation.cwiseInverse().asDiagonal();
  const BoardGeometry::Information all = InverseOf(information) + pulled * by_noise * pulled.transpose();
  known.information = InverseOf(all);
  return known;
}

}  // namespace chequer
