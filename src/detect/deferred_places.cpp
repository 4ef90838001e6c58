#include "detect/deferred_places.h"

#include <algorithm>

namespace chequer {

void DeferredPlaces::Defer(const Eigen::Vector2f& at, float reach, int waited) {
  deferred_.push_back({at, reach, waited + 1});
}

void DeferredPlaces::EndImage() {
  if (deferred_.size() > kMost) {
    std::stable_sort(deferred_.begin(), deferred_.end(),
                     [](const Place& a, const Place& b) { return a.waited > b.waited; });
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
