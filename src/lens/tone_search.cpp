#include "lens/tone_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace chequer {
namespace {

/// Inks out of register, sharpening and dot gain fit better with a wrong curve by up to a half; the right one leaves a
/// fifth of what a wrong one does.
constexpr double kLeastFall = 0.5;
/// Bends are kept where they leave less than that share of what a gamma alone leaves.
constexpr double kBendsFall = 0.85;
constexpr std::array<double, 4> kStarts{1.0, 1.4, 1.8, 2.2};
/// Of the logarithm of gamma, of bends: first and last steps.
constexpr double kGammaStep = 0.08, kLastGammaStep = 0.008;
constexpr double kBendStep = 0.02, kLastBendStep = 0.003;
constexpr int kMostCalls = 150;

struct Tried {
  ToneCurve curve = ToneCurve::Srgb();
  double cost = 0;
};

/// A curve with a step of its gamma (which 0), or of one bend. Nothing where that is none.
std::optional<ToneCurve> MovedCurve(const ToneCurve& curve, std::size_t which, double step) {
  if (which > 0) {
    ToneCurve::Bends bends = curve.bends();
    bends[which - 1] += static_cast<float>(step);
    return curve.WithBends(bends);
  }
  const double gamma = (curve.is_srgb() ? 2.2 : curve.gamma()) * std::exp(step);
  if (!(gamma >= 0.2 && gamma <= 5)) return std::nullopt;
  return ToneCurve::Gamma(gamma).WithBends(curve.bends());
}

/// Of cameras whose values rise half as fast above a knee, white still being white.
ToneCurve::Bends BendsOfKnee(double knee) {
  const double most = knee + (1 - knee) / 2;
  ToneCurve::Bends bends{};
  for (std::size_t i = 0; i < bends.size(); ++i) {
    const double value = static_cast<double>(i + 1) / 8, raised = value * most;
    bends[i] = static_cast<float>((raised < knee ? raised : knee + 2 * (raised - knee)) - value);
  }
  return bends;
}

/// Of cameras that have more contrast in the middle, or less where `strength` is below 0.
ToneCurve::Bends BendsOfS(double strength) {
  ToneCurve::Bends bends{};
  for (std::size_t i = 0; i < bends.size(); ++i)
    bends[i] = static_cast<float>(strength * std::sin(std::numbers::pi * static_cast<double>(i + 1) / 4) /
                                  (2 * std::numbers::pi));
  return bends;
}

/// Hooke and Jeeves: steps along one parameter after the other, which are halved once none helps.
class CurveSearch {
 public:
  explicit CurveSearch(const ToneCost& cost) : cost_(cost) {}

  Tried Try(const ToneCurve& curve) {
    ++calls_;
    return {curve, cost_(curve)};
  }
  void Gamma(Tried& best) {
    for (double step = kGammaStep; step > kLastGammaStep && calls_ < kMostCalls; step /= 2) Along(0, step, best);
  }
  void Bends(Tried& best) {
    for (double step = kBendStep; step > kLastBendStep && calls_ < kMostCalls;) {
      const double before = best.cost;
      for (std::size_t which = 0; which <= best.curve.bends().size() && calls_ < kMostCalls; ++which)
        Along(which, which == 0 ? 2 * step : step, best);
      if (best.cost > 0.97 * before) step /= 2;
    }
  }

 private:
  /// Steps while that helps.
  void Along(std::size_t which, double step, Tried& best) {
    for (const double side : {step, -step}) {
      bool helped = false;
      while (calls_ < kMostCalls) {
        const auto curve = MovedCurve(best.curve, which, side);
        if (!curve) break;
        const Tried next = Try(*curve);
        if (!(next.cost < best.cost)) break;
        best = next;
        helped = true;
      }
      if (helped) return;
    }
  }

  const ToneCost& cost_;
  int calls_ = 0;
};

}  // namespace

std::optional<ToneCurve> SearchToneCurve(const ToneCurve& stated, const ToneCost& cost) {
  CurveSearch search(cost);
  const Tried start = search.Try(stated);
  Tried best = start;
  const auto consider = [&](const ToneCurve& curve) {
    if (const Tried tried = search.Try(curve); tried.cost < best.cost) best = tried;
  };
  for (const double gamma : kStarts) consider(ToneCurve::Gamma(gamma));
  search.Gamma(best);
  Tried bent = best;
  const auto consider_bent = [&](const std::optional<ToneCurve>& curve) {
    if (!curve) return;
    if (const Tried tried = search.Try(*curve); tried.cost < bent.cost) bent = tried;
  };
  for (const double knee : {0.5, 0.6, 0.7, 0.8}) consider_bent(ToneCurve::Srgb().WithBends(BendsOfKnee(knee)));
  for (const double strength : {-0.4, 0.4}) consider_bent(ToneCurve::Srgb().WithBends(BendsOfS(strength)));
  if (bent.curve.is_bent()) {
    search.Bends(bent);
    if (bent.cost < kBendsFall * best.cost) best = bent;
  }
  if (!(best.cost < kLeastFall * start.cost)) return std::nullopt;
  return best.curve;
}

}  // namespace chequer
