#include "detect/deferred_places.h"

#include <algorithm>
#include <tuple>

namespace chequer {

void DeferredPlaces::Defer(const Eigen::Vector2f& at, float reach, int waited) {
  deferred_.push_back({at, reach, waited + 1});
}

void DeferredPlaces::EndImage() {
  if (deferred_.size() > kMost) {
    // Not stable_sort, which allocates; and so that the order does not depend on the sort.
    std::sort(deferred_.begin(), deferred_.end(), [](const Place& a, const Place& b) {
      return std::tuple(b.waited, a.at.x(), a.at.y()) < std::tuple(a.waited, b.at.x(), b.at.y());
    });
    deferred_.resize(kMost);
  }
  waiting_.swap(deferred_);
  deferred_.clear();
}

void DeferredPlaces::Clear() {
  waiting_.clear();
  deferred_.clear();
}

}  // namespace chequer
