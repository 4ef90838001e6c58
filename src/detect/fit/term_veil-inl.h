// A veil: light that lies over dark cells and light ones alike, and on which no shadow falls (haze, what glossy paper
// mirrors of a bright room, a black level that the camera has not taken off). In even light it is a part of the levels;
// beside terms that change the light, levels are those without it. Of the colour of white paper. shading.h has it where
// no term changes the light.
#ifndef CHEQUER_DETECT_TERM_VEIL
#define CHEQUER_DETECT_TERM_VEIL

#include <algorithm>

#include "detect/fit/term.h"

namespace chequer {

struct VeilTerm {
  static constexpr int kColumns = 1;  ///< over the light of white paper
  enum Lane { kWhiteUnderVeil, kLanes };
  struct Input {
    float veil = 0;
  };

  bool veiled = false;
  double veil = 0;
  PhaseValues veil_white{};  ///< light of white paper

  bool on() const { return veiled; }

  void Start(const PhaseValues& white) {
    veiled = true;
    veil_white = white;
  }

  void LightAt(const Eigen::Vector2d& /*board*/, LightThere& light) const {
    for (std::size_t phase = 0; phase < veil_white.size(); ++phase)
      light.more[phase] += static_cast<float>(veil) * veil_white[phase];
  }

  void SetInput(double /*blur_px*/, bool /*roughly*/, Input& input) const { input = {static_cast<float>(veil)}; }

  template <class Set>
  void SetLanes(const Input& /*input*/, const TermCorner& /*corner*/, const Set& set) const {
    set(kWhiteUnderVeil, veil_white);
  }

  template <class Vector>
  void AddPrior(Vector information, Vector pull) const {
    constexpr double kKnownTo = 0.15;  // a standard deviation: haze, and as for the shading's
    using Unknown = Eigen::Matrix<double, 1, 1>;
    SetPrior<Unknown>(Unknown(kKnownTo), Unknown(-veil), information, pull);
  }

  double Move(const TermStep& step) {
    // Longer steps lead elsewhere; then what no longer counts. A black level may be above the darkest light.
    constexpr double kMostStep = 0.2, kStill = 0.001, kLeast = -0.2, kMost = 0.7;
    const double before = veil;
    veil = std::clamp(veil + std::clamp(step.of[0], -kMostStep, kMostStep), kLeast, kMost);
    return step.Make(0, veil - before, kStill);
  }
};

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERM_VEIL

#ifdef CHEQUER_TERMS_ON_LANES

template <>
struct OnLanes<VeilTerm> {
  static HWY_INLINE void Bend(const VeilTerm::Input& s, const LaneModel& m, V /*x*/, V /*y*/,
                              const PowerTerms& /*gaussian*/, Picture& p, V* by) {
    by[0] = m.of<VeilTerm>(VeilTerm::kWhiteUnderVeil);
    p.light = hn::MulAdd(Splat(s.veil), by[0], p.light);
  }
};

#endif  // CHEQUER_TERMS_ON_LANES
