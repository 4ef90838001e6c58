#pragma once

#include <vector>

namespace chequer {

/// Finds places for labels in a picture so that none covers another: each as near as can be to where it is wanted,
/// above or below it, and inside the picture.
class LabelLayout {
 public:
  struct Box {
    double left = 0, top = 0, width = 0, height = 0;
  };

  /// @param picture where labels may lie.
  explicit LabelLayout(const Box& picture) : picture_(picture) {}
  /// Takes the free place nearest to `wanted`, which has its size; `wanted`, moved into the picture, where nothing is
  /// free.
  Box Take(Box wanted);

 private:
  const Box* Covered(const Box& box) const;

  Box picture_;
  std::vector<Box> taken_;
};

}  // namespace chequer
