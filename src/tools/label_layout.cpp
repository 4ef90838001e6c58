#include "tools/label_layout.h"

#include <algorithm>
#include <cmath>

namespace chequer {

const LabelLayout::Box* LabelLayout::Covered(const Box& box) const {
  for (const Box& other : taken_)
    if (box.left < other.left + other.width && other.left < box.left + box.width &&
        box.top < other.top + other.height && other.top < box.top + box.height)
      return &other;
  return nullptr;
}

LabelLayout::Box LabelLayout::Take(Box wanted) {
  const double right = picture_.left + picture_.width - wanted.width,
               bottom = picture_.top + picture_.height - wanted.height;
  wanted.left = std::clamp(wanted.left, picture_.left, std::max(picture_.left, right));
  wanted.top = std::clamp(wanted.top, picture_.top, std::max(picture_.top, bottom));
  // From label to label, downwards and upwards.
  Box below = wanted, above = wanted;
  while (const Box* other = Covered(below)) below.top = other->top + other->height;
  while (const Box* other = Covered(above)) above.top = other->top - above.height;
  const bool fits_below = below.top <= bottom, fits_above = above.top >= picture_.top;
  Box best = wanted;
  if (fits_below && (!fits_above || below.top - wanted.top <= wanted.top - above.top))
    best = below;
  else if (fits_above)
    best = above;
  taken_.push_back(best);
  return best;
}

}  // namespace chequer
