#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "detect/common/board_geometry.h"
#include "detect/fit/board_equations.h"

namespace chequer {

// What the terms of a board's model have in common. Each is a struct of its parameters, in a file of its own that
// terms.h lists. It has
//   kColumns, kLanes     unknowns of its own; values that each lane is given for it,
//   Input                what all lanes are given for it,
//   on()                 whether the parameters are fitted,
//   Move(TermStep)       makes a step within what one may be, leaves in it what was made, and returns how far that is
//                        over what no longer counts,
// and, where it needs them,
//   SetInput, SetLanes(TermCorner, set)  write what lanes are given,
//   AddPrior(information, pull)          what is known beside the pixels (SetPrior()),
//   LightAt(board, LightThere)           what it makes of a cell's light at a point of the board.
// What it does to the light of pixels, with the derivatives, is its OnLanes (model_light-inl.h), in the same file: it
// is compiled once for each kind of vectors.

/// A corner whose lanes are set.
struct TermCorner {
  Eigen::Matrix2d by_pixel = Eigen::Matrix2d::Zero();  ///< derivative of the board by the image
  Eigen::Matrix2d lens = Eigen::Matrix2d::Zero();      ///< covariance of the lens's blur, cells²
  Eigen::Matrix2d way = Eigen::Matrix2d::Zero();       ///< the same of the board's way
  Eigen::Matrix2d blur = Eigen::Matrix2d::Zero();      ///< of a point's, to which terms add theirs
  Eigen::Matrix2d shading = Eigen::Matrix2d::Zero();   ///< of the blur that the board's shading has, as far as is known
  MarkerSize size;
  int row = 0, col = 0;

  bool even_dark() const { return IsDark(row, col); }
};

/// A step of Gauss-Newton.
struct TermStep {
  double* of = nullptr;                 ///< of the term's unknowns; Move() leaves what it has made of it
  const double* information = nullptr;  ///< on each of them, all others known
  double blur_px = 1;
  Eigen::Matrix2d board_by_pixel = Eigen::Matrix2d::Zero();  ///< in the board's middle

  template <class Unknowns>
  Unknowns As() const {
    return Eigen::Map<const Unknowns>(of);
  }

  /// In standard deviations, all others known, what no longer counts: what a shorter step leaves is of second order.
  /// Sharp shadows under wide blur else drift to widths that the second order of their blur does not hold for.
  static constexpr double kStillDeviations = 0.2;
  /// Leaves the step of an unknown as it was made, and returns that over what no longer counts.
  double Make(int unknown, double made, double still) const {
    of[unknown] = made;
    return std::min(std::abs(made) / still, std::abs(made) * std::sqrt(information[unknown]) / kStillDeviations);
  }
  /// The same of all unknowns: that of the one that counts most.
  template <class Unknowns>
  double Make(const Unknowns& made, const Unknowns& still) const {
    double most = 0;
    for (int i = 0; i < static_cast<int>(made.size()); ++i) most = std::max(most, Make(i, made[i], still[i]));
    return most;
  }
};

/// A prior of unknowns: its information, and that times how far off they are. @param known_to standard deviations.
template <class Unknowns, class Vector>
void SetPrior(const Unknowns& known_to, const Unknowns& off, Vector& information, Vector& pull) {
  information = known_to.cwiseProduct(known_to).cwiseInverse();
  pull = information.cwiseProduct(off);
}

/// The light of a point of the board: of what a cell has, the share that is left, and what is added, by phase.
struct LightThere {
  double share = 1;
  PhaseValues more{};

  float Of(float level, std::size_t phase) const { return (level - more[phase]) / static_cast<float>(share); }
};

/// Several terms: all that is made of their list.
template <class... Term>
struct TermList {
  static constexpr int kCount = sizeof...(Term);
  static constexpr int kColumns = (Term::kColumns + ...), kLanes = (Term::kLanes + ...);

  /// The parameters of all; it is each of them.
  struct States : Term... {
    LightThere LightAt(const Eigen::Vector2d& board) const {
      LightThere light;
      ForEach([&all = *this, &board, &light]<class T>() {
        const T& term = all;
        if constexpr (requires { term.LightAt(board, light); })
          if (term.on()) term.LightAt(board, light);
      });
      return light;
    }
    /// Whether cells of one level have different lights, as far as terms know.
    bool LightVaries() const {
      bool varies = false;
      ForEach([&all = *this, &varies]<class T>() {
        const T& term = all;
        if constexpr (requires(LightThere light) { term.LightAt(Eigen::Vector2d(), light); })
          varies = varies || term.on();
      });
      return varies;
    }
  };

  struct Inputs : Term::Input... {};

  /// What the terms before one have.
  struct Before {
    int terms = 0, columns = 0, lanes = 0;
  };
  template <class T>
  static constexpr Before BeforeTerm() {
    Before all, before;
    ((std::is_same_v<T, Term> ? void(before = all) : void(),
      all = {all.terms + 1, all.columns + Term::kColumns, all.lanes + Term::kLanes}),
     ...);
    return before;
  }
  /// visit<Term>() of each, in their order.
  template <class Visit>
  static void ForEach(const Visit& visit) {
    (visit.template operator()<Term>(), ...);
  }
};

}  // namespace chequer
