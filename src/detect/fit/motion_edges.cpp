#include "detect/fit/motion_edges.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "detect/common/normal_integral.h"
#include "detect/fit/edge_spread.h"

namespace chequer {
namespace {

/// A way that has less of the variance leaves edges a Gaussian's to 3e-5 of their light. (With 0.1, overexposed boards
/// that turn were off by more than noise where their way was that short.)
constexpr double kLeastWayShare = 0.03;
/// A box's fourth cumulant is −1.2 squares of its variance. Of the bivariate Edgeworth series, the cumulants of three
/// and one count a sixth, that of two and two a quarter, beside half the correlation's square: −1.2 / 6, and 1 / 2
/// − 1.2 / 4 (Barndorff-Nielsen and Cox, "Edgeworth and saddle-point approximations", 1979).
constexpr double kAtCorner = 0.2;

/// Of a blur of variance 1, of which a box has a share: what an edge sends to pixels on its dark side.
double Beyond(double share, double distance) {
  if (share == 0) return NormalIntegral(-distance);
  const double half = std::sqrt(3 * share), rest = std::sqrt(1 - share);
  return (NormalRamp((half - distance) / rest) - NormalRamp((-half - distance) / rest)) * rest / (2 * half);
}

/// By the share, what a box makes of a Gaussian's terms.
class BoxTerms {
 public:
  static const BoxTerms& Get() {
    static const BoxTerms terms;
    return terms;
  }

  void AddTo(double share, EdgeTerms& edge) const {
    const double at = std::clamp(share / kStep, 0.0, kNodes - 1.0);
    const std::size_t node = std::min(static_cast<std::size_t>(at), kNodes - 2);
    const float part = static_cast<float>(at - static_cast<double>(node));
    // Fourth cumulants add up; that of the lens is now over the square of a larger variance.
    const float of_lens = static_cast<float>((1 - share) * (1 - share));
    const EdgeTerms gaussian;
    for (std::size_t i = 0; i < edge.by_power.size(); ++i) {
      const float box = nodes_[node][i] + part * (nodes_[node + 1][i] - nodes_[node][i]);
      edge.by_power[i] = gaussian.by_power[i] + of_lens * (edge.by_power[i] - gaussian.by_power[i]) + box;
    }
  }

 private:
  /// Up to what is left of the lens at least (BlurShapeFit), across the way.
  static constexpr std::size_t kNodes = 29;
  static constexpr double kStep = 1.0 / 32;

  BoxTerms() {
    std::array<double, kProfileSamples> beyond;
    EdgeTerms gaussian;
    for (std::size_t node = 0; node < kNodes; ++node) {
      for (std::size_t i = 0; i < beyond.size(); ++i)
        beyond[i] = Beyond(static_cast<double>(node) * kStep, static_cast<double>(i + 1) * kProfileStep);
      const EdgeTerms terms = TermsOfProfile(beyond);
      if (node == 0) gaussian = terms;
      for (std::size_t i = 0; i < terms.by_power.size(); ++i)
        nodes_[node][i] = terms.by_power[i] - gaussian.by_power[i];
    }
  }

  std::array<std::array<float, EdgeTerms::kTerms>, kNodes> nodes_;
};

}  // namespace

void AddMotion(const WayInBlur& way, KernelInput& input) {
  const bool counts = std::max(way.share_x, way.share_y) >= kLeastWayShare;
  input.narrower_x = counts ? static_cast<float>(way.narrower_x) : 0;
  input.narrower_y = counts ? static_cast<float>(way.narrower_y) : 0;
  if (!counts) return;
  BoxTerms::Get().AddTo(way.share_x, input.edge_x);
  BoxTerms::Get().AddTo(way.share_y, input.edge_y);
  const float of_lens = static_cast<float>((1 - way.share_x) * (1 - way.share_y));
  input.corner.square *= of_lens;
  input.corner.product *= of_lens;
  input.corner.moved_x = static_cast<float>(-kAtCorner * way.skew * way.share_x);
  input.corner.moved_y = static_cast<float>(-kAtCorner * way.skew * way.share_y);
  input.corner.moved_product = static_cast<float>(kAtCorner * way.skew * way.skew);
}

}  // namespace chequer
