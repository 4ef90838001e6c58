#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "chequer/geometry.h"
#include "detect/common/board_geometry.h"
#include "detect/common/fixed_vector.h"
#include "detect/common/visibility.h"
#include "detect/fit/alike_edges.h"
#include "detect/fit/bent_paper.h"
#include "detect/fit/blur_shape.h"
#include "detect/fit/board_equations.h"
#include "detect/fit/edge_spread.h"
#include "detect/fit/fitted_board.h"
#include "detect/fit/ink_register.h"
#include "detect/fit/model_equations.h"
#include "detect/fit/model_kernel.h"
#include "detect/fit/shading.h"
#include "detect/fit/shadow_edge.h"
#include "detect/fit/terms.h"

namespace chequer {

using CornerFlags = std::array<bool, kMaxCorners>;
inline bool AnyOf(const CornerFlags& corners) {
  return std::find(corners.begin(), corners.end(), true) != corners.end();
}

/// What is fitted of a board: the state of Gauss-Newton.
struct BoardModel : Terms::States {
  BoardGeometry geometry;
  std::vector<PhaseValues> levels;
  bool own_levels = false;  ///< levels are those of each corner's quadrants, not the cells'
  NoiseModel noise;
  double blur_px = 1;
  BlurShape blur_shape;  ///< of the plain model; where motion may be a term, that has it
  EdgeSpread edges;
  Eigen::Vector2d blue_offset = Eigen::Vector2d::Zero();  ///< of the blue ink off the black one, cells

  /// No term changes the light that falls on its cells, and their levels are the cells'.
  bool LitEvenly() const { return !own_levels && !LightVaries(); }
  /// The plain model has all of it: a dot gain that is known is a part of that, too.
  static bool IsPlain(const Terms::States& terms) {
    return !terms.ink && !ModelTerms::Of(terms).AnyBeside<DotGainTerm>();
  }
};

/// All that belongs to one fit of a board (BoardFit), and to no other.
struct BoardRun {
  /// How the image samples the board.
  struct View {
    MarkerSize size;
    double cell_ratio = 1;     ///< of a cell, height over width
    bool overexposed = false;  ///< much of some light cell is saturated
    int channels = 1;
    int red_phase = -1;
    std::array<int, 4> channel_of_phase{};
    EdgeTally edge_tally;  ///< of others that the camera has shown
  };
  /// Which model is fitted, and which may be.
  struct TermsOn {
    bool wide = false;            ///< blurred so widely, or so unevenly, that cells beyond a corner's own four count
    bool look_farther = false;    ///< the model with all its terms is fitted
    bool rough = false;           ///< by some of the pixels, so far
    bool may_move = true;         ///< motion may be one
    bool plain_only = false;      ///< none of them may be fitted
    bool sure_of_motion = false;  ///< nothing else makes edges as uneven
  };
  /// What was done to the pixels' light.
  struct Light {
    FixedVector<float, kMaxCells> shading;  ///< that was taken out, by cell; empty: none
    PhaseValues veil{};                     ///< over that (see ShadedCells)
    bool bent = false;                      ///< it is bent
    Shading taken_out;                      ///< all in all, as the logarithm's slope and second order
    bool shade_twice = false;               ///< the first shading is not good enough for boards as large
    BoardGeometry collected_for;            ///< where the pixels were chosen
    double collected_for_blur_px = 1;       ///< for which blur, the reach of a motion included
    /// The pixels' weights fade out by where the board lies. Not before it has come near: where it was thought to lie,
    /// there are its pixels.
    bool fades = false;
    bool beside_hidden = false;  ///< and towards hidden corners: pixels there may show what hides these
    bool few = false;            ///< of large cells, the pixels are those that the model with all its terms looks at
    double window_blur_px = 1;   ///< by which the board's rim is kept out of the pixels
  };
  /// The last step.
  struct Step {
    BoardEquations::Vector moves = BoardEquations::Vector::Zero();
    BoardGeometry::Parameters moved = BoardGeometry::Parameters::Zero();  ///< by all steps so far
    double gain = 0;                                                      ///< how much Σ w r² falls by it
    double corner_px = 0;                                                 ///< the farthest that a corner moved
    double blur_share = 0;                                                ///< by which the blur changed
    BlurShape placed_shape;  ///< of the blur, with which the corners were placed for it
    WayInBlur placed_way;    ///< of that
    BlurShape start_shape;   ///< that was known before
    double shape_gain = 0;   ///< how much Σ w r² falls by another one
    double terms = 0;        ///< of the terms, over what no longer counts
    InkRegister::Step inks;  ///< what followed it where inks may lie out of register
  };
  /// What the fit tells beside its result.
  struct Told {
    bool settled = false;       ///< the last step moved next to nothing
    double square_left = 0;     ///< of the way that more steps would lead, standard deviations
    bool sums_gone = false;     ///< the plain kernel's are no longer those of that step
    double pixel_variance = 1;  ///< in units of the noise
    double variance = 1;        ///< the same, or what the corners' places say where that is more
    double misfit_spread = 1;
    std::optional<EdgeGroups> along_pixels;  ///< edges that follow the pixels
    /// Of corners that lie alike: AlikePlaces::Shared() over the root of how much they do; and that (AlikePhases).
    double shared_by_corners = 0, corners_alike = 1;
    double unexplained_shifts = 0;
    std::array<double, kMaxCorners> misfit{};  ///< of a corner's pixels, variances; far off where it has none
    double cell_px = 0;                        ///< side of a cell in the board's middle
    std::vector<LitPart> lit_parts;
    std::vector<PhaseValues> cell_levels;  ///< of own levels, those of the cells
  };
  struct Bend {
    std::optional<BentPaper> found;      ///< by the last fit
    std::optional<BentPaper> taken_out;  ///< of the pixels
    bool turns_over_rows = false;        ///< of the start
  };
  /// Where inks may lie out of register; else empty.
  struct Inks {
    Eigen::Vector2d register_cells = Eigen::Vector2d::Zero();
    /// By corner, as InkRegister::Corner has them.
    std::array<Eigen::Vector2f, kMaxCorners> blue_shares = Zeros<Eigen::Vector2f, kMaxCorners>();
    CornerFlags beside_yellow{};
    PhaseValues yellow_variance{};  ///< of pixels beside yellow cells, as the place of that ink is not known
  };
  /// What the model with all its terms knows of cells beyond a corner's four.
  struct CellsAround {
    std::vector<ModelEquations::LevelsAround16> levels;  ///< by corner
    std::vector<PhaseValues> beside;  ///< by cell and a ring around the board; only the ring has values
  };

  std::uint64_t number = 0;  ///< tells it from others
  View view;
  BoardModel model;
  TermsOn terms;
  Visibility visibility;  ///< corners that show are used; cells show of which nothing else shines into the pixels
  Light light;
  Step step;
  Told told;
  FittedBoard result;
  Bend bend;
  Inks inks;
  // What the kernels and equations are given.
  KernelInput plain_input;
  ModelInput model_input;
  CellsAround around;

  /// Whether a corner is used, or may come to be used: it is neither outside the image, nor covered, nor left out.
  bool MayUse(int corner) const {
    const Hidden hidden = visibility.OfCorner(corner);
    return hidden == Hidden::kNot || hidden == Hidden::kMisfit || hidden == Hidden::kFlat;
  }
};

}  // namespace chequer
