#include "marker/likelihoods.h"

#include <bit>
#include <cstddef>

#include "chequer/check.h"

namespace chequer {

Likelihoods LikelihoodsOfCells(std::span<const float> ratio_of_cell) {
  Likelihoods result;
  CHEQUER_CHECK(ratio_of_cell.size() <= result.ratio.size(), "more cells than a kernel can have");
  result.bits = static_cast<int>(ratio_of_cell.size());
  for (std::size_t cell = 0; cell < ratio_of_cell.size(); ++cell) {
    CHEQUER_CHECK(std::isfinite(ratio_of_cell[cell]), "a log-likelihood ratio is not finite");
    result.ratio[ratio_of_cell.size() - 1 - cell] = static_cast<double>(ratio_of_cell[cell]);
  }
  ClassifyBits(result);
  return result;
}

void ClassifyBits(Likelihoods& likelihoods) {
  likelihoods.hard = 0;
  likelihoods.known = 0;
  for (int bit = 0; bit < likelihoods.bits; ++bit) {
    const double ratio = likelihoods.ratio[static_cast<std::size_t>(bit)];
    likelihoods.hard |= std::uint64_t{ratio > 0} << bit;
    likelihoods.known |= std::uint64_t{ratio != 0} << bit;
  }
}

double CostOf(const Likelihoods& likelihoods, std::uint64_t kernel) {
  double cost = 0;
  for (std::uint64_t contradicted = kernel ^ likelihoods.hard; contradicted != 0; contradicted &= contradicted - 1) {
    cost += likelihoods.Cost(std::countr_zero(contradicted));
  }
  return cost;
}

int CountContradicted(const Likelihoods& likelihoods, std::uint64_t kernel) {
  return std::popcount((kernel ^ likelihoods.hard) & likelihoods.known);
}

}  // namespace chequer
