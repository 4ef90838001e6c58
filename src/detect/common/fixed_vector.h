#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "chequer/check.h"

namespace chequer {

/// Up to kMost values that lie in the object itself: objects that hold some may lie in vectors whose memory is used
/// again.
template <class T, std::size_t kMost>
class FixedVector {
 public:
  FixedVector() {}  // not defaulted: values beyond the size have none
  FixedVector(const FixedVector& other) : size_(other.size_) { std::copy(other.begin(), other.end(), begin()); }
  FixedVector& operator=(const FixedVector& other) {
    size_ = other.size_;
    if (this != &other) std::copy(other.begin(), other.end(), begin());
    return *this;
  }

  /// @pre size ≤ kMost.
  void Assign(std::size_t size, const T& value) {
    CHEQUER_CHECK(size <= kMost, "more values than there is room for");
    size_ = size;
    std::fill(begin(), end(), value);
  }

  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  T* data() { return values_.data(); }
  const T* data() const { return values_.data(); }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }

 private:
  std::size_t size_ = 0;
  std::array<T, kMost> values_;
};

}  // namespace chequer
