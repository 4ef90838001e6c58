// The terms that a board's model may have (term.h): a line for its file, and its name in the list, in the order in
// which they bend the light. Their part for vectors is included again, once for each kind of them (model_light-inl.h).
#include "detect/fit/term_dot_gain-inl.h"
#include "detect/fit/term_highlight-inl.h"
#include "detect/fit/term_motion-inl.h"
#include "detect/fit/term_shading-inl.h"
#include "detect/fit/term_shadow-inl.h"
#include "detect/fit/term_uneven_blur-inl.h"
#include "detect/fit/term_veil-inl.h"

#ifndef CHEQUER_DETECT_TERMS
#define CHEQUER_DETECT_TERMS

namespace chequer {

using Terms = TermList<MotionTerm, DotGainTerm, ShadowTerm, ShadingTerm, VeilTerm, HighlightTerm, UnevenBlurTerm>;

/// Which terms a model has.
class ModelTerms {
 public:
  template <class Term>
  bool& on() {
    return on_[Terms::BeforeTerm<Term>().terms];
  }
  template <class Term>
  bool on() const {
    return on_[Terms::BeforeTerm<Term>().terms];
  }
  /// The same with these.
  template <class... Term>
  ModelTerms With() const {
    ModelTerms more = *this;
    ((more.on<Term>() = true), ...);
    return more;
  }
  bool any() const {
    return std::any_of(std::begin(on_), std::end(on_), [](bool on) { return on; });
  }
  /// Whether it has others than this.
  template <class Term>
  bool AnyBeside() const {
    ModelTerms others = *this;
    others.on<Term>() = false;
    return others.any();
  }
  /// Those whose parameters are fitted.
  static ModelTerms Of(const Terms::States& states) {
    ModelTerms terms;
    Terms::ForEach([&]<class Term>() { terms.on<Term>() = states.Term::on(); });
    return terms;
  }

 private:
  bool on_[Terms::kCount] = {};
};

}  // namespace chequer

#endif  // CHEQUER_DETECT_TERMS
