#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace chequer {

/// Where something was left undone in the image before, because its budget did not last. It goes first in the next
/// image, the longest waiting first, so that nobody starves. A place is forgotten with the next image, unless something
/// is left undone there again. Bounded: of too many, those that have waited least are forgotten.
class DeferredPlaces {
 public:
  /// Places that are kept (a guess: no image has as many boards).
  static constexpr std::size_t kMost = 1024;

  /// Images on end in which something around a point was left undone, before this one.
  int Waited(const Eigen::Vector2f& at) const {
    int waited = 0;
    for (const Place& place : waiting_)
      if (place.waited > waited && (place.at - at).squaredNorm() < place.reach * place.reach) waited = place.waited;
    return waited;
  }
  /// Something in this image is left undone. @param reach how far it may move until the next image, px. @param waited
  /// as Waited() says.
  void Defer(const Eigen::Vector2f& at, float reach, int waited);
  /// The image is done: what was deferred in it waits.
  void EndImage();
  /// Nothing waits any more.
  void Clear();

  std::size_t size() const { return waiting_.size(); }

 private:
  struct Place {
    Eigen::Vector2f at = Eigen::Vector2f::Zero();  ///< image pixels
    float reach = 0;
    int waited = 0;
  };
  std::vector<Place> waiting_;   ///< since the image before
  std::vector<Place> deferred_;  ///< in this image
};

}  // namespace chequer
